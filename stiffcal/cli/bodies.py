"""Several tracked bodies, as `identify` shows them: each joint by itself, and the Cartesian stiffness at full poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.cli.answers import Document
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import significant

if TYPE_CHECKING:
    from rich.console import Console

_LOADS = dict(zip(("tx", "ty", "tz", "rx", "ry", "rz"), ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz"), strict=True))
COMPONENTS = ("rx", "ry", "rz", "tx", "ty", "tz")


def show_joints(console: Console, joints: Sequence[Document]) -> None:
    """Draw which of each joint's six displacements rise above the noise, and the stiffness of those that do.

    Parameters
    ----------
    console : where to.
    joints : ``joints_by_themselves`` of the `identify` document.
    """
    table = plain_table("each joint by itself", "turn about x>", "y>", "z>", "shift along x>", "y>", "z>")
    for joint in joints:
        lines = {line["component"]: line for line in joint["lines"]}
        table.add_row(f"joint {joint['joint']}", *(_identified(lines[component]) for component in COMPONENTS))
    console.print(table)
    for joint in joints:
        if joint["couplings"]:
            told = ", ".join(f"{moved} of {_LOADS[load]}" for moved, load in joint["couplings"])
            console.print(f"joint {joint['joint']}: of its whole 6×6, these rise above the noise too: {told}")
    console.print("N·m/rad and N/m; –: within the noise; ~: a curve, not a straight line")


def _identified(line: Document) -> str:
    if not line["above_noise"]:
        return "–"
    return ("~" if line["curved"] else "") + significant(1.0 / line["compliance"])


def show_cartesian(console: Console, found: Sequence[Document]) -> None:
    """Draw the diagonal of the Cartesian stiffness at each pose where wrench and displacement are full.

    Parameters
    ----------
    console : where to.
    found : ``cartesian_stiffness`` of the `identify` document.
    """
    table = plain_table("Cartesian stiffness", "way", "Fx/x>", "Fy/y>", "Fz/z>", "Tx/rx>", "Ty/ry>", "Tz/rz>")
    for one in found:
        for way, key in (("001, eq. 15", "equation_15"), ("from the compliance", "from_compliance")):
            table.add_row(one["run"], way, *(significant(one[key][k][k]) for k in range(6)))
    console.print(table)
    console.print(
        "N/m and N·m/rad at the target, base axes; eq. 15 takes displacements for exact, and their noise draws it "
        f"down, in the weakest direction to {_drawn_down(found)}"
    )


def _drawn_down(found: Sequence[Document]) -> str:
    """Return what noise leaves of eq. 15 in the weakest direction, pose by pose."""
    return ", ".join(f"{100.0 * one['over_noise'] / (1.0 + one['over_noise']):.0f} %" for one in found)

"""Several tracked bodies in `identify`: each joint separately, and the Cartesian stiffness in full poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import significant

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.identification.bodies.body_results import CartesianStiffnessResult, JointByItself, JointLineResult

_LOADS = dict(zip(("tx", "ty", "tz", "rx", "ry", "rz"), ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz"), strict=True))
COMPONENTS = ("rx", "ry", "rz", "tx", "ty", "tz")


def show_joints(console: Console, joints: Sequence[JointByItself]) -> None:
    """Draw which of each joint's six displacements rise above the noise, and the stiffness of those that do.

    Parameters
    ----------
    console : where to.
    joints : between tracked bodies.
    """
    table = plain_table("each joint separately", "rotation x>", "y>", "z>", "translation x>", "y>", "z>")
    for joint in joints:
        lines: dict[str, JointLineResult] = {line.component: line for line in joint.lines}
        table.add_row(f"joint {joint.joint}", *(_cell(lines[component]) for component in COMPONENTS))
    console.print(table)
    for joint in joints:
        if joint.couplings:
            couplings = ", ".join(f"{axis} of {_LOADS[load]}" for axis, load in joint.couplings)
            console.print(
                f"joint {joint.joint}: off-diagonal elements of the 6×6 compliance that are significant: {couplings}"
            )
    console.print("N·m/rad and N/m; –: not significant (below 3σ); ~: nonlinear")


def _cell(line: JointLineResult) -> str:
    if not line.above_noise or not line.compliance:
        return "–"
    return ("~" if line.curved else "") + significant(1.0 / line.compliance)


def show_cartesian(console: Console, poses: Sequence[CartesianStiffnessResult]) -> None:
    """Draw the diagonal of the Cartesian stiffness at each pose where wrench and displacement are full.

    Parameters
    ----------
    console : where to.
    poses : the Cartesian stiffness, pose by pose.
    """
    table = plain_table("Cartesian stiffness", "way", "Fx/x>", "Fy/y>", "Fz/z>", "Tx/rx>", "Ty/ry>", "Tz/rz>")
    for pose in poses:
        for direction, matrix in (
            ("Schneider et al. 2014, eq. 15", pose.equation_15),
            ("from the compliance", pose.from_compliance),
        ):
            table.add_row(pose.run, direction, *(significant(float(matrix[k, k])) for k in range(6)))
    console.print(table)
    console.print(
        "N/m and N·m/rad at the target, base axes; eq. 15 takes the displacements as exact, and their noise draws it "
        f"down, in the weakest direction to {_lost_shares(poses)}"
    )


def _lost_shares(poses: Sequence[CartesianStiffnessResult]) -> str:
    """Return the share that noise leaves of eq. 15 in the weakest direction, pose by pose."""
    return ", ".join(f"{100.0 * pose.over_noise / (1.0 + pose.over_noise):.0f} %" for pose in poses)

"""Friction of the drives as people read it: a row for each joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.answers import Document
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import NOT_KNOWN, interval, places, significant

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.experiments.friction.results import FrictionSection

SYMBOLS = ("coulomb", "viscous", "stribeck", "velocity", "exponent")


def friction_parameters(document: Document) -> set[str]:
    """Return the names of the parameters that the table of friction shows."""
    section = _section(document)
    if section is None:
        return set()
    laws, joints = set(section.effects or ()), {joint.joint for joint in section.joints}
    return {
        p["name"] for p in document["parameters"] if p["effect"] in laws and p["where"].get("joints", [0])[0] in joints
    }


def show_friction(console: Console, document: Document) -> None:
    """Draw coulomb, viscous and Stribeck terms joint by joint, and say of which the runs show nothing."""
    section = _section(document)
    if section is None or not section.joints:
        return
    shown = friction_parameters(document)
    by_name = {
        (p["where"]["joints"][0], p["name"].rsplit(".", 1)[-1]): p for p in document["parameters"] if p["name"] in shown
    }
    table = plain_table("friction of", "coulomb [N·m]>", "viscous [N·m·s/rad]>", "speeds [rad/s]>", "left, rms [N·m]>")
    more = plain_table("crawling", "stribeck [N·m]>", "velocity [rad/s]>", "exponent>")
    silent: dict[str, list[int]] = {}
    for joint in section.joints:
        number, name = joint.joint, f"joint {joint.joint} ({joint.name})"
        speeds = f"{significant(joint.lowest_speed)} … {significant(joint.highest_speed)}"
        cells = {symbol: _cell(by_name.get((number, symbol))) for symbol in SYMBOLS}
        table.add_row(name, cells["coulomb"], cells["viscous"], speeds, significant(joint.rms))
        for symbol, term in joint.optional.items():
            if term.seen:
                more.add_row(name, cells["stribeck"], cells["velocity"], cells["exponent"])
            else:
                silent.setdefault(f"{symbol} friction is not seen: {term.why}", []).append(number)
    console.print(table)
    if more.row_count:
        console.print(more)
    for bearing in section.bearings or ():
        coulomb = bearing.coulomb, 1.96 * bearing.coulomb_std
        viscous = bearing.viscous, 1.96 * bearing.viscous_std
        console.print(
            f"joint {bearing.joint}: its drive's shaft turns with other joints too; the joint's own bearing adds "
            f"{interval(coulomb[0], coulomb[0] - coulomb[1], coulomb[0] + coulomb[1])} N·m and "
            f"{interval(viscous[0], viscous[0] - viscous[1], viscous[0] + viscous[1])} N·m·s/rad",
            soft_wrap=True,
        )
    for words, numbers in silent.items():
        console.print(f"{places({'joints': numbers})}: {words}", soft_wrap=True)


def _section(document: Document) -> FrictionSection | None:
    if not document.get("friction"):
        return None
    from stiffcal.documents import section_of
    from stiffcal.experiments.friction.results import FrictionSection

    return section_of(FrictionSection, document, "friction")


def _cell(parameter: Document | None) -> str:
    if parameter is None or parameter["value"] is None:
        return NOT_KNOWN
    if parameter["interval"] is None:
        return f"{significant(parameter['value'])} (held)"
    return interval(parameter["value"], *parameter["interval"])

"""Friction of the drives as people read it: a row for each joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import NOT_KNOWN, interval, places, significant
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.identification.fit_results import IdentifiedParameter
    from stiffcal.results.identify_result import IdentifyResult

SYMBOLS = ("coulomb", "viscous", "stribeck", "velocity", "exponent")


def friction_parameters(fit: IdentifyResult) -> set[str]:
    """Return the names of the parameters that the table of friction shows."""
    section = fit.friction
    if section is None:
        return set()
    laws, joints = set(section.effects or ()), {joint.joint for joint in section.joints}
    return {
        parameter.name
        for parameter in fit.parameters
        if parameter.effect in laws and (parameter.where.joints or [0])[0] in joints
    }


def show_friction(console: Console, fit: IdentifyResult) -> None:
    """Draw coulomb, viscous and Stribeck terms joint by joint, and say of which the runs show nothing."""
    section = fit.friction
    if section is None or not section.joints:
        return
    shown = friction_parameters(fit)
    by_name = {
        ((parameter.where.joints or [0])[0], parameter.name.rsplit(".", 1)[-1]): parameter
        for parameter in fit.parameters
        if parameter.name in shown
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
        coulomb = bearing.coulomb, NORMAL_95 * bearing.coulomb_std
        viscous = bearing.viscous, NORMAL_95 * bearing.viscous_std
        console.print(
            f"joint {bearing.joint}: its drive's shaft turns with other joints too; the joint's own bearing adds "
            f"{interval(coulomb[0], coulomb[0] - coulomb[1], coulomb[0] + coulomb[1])} N·m and "
            f"{interval(viscous[0], viscous[0] - viscous[1], viscous[0] + viscous[1])} N·m·s/rad",
            soft_wrap=True,
        )
    for words, numbers in silent.items():
        console.print(f"{places({'joints': numbers})}: {words}", soft_wrap=True)


def _cell(parameter: IdentifiedParameter | None) -> str:
    if parameter is None or parameter.value is None:
        return NOT_KNOWN
    if parameter.interval is None:
        return f"{significant(parameter.value)} (held)"
    low, high = parameter.interval
    return interval(parameter.value, low, high)

"""Links with rods, as `identify` and `check` show them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import deviation, share, significant
from stiffcal.quantity import quantity_of
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import estimate

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.identification.bodies.link_results import CoupledEstimate, CouplingResult, LinkResult, Way


def show_links(console: Console, links: list[LinkResult]) -> None:
    """Draw what the rods show of each link: what they carry, the compliance of its end, what they do not identify."""
    from stiffcal.identification.bodies.link_results import LINK_COMPLIANCE, compliance_units

    for link in links:
        tool_share = link.share_of_tool
        without_twist = "" if link.torsion.identifiable else ", its torsion not included"
        of_tool = (
            ""
            if tool_share is None
            else f"; {share(tool_share)} of the tool's deflection comes from the link{without_twist}"
        )
        console.print(f"{link.link}: {len(link.rods)} rods carry {', '.join(link.carried)}{of_tool}")
        as_beam = " (as a beam)" if link.compliance_structure == "beam" else ""
        table = plain_table(f"compliance of the link's end{as_beam}", "value, ± 95 %>", "")
        lowest, highest = link.compliance_interval
        units = compliance_units(link)
        for row, column, name, si_unit in LINK_COMPLIANCE:
            unit = units.of(quantity_of(si_unit))
            value, low, high = link.compliance[row][column], lowest[row][column], highest[row][column]
            value_text = "not identifiable"
            if value is not None and low is not None and high is not None:
                value_text = estimate(value, (low, high), unit.factor)
            table.add_row(name, value_text, unit.name)
        console.print(table)
        for sentence in link.not_identifiable:
            console.print(f"{link.link}: {sentence}", soft_wrap=True)
        for fault in link.faults:
            console.print(f"{link.link}: {fault.why}", soft_wrap=True)


def show_coupling(console: Console, coupling: CouplingResult) -> None:
    """Draw what each way makes of each parameter: as a stiffness, against tool and rods together."""
    ways = coupling.ways
    table = plain_table("parameter", *(f"{_HEADS[result.way]}>" for result in ways))
    for parameter in coupling.parameters:
        name = parameter["name"]
        cells = ["–" if name in result.left_out else _estimate(parameter[result.way], result.way) for result in ways]
        table.add_row(name, *cells)
    console.print(table)
    for result in ways:
        unidentified = len(result.not_identifiable)
        console.print(
            f"{result.says}: fit {deviation(result.rms)} rms, {unidentified or 'no'} parameters not identifiable"
        )


_HEADS = {
    "links-rigid": "links rigid",
    "tool-alone": "tool alone",
    "links-taken-out": "link deflection subtracted",
    "with-rods": "with rods, ± 95 %",
}


def _estimate(estimate: CoupledEstimate | None, way: Way) -> str:
    if estimate is None:
        return "not identifiable"
    spread = share(NORMAL_95 * estimate.std / abs(estimate.value)) if estimate.value else "–"
    if way == "with-rods":
        return f"{significant(estimate.value)} ± {spread}"
    off = "–" if estimate.against_rods is None else f"{100.0 * estimate.against_rods:+.1f} %"
    return f"{off} (± {spread})"

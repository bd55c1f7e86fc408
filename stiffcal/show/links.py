"""Links with rods, as `identify` and `check` show them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.quantity import quantity_of
from stiffcal.show.builder import PageBuilder, number
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import deviation, estimate, share, significant

if TYPE_CHECKING:
    from stiffcal.identification.bodies.link_results import CoupledEstimate, CouplingResult, LinkResult, Way


def add_links(made: PageBuilder, links: list[LinkResult]) -> None:
    """Add what the rods show of each link: what they carry, the compliance of its end, what they do not identify."""
    from stiffcal.identification.bodies.link_results import LINK_COMPLIANCE, compliance_units

    for link in links:
        tool_share = link.share_of_tool
        without_twist = "" if link.torsion.identifiable else ", its torsion not included"
        of_tool = (
            ""
            if tool_share is None
            else f"; {share(tool_share)} of the tool's deflection comes from the link{without_twist}"
        )
        made.say(f"{link.link}: {len(link.rods)} rods determine {', '.join(link.carried)}{of_tool}", "links")
        as_beam = " (as a beam)" if link.compliance_structure == "beam" else ""
        rows = []
        lowest, highest = link.compliance_interval
        units = compliance_units(link)
        for row, column, name, si_unit in LINK_COMPLIANCE:
            unit = units.of(quantity_of(si_unit))
            value, low, high = link.compliance[row][column], lowest[row][column], highest[row][column]
            value_text = "not identifiable"
            if value is not None and low is not None and high is not None:
                value_text = estimate(value, (low, high), unit.factor)
            rows.append((name, value_text, unit.name))
        made.table((f"compliance of the link's end{as_beam}", number("value, ± 95 %"), ""), rows)
        for sentence in link.not_identifiable:
            made.say(f"{link.link}: {sentence}", "links")
        for fault in link.faults:
            made.say(f"{link.link}: {fault.why}", "links")


def add_coupling(made: PageBuilder, coupling: CouplingResult) -> None:
    """Add what each way makes of each parameter: as a stiffness, against tool and rods together."""
    ways = coupling.ways
    rows = []
    for parameter in coupling.parameters:
        name = parameter["name"]
        cells = ("–" if name in result.left_out else _estimate(parameter[result.way], result.way) for result in ways)
        rows.append((name, *cells))
    made.table(("parameter", *(number(_HEADS[result.way]) for result in ways)), rows)
    for result in ways:
        unidentified = len(result.not_identifiable)
        made.say(
            f"{result.says}: fit {deviation(result.rms)} rms, {unidentified or 'no'} parameters not identifiable",
            "links",
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

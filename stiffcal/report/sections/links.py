"""Links measured with rods: what the rods read, how the link's end moved, the tool with and without the link (000)."""

from __future__ import annotations

from functools import partial

import numpy as np

from stiffcal.identification.bodies.link_results import (
    LINK_COMPLIANCE,
    CoupledEstimate,
    CouplingResult,
    LinkResult,
    Way,
    compliance_units,
)
from stiffcal.quantity import quantity_of
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    Items,
    Paragraph,
    PictureBlock,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    TableColumn,
)
from stiffcal.report.content import ReportContent
from stiffcal.report.figures import links as drawing
from stiffcal.report.link_pictures import LinkPicture
from stiffcal.uncertainty import NORMAL_95

ORDER = 53
_TITLE = "Links measured with rods"
_HEADS = {
    "links-rigid": "links rigid",
    "tool-alone": "tool alone",
    "links-taken-out": "link deflection subtracted",
    "with-rods": "tool and rods",
}


def section(content: ReportContent) -> ReportSection | None:
    """Lay out the pages of every link with rods; nothing where there are none."""
    pictures = content.link_pictures
    if not pictures:
        return None
    fit = content.identify
    link_results = {} if fit is None else {link.link: link for link in fit.links or ()}
    blocks: list[Block] = []
    for picture in pictures:
        if len(pictures) > 1:
            blocks.append(SubheadingBlock(picture.link))
        blocks += _of_link(picture, link_results.get(picture.link))
    if fit is not None and fit.coupling is not None:
        blocks += _coupling(fit.coupling)
    return ReportSection(_TITLE, tuple(blocks))


def _of_link(picture: LinkPicture, link_result: LinkResult | None) -> list[Block]:
    text = (
        f"{wording.count(len(picture.rods), 'rod')} on link {picture.link} measure bending and extension of the link "
        f"itself, without drives and bearings. Beam axes: x1 along the link from its clamped end, x3 along its "
        "joint’s axis made perpendicular to it, x2 perpendicular to both."
    )
    blocks: list[Block] = [Paragraph(text)]
    if link_result is not None:
        blocks.append(_compliance(picture, link_result))
    if picture.sentences:
        blocks.append(Items(picture.sentences))
    blocks.append(PictureBlock(partial(drawing.draw_rods, picture), _rods_caption(picture)))
    run_index = next(k for k, run in enumerate(picture.runs) if run.name == picture.bent_link.run)
    blocks.append(PictureBlock(partial(drawing.draw_end, picture, run_index), _end_caption(picture, run_index)))
    if any(picture.runs[number].tool is not None for number in picture.large_runs):
        blocks.append(PictureBlock(partial(drawing.draw_tool, picture), _tool_caption(picture)))
    blocks.append(PictureBlock(partial(drawing.draw_bent, picture), _bent_caption(picture)))
    return blocks


def _coupling(coupling: CouplingResult) -> list[Block]:
    """Lay out what measuring without the rods does to every parameter."""
    columns = [TableColumn("parameter", align="left", mono=True)]
    columns += [TableColumn(_HEADS[direction.way]) for direction in coupling.ways]
    rows = []
    for parameter in coupling.parameters:
        cells = [_estimate(parameter[direction.way], direction.way) for direction in coupling.ways]
        rows.append((parameter["name"], *cells))
    text = (
        "A test at the tool measures all compliances together, and can attribute one to another. The same load states "
        "identified in four ways; the first three compared with tool and rods together, with their own 95 % half-width."
    )
    return [
        SubheadingBlock("Influence of the rods"),
        Paragraph(text),
        TableBlock(
            tuple(columns),
            tuple(rows),
            "Difference from tool and rods together; a dash: not identifiable, or not in the model.",
        ),
    ]


def _estimate(estimate: CoupledEstimate | None, way: Way) -> str:
    if estimate is None or not estimate.value:
        return wording.DASH
    half = f"± {wording.share(NORMAL_95 * abs(estimate.std / estimate.value), 2)}"
    if way == "with-rods" or estimate.against_rods is None:
        return f"{wording.significant(estimate.value)} {half}"
    return f"{100.0 * estimate.against_rods:+.1f} % ({half})".replace("-", "−")


def _compliance(picture: LinkPicture, link_result: LinkResult) -> TableBlock:
    rows = []
    low, high = link_result.compliance_interval
    units = compliance_units(link_result)
    for row, column, text, si_unit in LINK_COMPLIANCE:
        shown = units.of(quantity_of(si_unit))
        unit, factor = shown.name, shown.factor
        value, ends = link_result.compliance[row][column], (low[row][column], high[row][column])
        if value is None or ends[0] is None or ends[1] is None:
            rows.append((text, "not identifiable", unit))
            continue
        half = 0.5 * factor * (ends[1] - ends[0])
        if half > abs(factor * value):
            rows.append((text, f"below {wording.significant(factor * ends[1], 2)}", unit))
            continue
        rows.append((text, wording.plus_minus(factor * value, half), unit))
    share = link_result.share_of_tool
    without_twist = "" if link_result.torsion.identifiable else ", its torsion not included"
    of_tool = (
        "" if share is None else f" {wording.share(share)} of the tool deflection comes from this link{without_twist}."
    )
    return TableBlock(
        (
            TableColumn("of the link’s end", align="left"),
            TableColumn("value"),
            TableColumn("unit", align="left"),
        ),
        tuple(rows),
        f"Compliance of the end of {picture.link}, ± 95 %, from rods and load alone; the deflection of the link can "
        f"then be predicted without rods.{of_tool}",
    )


def _rods_caption(picture: LinkPicture) -> str:
    text = "Change of the rods’ lengths over the force, filled markers: loading, open markers: unloading"
    text += "; lines: the fitted model." if picture.runs[picture.large_runs[0]].modelled is not None else "."
    for first, second in picture.opposite:
        reads = [float(np.abs(picture.runs[number].lengths[:, [first, second]]).max()) for number in picture.large_runs]
        run, size = picture.runs[picture.large_runs[int(np.argmax(reads))]], max(reads)
        asymmetry = np.abs(run.lengths[:, first] + run.lengths[:, second]).max()
        text += (
            f" {picture.rods[first]} and {picture.rods[second]} are on opposite sides: in run {run.name} they mirror "
            f"each other within {wording.share(float(asymmetry / size))} of their size."
        )
    return text


def _end_caption(picture: LinkPicture, run_index: int) -> str:
    run = picture.runs[run_index]
    unknown = [name for k, name in enumerate(drawing.COMPONENTS) if not np.isfinite(run.end[:, k]).any()]
    text = (
        f"Displacement of the outboard end of {picture.link} in run {run.name}, from the rods (markers, with the 95 % "
        f"half-width of one state) and by the tabulated compliance times the wrench on the link (lines)."
    )
    return text + (f" {wording.listing(unknown)}: not identifiable from these rods." if unknown else "")


def _tool_caption(picture: LinkPicture) -> str:
    chosen = [picture.runs[k] for k in picture.large_runs if picture.runs[k].tool is not None]
    first = chosen[0]
    text = (
        "Displacement of the tool along the force: measured, by the fitted model, and by the same model with the link "
        "rigid. Below: residual (markers), and contribution of the link alone (dashed)."
    )
    if first.without_link is None:
        return text + " The model contains no effect on this link: its deflection is attributed to other effects."
    assert first.with_link is not None
    shares = [float(np.abs(run.with_link - run.without_link).max()) for run in chosen if run.without_link is not None]  # type: ignore[operator]
    return text + f" The contribution of the link is up to {wording.length(max(shares))} in these runs."


def _bent_caption(picture: LinkPicture) -> str:
    bent = picture.bent_link
    largest = float(np.sqrt(np.sum(bent.displacement**2, axis=1)).max())
    return (
        f"Link {picture.link} in run {bent.run} under {wording.significant(abs(bent.force))} N, viewed along its two "
        f"transverse axes; displacement of its end: {wording.length(largest)}. Rods are drawn at their positions; the "
        f"line width shows the size of the reading."
    )

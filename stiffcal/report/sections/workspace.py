"""The map of the workspace that the campaign asks for: `[report.map]` in campaign.toml."""

from __future__ import annotations

from functools import partial

from stiffcal.compensation.map_result import MapResult
from stiffcal.quantity import LENGTH, LINEAR_STIFFNESS
from stiffcal.report import wording
from stiffcal.report.blocks import PictureBlock, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.workspace import draw_workspace

ORDER = 34
_TITLE = "Map of the workspace"


def section(content: ReportContent) -> ReportSection | None:
    """Lay out the map; its caption names the worst point."""
    found = content.workspace
    if found is None:
        return None
    return ReportSection(_TITLE, (PictureBlock(partial(draw_workspace, found), _caption(found)),))


def _caption(found: MapResult) -> str:
    text = (
        f"{found.target} in the {found.plane} plane at {wording.significant(float(found.levels[0]))} m: "
        f"{found.reached} of {len(found.points)} points reached."
    )
    if found.position_error is not None:
        low, high = (wording.length(float(end)) for end in found.position_error)
        text += f" Position error {low} to {high}."
    if found.stiffness is not None:
        unit = LINEAR_STIFFNESS.unit_for(map(float, found.stiffness))
        softest, stiffest = (wording.significant(unit.factor * float(end)) for end in found.stiffness)
        text += f" Stiffness {softest} to {stiffest} {unit.name}."
    worst = found.worst
    if worst is not None:
        place = ", ".join(wording.significant(LENGTH.usual.factor * float(value)) for value in worst.position)
        text += f" Largest error at ({place}) {LENGTH.usual.name}, base axes."
    return text

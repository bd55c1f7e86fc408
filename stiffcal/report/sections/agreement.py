"""Measured against predicted."""

from __future__ import annotations

from functools import partial

from stiffcal.measurements.rms import Rms
from stiffcal.report import wording
from stiffcal.report.blocks import LeftOut, PictureBlock, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.measured_against_predicted import MOST_POINTS, draw_measured_against_predicted

ORDER = 60
_TITLE = "Measured against predicted"


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the scatter about the diagonal."""
    states = content.states
    if states is None or not states.used.any():
        return LeftOut(_TITLE, "there are no load states to draw")
    if content.identify is None:
        return LeftOut(_TITLE, "no model has been fitted yet")
    by = f"in {content.held_out}" if states.predicted_heldout is not None else "by the fit itself (not validated)"
    quantity = "distance from the nominal position" if content.absolute_alone else "displacement"
    axes = f"{quantity} D, rotation R" if states.has_rotation else f"{quantity} D"
    caption = (
        f"Measured against predicted {by}, base axes: {axes}. Points on the diagonal: "
        "measured and predicted values are equal."
    )
    validation = content.validate
    if validation is not None:
        left = validation.relative.translation
        caption += f" Distance from the diagonal {wording.measure_text(_of_target(validation.rms))} rms"
        caption += (
            f", {wording.share(left)} of {'that' if content.absolute_alone else 'the deflection'}"
            if left is not None
            else ""
        )
        caption += f"; at most {wording.measure_text(_of_target(validation.max))}."
    n_used = int(states.used.sum())
    if n_used > MOST_POINTS:
        drawn = f"{wording.significant(MOST_POINTS)} of {wording.count(n_used, 'state')}"
        caption += f" About {drawn} are drawn, including those farthest from it."
    return ReportSection(_TITLE, (PictureBlock(partial(draw_measured_against_predicted, states), caption),))


def _of_target(rms: Rms) -> dict[str, float | None]:
    """Return the measures of the target's pose: those drawn here."""
    return {"translation": rms.translation, "rotation": rms.rotation}

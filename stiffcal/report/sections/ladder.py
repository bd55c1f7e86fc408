"""The ladder of fits: from no model to the noise floor."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from stiffcal.measurements.rms import Rms
from stiffcal.report import wording
from stiffcal.report.blocks import Block, LeftOut, Paragraph, PictureBlock, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.ladder import draw_ladder, leading_component
from stiffcal.report.figures.overview import MOST_RUNGS
from stiffcal.report.page_blocks import block_of
from stiffcal.results.history_results import HistoryEntry
from stiffcal.show.pages import page_of

ORDER = 15
_TITLE = "History of fits: from no model to the noise"
_MOST_STEPS = 9
# Captions of the measures' ladders; the first one drawn has its numbers in words.
_ALSO = {
    "translation": "History of fits: position of the target.",
    "rotation": "History of fits: measured rotations.",
    "motor_angle": "History of fits: angles of clamped motors.",
    "torque": "History of fits: torques of drives in motion.",
}


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out every fit with its error in held-out poses, next to the noise."""
    fits = [] if content.history is None else content.history.fits
    if content.history is None or not fits:
        return LeftOut(_TITLE, "the history contains no fit yet")
    zero = None if content.validate is None else content.validate.zero_model
    noise = content.known_noise or next((fit.noise for fit in reversed(fits) if fit.noise is not None), None)
    # The present fit is the last rung, also where an earlier model has been restored.
    present = None if content.identify is None else content.identify.fit_id
    drawn_fits = sorted(fits, key=lambda fit: fit.id == present)[-_MOST_STEPS:]
    blocks: list[Block] = []
    # the first page holds this very picture
    on_first_page = leading_component(drawn_fits) if len(fits) <= MOST_RUNGS else None
    if on_first_page is not None:
        blocks.append(Paragraph(_caption(content.held_out, drawn_fits, zero, noise, on_first_page)))
    for component, text in _ALSO.items():
        if component != on_first_page and any(wording.part(fit.fit_rms, component) is not None for fit in drawn_fits):
            caption = text if blocks else _caption(content.held_out, drawn_fits, zero, noise, component)
            blocks.append(PictureBlock(partial(draw_ladder, drawn_fits, zero, noise, component), caption))
    if not blocks and len(fits) == 1 and on_first_page is None:
        return LeftOut(_TITLE, "there is one fit, and no error in it")
    blocks += [block_of(block) for block in page_of(content.history).blocks]
    return ReportSection(_TITLE, tuple(blocks))


def _caption(held_out: str, fits: Sequence[HistoryEntry], zero: Rms | None, noise: Rms | None, component: str) -> str:
    text = f"Error in {held_out} for each fit, with the effects added to the model"
    last = next((fit for fit in reversed(fits) if wording.part(fit.heldout_rms, component) is not None), None)
    floor, start = wording.part(noise, component), wording.part(zero, component)
    if last is not None:
        reached = wording.part(last.heldout_rms, component)
        origin = f"from {_amount(component, start)} with no model " if start else ""
        text += f": {origin}down to {_amount(component, reached)} with fit {last.id}"
        if floor and reached:
            text += f", {wording.significant(reached / floor)} times the noise of {_amount(component, floor)}"
    return text + ("." if floor else ". No noise floor is drawn: the noise is unknown.")


def _amount(component: str, value: float | None) -> str:
    """Return an error with its unit."""
    return wording.measure_text({component: value})

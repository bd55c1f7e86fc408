"""The ladder of fits: from no model to the noise floor."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from stiffcal.measurements.rms import Rms
from stiffcal.report import wording
from stiffcal.report.blocks import Block, LeftOut, PictureBlock, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.ladder import draw_ladder
from stiffcal.results.history_results import HistoryEntry

ORDER = 15
_TITLE = "From no model to the noise: the ladder of fits"
_MOST_STEPS = 25


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out every fit with its error in held-out poses, next to the noise."""
    fits = [] if content.history is None else content.history.fits
    if not fits:
        return LeftOut(_TITLE, "the history holds no fit yet")
    zero = None if content.validate is None else content.validate.zero_model
    noise = None if content.validate is None else content.validate.noise
    noise = noise or next((fit.noise for fit in reversed(fits) if fit.noise is not None), None)
    # The present fit is the last rung, also where an earlier model has been restored.
    present = None if content.identify is None else content.identify.fit_id
    drawn_fits = sorted(fits, key=lambda fit: fit.id == present)[-_MOST_STEPS:]
    blocks: list[Block] = []
    if any(wording.part(fit.fit_rms, "translation") is not None for fit in drawn_fits):
        blocks.append(PictureBlock(partial(draw_ladder, drawn_fits, zero, noise), _caption(drawn_fits, zero, noise)))
    if any(wording.part(fit.heldout_rms, "rotation") is not None for fit in drawn_fits):
        text = "The same ladder for the measured rotations."
        blocks.append(PictureBlock(partial(draw_ladder, drawn_fits, zero, noise, "rotation"), text))
    if not blocks and len(fits) == 1:
        return LeftOut(_TITLE, "there is one fit, and no displacement in it")
    blocks.append(_table(fits))
    return ReportSection(_TITLE, tuple(blocks))


def _caption(fits: Sequence[HistoryEntry], zero: Rms | None, noise: Rms | None) -> str:
    text = "Error in held-out poses, fit by fit, each rung with what the model gained"
    last = next((fit for fit in reversed(fits) if wording.part(fit.heldout_rms, "translation") is not None), None)
    floor, start = wording.part(noise, "translation"), wording.part(zero, "translation")
    if last is not None:
        reached = wording.part(last.heldout_rms, "translation")
        origin = f"from {wording.length(start)} with no model " if start else ""
        text += f": {origin}down to {wording.length(reached)} with fit {last.id}"
        if floor and reached:
            text += f", {wording.digits(reached / floor)} times the noise of {wording.length(floor)}"
    return text + ("." if floor else ". No noise floor is drawn: noise cannot be judged.")


def _table(fits: Sequence[HistoryEntry]) -> TableBlock:
    columns = (
        TableColumn("fit", align="left"),
        TableColumn("time", align="left"),
        TableColumn("model", align="left", width=1.0),
        TableColumn("held-out, rms", align="right"),
        TableColumn("fit, rms", align="right"),
    )
    rows = tuple(_row(fit) for fit in fits)
    return TableBlock(columns, rows, "All fits of this campaign, oldest first (times in UTC).")


def _row(fit: HistoryEntry) -> tuple[str, ...]:
    time = fit.time.replace("T", " ").removesuffix("Z")
    model = wording.model_words(fit.model)
    if fit.origin == "foreign":
        model += " (not computed by you)"
    return (
        fit.id,
        time,
        model,
        wording.measure_text(fit.heldout_rms),
        wording.measure_text(fit.fit_rms),
    )

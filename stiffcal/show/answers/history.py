"""What `history` shows: every fit, what changed in its model, its errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.quantity import Units
from stiffcal.results.model_words import model_change, model_words
from stiffcal.show.builder import PageBuilder, number, wide
from stiffcal.show.effects import effect_words
from stiffcal.validation.schemes import held_out
from stiffcal.wording import deviation, listing

if TYPE_CHECKING:
    from stiffcal.model.summary import ModelSummary
    from stiffcal.presentation.values import Page
    from stiffcal.results.history_results import HistoryEntry, HistoryResult
    from stiffcal.show.options import ShowOptions

_NOT_YOURS = {"foreign": "not computed by you", "trusted place": "trusted place"}


def page(result: HistoryResult, options: ShowOptions) -> Page:
    """Return the table of fits, oldest first."""
    made = PageBuilder("History of fits")
    if not result.fits:
        made.say("no fit yet", "no-fit")
        return made.page()
    schemes = {fit.scheme for fit in result.fits if fit.heldout_rms is not None}
    left_out = held_out(schemes.pop() if len(schemes) == 1 else None)
    rows = _rows(result.fits)
    if result.not_fitted_yet is not None:
        rows.append(("now", "not fitted yet", _change(result.fits[-1].model, result.not_fitted_yet), "", ""))
    made.say(f"error: rms in {left_out}", "error-of-fits")
    titles = ("fit", "time (UTC)", wide("model"), number("error"), number("noise"))
    made.table(titles, rows, "Fits of this campaign, oldest first: the model, then what changed.")
    return made.page()


def _rows(fits: Sequence[HistoryEntry]) -> list[tuple[str, ...]]:
    units = Units.of_errors(rms for fit in fits for rms in (fit.heldout_rms, fit.noise))
    before: ModelSummary | None = None
    rows: list[tuple[str, ...]] = []
    for fit in fits:
        model = model_words(fit.model) if before is None else _change(before, fit.model)
        before = fit.model
        if fit.likely:
            model += f"; not certain: {listing(effect_words(one) for one in fit.likely)}"
        rows.append(
            (
                fit.id + ("" if fit.origin in (None, "own") else f" ({_NOT_YOURS[fit.origin]})"),
                fit.time.replace("T", " ")[:16],
                model,
                "unvalidated" if fit.heldout_rms is None else deviation(fit.heldout_rms, units),
                deviation(fit.noise, units),
            )
        )
    return rows


def _change(before: ModelSummary, after: ModelSummary) -> str:
    """Return what changed in the list of effects, or in their values or the balance."""
    if before.balance != after.balance:
        return model_words(after)
    return model_change(before, after) or "the same effects"

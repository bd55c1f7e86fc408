"""Compare the model with poses left out of the fit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.results.validate_result import ValidateResult
from stiffcal.stages.fit import up_to_date_fit_at_hand
from stiffcal.stages.steps import (
    VALIDATE,
    RunContext,
    up_to_date_states,
)
from stiffcal.stages.validation import current_validation, validate_now, with_present_verdict

if TYPE_CHECKING:
    from stiffcal.campaign.manifest.thresholds import ThresholdsFile


def validate_campaign(
    folder: Path, context: RunContext | None = None, model: Path | None = None, thresholds: ThresholdsFile | None = None
) -> ValidateResult:
    """Judge the present model in poses left out of the fit.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.
    model : another campaign's folder, whose fitted model is judged on this campaign's data instead.
    thresholds : for this answer; the manifest may only tighten them. The store keeps the verdict on the manifest's own.

    Returns
    -------
    ValidateResult
        Where nothing has changed since the last validation, that one with the present verdict.

    Raises
    ------
    InputError : the input is wrong.
    """
    context = context or RunContext()
    data = up_to_date_states(folder, context)
    if model is not None:
        from stiffcal.stages.other_model import validate_other_model

        return validate_other_model(data, Path(model), context, thresholds)
    identified, fit = up_to_date_fit_at_hand(data, context)
    current = current_validation(data, identified) or validate_now(data, identified, context, fit)
    result = with_present_verdict(data, identified, current, context, thresholds)
    return replace(result, origin=data.store.origin_of(VALIDATE))

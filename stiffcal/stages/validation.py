"""Compare the model with poses left out of the fit, and complete the history with it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal.documents import document_of
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.validate_result import ValidateResult
from stiffcal.stages.fit import fit_now, up_to_date_fit_at_hand
from stiffcal.stages.steps import (
    HELDOUT_STATES,
    HISTORY,
    VALIDATE,
    Ingested,
    RunContext,
    announce,
    kept_table,
    key_of,
    stored_validation,
)
from stiffcal.stages.threshold_verdict import check_thresholds

if TYPE_CHECKING:
    from stiffcal.campaign.manifest.thresholds import ThresholdsFile
    from stiffcal.identification.fitting.fit import Fit
    from stiffcal.store.store_place import Documents, Stored


def up_to_date_results(data: Ingested, context: RunContext) -> tuple[IdentifyResult, ValidateResult]:
    """Return the fit of the present model and its validation, both made first where missing or stale, by one fit.

    Raises
    ------
    InputError : the model cannot be fitted, or not be judged.
    """
    identified, fit = up_to_date_fit_at_hand(data, context)
    return identified, up_to_date_validation(data, identified, context, fit)


def up_to_date_validation(
    data: Ingested, identified: IdentifyResult, context: RunContext, fit: Fit | None = None
) -> ValidateResult:
    """Return the validation of the present fit, judging first where it is missing or stale.

    A verdict on the manifest's present thresholds stands as it was last given: `validate` and `batch` look at the
    baseline anew, who only shows the numbers does not.

    Parameters
    ----------
    data : the campaign. identified : its fit. context : progress and so on.
    fit : the fit itself where it is at hand; None: it is made again where it is needed.
    """
    current = current_validation(data, identified)
    if current is not None:
        same = current.thresholds == data.campaign.manifest.thresholds.written() and not data.uncounted
        return current if same else with_present_verdict(data, identified, current, context)
    announce("validate", "the present fit is not validated yet", data.campaign.folder, context)
    return validate_now(data, identified, context, fit)


def current_validation(data: Ingested, identified: IdentifyResult) -> ValidateResult | None:
    """Return the stored validation where it belongs to the present fit; its verdict may be of earlier thresholds."""
    stored = stored_validation(data.store)
    return stored if stored is not None and stored.key == _key(identified) else None


def _key(identified: IdentifyResult) -> str:
    return key_of(identified.key, "validate")


def with_present_verdict(
    data: Ingested,
    identified: IdentifyResult,
    stored: ValidateResult,
    context: RunContext,
    thresholds: ThresholdsFile | None = None,
) -> ValidateResult:
    """Return a stored validation with the verdict on the thresholds and the baseline as they are now.

    The store records a verdict that has changed; not one on a file's thresholds, which hold for this time.
    """
    result = stored.judged(check_thresholds(data, identified.parameters, stored, context, thresholds))
    if thresholds is None and not data.uncounted:
        document = document_of(result)
        if document != document_of(stored):  # results hold NaN, which is equal to nothing
            data.commit({}, {VALIDATE: document}, command="validate")
    return result


def validate_now(
    data: Ingested, identified: IdentifyResult, context: RunContext, fit: Fit | None = None
) -> ValidateResult:
    """Judge the present fit, write the result into the store and complete the history's entry.

    Parameters
    ----------
    identified : the fit as it is stored.
    fit : the fit itself where it is at hand; it is made again otherwise.
    """
    from stiffcal.identification.answers.state_tables import observed_table
    from stiffcal.identification.readings.state_loads import load_columns
    from stiffcal.results.validate_answer import validate_result
    from stiffcal.stages.experiments import (
        kept_of_kinds,
        merge_experiment_validations,
        validate_without_states,
        validated_experiments,
    )
    from stiffcal.validation.distances import distances_of
    from stiffcal.validation.elasticity import elasticity_of
    from stiffcal.validation.ladder import ladder_of
    from stiffcal.validation.validate import validate_fit

    fit = fit or fit_now(data, identified.loss, context)
    context.progress("fitting without each pose", None)
    experiments = validated_experiments(data)
    tables = {name: table for experiment in experiments for name, table in experiment.tables.items()}
    if fit is None:
        result = validate_without_states(experiments)
    else:
        validation = validate_fit(data.states, fit)
        result = merge_experiment_validations(validate_result(data.states, validation), experiments)
        distance = distances_of(fit)
        if distance is not None:
            context.progress("fitting the ladder", None)
            result = replace(
                result,
                distance=distance,
                ladder=ladder_of(data.states, fit, distance),
                elasticity=elasticity_of(data.states, fit),
            )
        heldout = validation.heldout
        predicted = heldout.displacement - heldout.data.added - heldout.residual
        carried = load_columns(data.states, fit.robot)
        tables[HELDOUT_STATES] = observed_table(data.states, heldout.data, predicted, heldout.residual, carried)
        tables[kept_table(HELDOUT_STATES, identified.key)] = tables[HELDOUT_STATES]
    tables |= kept_of_kinds(tables, identified.key)
    result = replace(
        result,
        suspects=identified.suspects,
        suspects_not_checked=identified.suspects_not_checked,
        fit_id=identified.fit_id,
        key=_key(identified),
        registration=data.registration,
    )
    result = result.judged(check_thresholds(data, identified.parameters, result, context))
    document = document_of(result)

    def with_history(stored: Stored) -> Documents:
        history = stored(HISTORY)
        if history is None:
            return {VALIDATE: document}
        judged = {"heldout_rms": document["rms"], "scheme": document["scheme"]}
        entries = [entry | (judged if entry.get("id") == identified.fit_id else {}) for entry in history["fits"]]
        return {VALIDATE: document, HISTORY: history | {"fits": entries}}

    data.commit(tables, with_history, command="validate")
    return result

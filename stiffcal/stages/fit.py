"""Fit the model to the load states, and write the fit into the store and the history."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal.documents import Document, document_of
from stiffcal.errors import InputError, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.rms import Rms
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.results.history_results import StoredFit
from stiffcal.results.identify_result import IdentifyResult, Loss
from stiffcal.stages.history import NO_HISTORY
from stiffcal.stages.steps import (
    FIT_STATES,
    HISTORY,
    IDENTIFY,
    Ingested,
    RunContext,
    announce,
    kept_table,
    key_of_fit,
    key_of_table,
    model_text,
    stored_fit,
)
from stiffcal.stages.stored import FIT_ID
from stiffcal.store.index import FOREIGN, OWN

CONFIRMED = ("model", "fit_rms", "noise", "loss", "model_text")
"""What of a foreign entry of the history must be equal to a fit of the user's own."""

if TYPE_CHECKING:
    from stiffcal.identification.fitting.fit import Fit
    from stiffcal.model.assembled.composite import CompliantRobot
    from stiffcal.store.store_place import Documents, Stored


def up_to_date_fit(data: Ingested, context: RunContext) -> IdentifyResult:
    """Return the fit of the present model, fitting first where it is missing or stale."""
    return up_to_date_fit_at_hand(data, context)[0]


def up_to_date_fit_at_hand(data: Ingested, context: RunContext) -> tuple[IdentifyResult, Fit | None]:
    """Return the same, with the fit itself where it was made now."""
    stored = stored_fit(data.store)
    # A fit with the robust loss counts as present too: the user asked for it.
    loss = stored.loss if stored else "linear"
    if stored is not None and stored.key == key_of_fit(data, loss):
        return stored, None
    reason = (
        "nothing is fitted yet" if stored is None else "the model or the load states have changed since the last fit"
    )
    announce("identify", reason, data.campaign.folder, context)
    fit = fit_now(data, loss, context)
    return store_fit(data, fit, loss), fit


def current_fit(data: Ingested, loss: str) -> IdentifyResult | None:
    """Return the stored fit where its key is the present one."""
    stored = stored_fit(data.store)
    return stored if stored is not None and stored.key == key_of_fit(data, loss) else None


def fit_again(data: Ingested, identified: IdentifyResult, context: RunContext) -> Fit | None:
    """Make the stored fit again, for what it holds beyond its answer; None where the campaign holds no load states.

    It starts at the stored values and ends there, within what convergence leaves open.

    Parameters
    ----------
    data : the campaign. identified : the present fit, as it is stored. context : progress and so on.
    """
    from stiffcal.model.catalogue.campaign_effects import placed_robot

    robot = placed_robot(data.campaign).with_values(identified.robot_values())
    return fit_now(data, identified.loss, context, robot)


def fit_now(data: Ingested, loss: str, context: RunContext, start: CompliantRobot | None = None) -> Fit | None:
    """Fit the load states, without looking at the store; None where the campaign holds other experiments alone.

    Parameters
    ----------
    data : the campaign. loss : of the residuals. context : progress and so on.
    start : the robot with the values from which the fit starts; None: those of the model file and of its kinds.

    Raises
    ------
    InputError : no load state can be used, or the model holds nothing to fit.
    """
    from stiffcal.identification.fitting.identify import Settings, identify_parameters
    from stiffcal.model.assembled.assembly import fixed_parameters
    from stiffcal.reduction.set_aside.displacement_measured import check_displacement_measured
    from stiffcal.stages.experiments import robot_to_fit

    campaign = data.campaign
    if len(data.states) == 0 and data.non_load:
        return None
    from stiffcal.model.catalogue.campaign_effects import placed_robot

    robot = placed_robot(campaign)
    if not robot.placed:
        raise InputError.at(
            FaultCode.MODEL_UNSUITABLE,
            "model.toml",
            "effects",
            "the model contains no effect",
            "add one: stiffcal add DIR EFFECT --all",
        )
    if not data.states.used.any():
        causes = [SetAsideCode(code).short_text for code in dict.fromkeys(data.states.set_aside_code.tolist())]
        reason = f"no load state can be used: {'; '.join(causes)}"
        mend = "stiffcal check names each; repeat these runs, or remove them from campaign.toml"
        raise InputError.at(FaultCode.STATES_MISSING, "campaign.toml", "runs", reason, mend)
    raise_faults(check_displacement_measured(data.states))  # a store of an earlier version may hold none
    settings = Settings(loss=loss, fixed=fixed_parameters(campaign.model))
    return identify_parameters(data.states, start or robot_to_fit(data), settings, context.progress)


def store_fit(data: Ingested, fit: Fit | None, loss: Loss) -> IdentifyResult:
    """Write a fit into the store, with what other experiments add, and into the history; return it.

    The same model of the same states is one entry of the history, however often it is fitted.

    Parameters
    ----------
    fit : of the load states; None where there are none.
    """
    from stiffcal.campaign.robot.geometry import planned_rows
    from stiffcal.identification.answers.agreement import agreement_of_experiments
    from stiffcal.identification.answers.state_tables import observed_table
    from stiffcal.identification.answers.stated_geometry import geometry_found
    from stiffcal.identification.fitting.identify import Settings
    from stiffcal.judgement.suspects import suspects_in
    from stiffcal.model.assembled.assembly import fixed_parameters
    from stiffcal.results.identify_answer import identify_result
    from stiffcal.stages.experiments import (
        fit_experiments,
        identify_without_states,
        kept_of_kinds,
        merge_experiment_fits,
    )

    experiments = fit_experiments(data)
    tables = {name: table for experiment in experiments for name, table in experiment.tables.items()}
    if fit is None:
        result = identify_without_states(data.campaign.model.balance, experiments)
    else:
        expected, sentence = _expectation(data, fit)
        of_states = replace(identify_result(fit, data.states), expected_rms=expected, expected_error=sentence)
        found = geometry_found(fit, planned_rows(data.campaign.robot, data.campaign.chain))
        of_states = of_states if found is None else replace(of_states, geometry=found)
        result = merge_experiment_fits(of_states, experiments)
        tables[FIT_STATES] = observed_table(data.states, fit.data, fit.predicted, fit.residual)
        tables[kept_table(FIT_STATES, key_of_fit(data, loss))] = tables[FIT_STATES]
        agreement = agreement_of_experiments(
            data.states, fit, Settings(loss=loss, fixed=fixed_parameters(data.campaign.model))
        )
        result = replace(result, agreement=agreement or None)
        suspects, not_checked = suspects_in(data.campaign, data.states, loss, present=fit)
        result = replace(result, suspects=suspects, suspects_not_checked=not_checked)
    tables |= kept_of_kinds(tables, key_of_fit(data, loss))
    result = replace(result, loss=loss, key=key_of_fit(data, loss), registration=data.registration)
    numbered = result

    def with_history(stored: Stored) -> Documents:
        nonlocal numbered
        present, history = stored(IDENTIFY), stored(HISTORY) or dict(NO_HISTORY)
        if present is not None and present.get("key") == result.key and "fit_id" in present:
            # Another process has made the same fit meanwhile: it stands in the history already.
            numbered = replace(result, fit_id=present["fit_id"])
            return {IDENTIFY: document_of(numbered)}
        fits = history.get("fits", [])
        entry = _entry(result, data)
        same = _same_fit(fits, entry)
        entry["id"] = next_fit_id(history) if same is None else same["id"]
        numbered = replace(result, fit_id=entry["id"])
        if same is not None and same.get("origin", OWN) != FOREIGN:
            return {IDENTIFY: document_of(numbered)}
        entries = [row for row in fits if row is not same]
        return {IDENTIFY: document_of(numbered), HISTORY: history | {"fits": [*entries, entry]}}

    data.commit(tables, with_history, command="identify")
    return numbered


def _same_fit(fits: list[Document], entry: Document) -> Document | None:
    """Return the entry of the history that is the same fit as a new one, None where it is to be appended.

    Of a fit that came with somebody else's store the history keeps their entry, and the user's own is appended. That
    one becomes foreign where the user's record of trust is lost or cannot be written: of two foreign entries with these
    very numbers the last one is the user's own again. Without that, each command would append one more.
    """
    with_id = [row for row in fits if isinstance(row.get("id"), str) and FIT_ID.fullmatch(row["id"])]
    same = [row for row in with_id if row.get("key") == entry["key"]]
    own_fits = [row for row in same if row.get("origin", OWN) != FOREIGN]
    if own_fits:
        return own_fits[-1]
    equal = [row for row in same if all(row.get(name) == entry[name] for name in CONFIRMED)]
    return equal[-1] if len(equal) > 1 else None


def next_fit_id(history: Document) -> str:
    """Return the number of the next fit; what is no number of a fit does not count."""
    ids = [str(entry.get("id")) for entry in history.get("fits", [])]
    return str(1 + max((int(text) for text in ids if FIT_ID.fullmatch(text)), default=0))


def _entry(result: IdentifyResult, data: Ingested) -> Document:
    """Return a fit's entry of the history, without its id."""
    from stiffcal.identification.answers.before_after import estimated_parameters

    return document_of(
        StoredFit(
            id="",
            time=time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            model=result.model,
            heldout_rms=None,
            fit_rms=result.rms,
            noise=result.noise,
            loss=result.loss,
            key=result.key,
            model_text=model_text(data.campaign),
            parameters=estimated_parameters(result.parameters),
            states_key=key_of_table(data.table),
        )
    )


def _expectation(data: Ingested, fit: Fit) -> tuple[Rms | None, str]:
    """Return the error to expect in new poses: the numbers, and one sentence."""
    from stiffcal.identification.readings.state_kinds import measured_kinds
    from stiffcal.validation.heldout import heldout_residuals
    from stiffcal.validation.validate import rms_of

    heldout = heldout_residuals(data.states, fit)
    if heldout.scheme == "none":
        return None, "the error in new poses cannot be estimated from a single pose: measure more poses"
    if fit.data.absolute.any() and fit.dof <= 0:
        return None, "as many parameters as coordinates: no error can be estimated; measure more poses"
    texts = []
    for kind, members in measured_kinds(heldout.data):
        own = heldout.data.subset(members)
        error, whole = (Rms.of(rms_of(values[:, members], own)) for values in (heldout.residual, heldout.displacement))
        texts.append(kind.expected_error(error, whole, Rms.of(fit.noise_length)))
    rms = Rms.of(rms_of(heldout.residual, heldout.data))
    return rms, "; ".join(filter(None, texts)) or "no displacement was measured: no error can be estimated"

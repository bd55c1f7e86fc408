"""Is the model good enough, and if not, which physical effect is missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

from stiffcal.diagnosis.drive_parts import drive_parts
from stiffcal.diagnosis.merging import PartialDiagnosis, merged_diagnosis
from stiffcal.diagnosis.results import DiagnoseResult, SearchPace, UntestableEffect, WithSuspects
from stiffcal.documents import Origin, document_of
from stiffcal.experiments.results import HeldoutSection
from stiffcal.measurements.rms import Rms
from stiffcal.store.document_shape import result_from
from stiffcal.workflow.diagnose_rows import diagnose_rows
from stiffcal.workflow.evidence import (
    DIAGNOSES,
    EVIDENCE,
    REFITS,
    ROW_REFITS,
    diagnoses_with,
    evidence_of,
    refit_columns,
)
from stiffcal.workflow.experiments import robot_to_fit
from stiffcal.workflow.identify import up_to_date_fit
from stiffcal.workflow.load_search import diagnosis_of, search_now
from stiffcal.workflow.steps import Ingested, RunContext, key_of, stored_document, up_to_date_states
from stiffcal.workflow.suspects import described, suspicion_of

if TYPE_CHECKING:
    from stiffcal.arrays import Booleans
    from stiffcal.diagnosis.drive_parts import DrivePart
    from stiffcal.diagnosis.refits import StoredRefits
    from stiffcal.diagnosis.search_results import Search
    from stiffcal.diagnosis.suspects.find import Suspicion
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.store.trial import TrialResults
    from stiffcal.workflow.diagnose_rows import RowDiagnoses
    from stiffcal.workflow.evidence import Columns

DIAGNOSE = "diagnose"
NOT_JUDGED = HeldoutSection(scheme="none", n_readings=0, rms={}, noise={}, zero_model={})


def diagnose_campaign(folder: Path, context: RunContext | None = None) -> DiagnoseResult:
    """Diagnose the present model.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.

    Returns
    -------
    DiagnoseResult
        Where nothing has changed since the last diagnosis, that one's.

    Raises
    ------
    InputError : the input is wrong.
    """
    import numpy as np

    from stiffcal.diagnosis.refits import StoredRefits, refits_of

    context = context or RunContext()
    data = up_to_date_states(folder, context)
    identified = up_to_date_fit(data, context)
    stored, _ = current_diagnosis(data, identified)
    if stored is not None:
        return replace(stored, origin=data.store.origin_of(DIAGNOSE))
    fit_id, key = identified.fit_id, diagnosis_key(data, identified)
    rows, in_model = diagnose_rows(data, context), _names_in_model(identified)
    if len(data.states) == 0:
        diagnosis = merged_diagnosis(rows.parts, in_model) if rows.parts else without_states(data, identified, context)
        diagnosis = replace(diagnosis, fit_id=fit_id, key=key)
        refitted = StoredRefits(key=key, entries=rows.entries)
        data.commit(
            {ROW_REFITS: rows.columns()},
            {DIAGNOSE: document_of(diagnosis), ROW_REFITS: document_of(refitted)},
            command="diagnose",
        )
        return replace(diagnosis, origin=cast(Origin, data.origin))
    loss = identified.loss
    suspicion = suspicion_of(data.campaign, data.states, loss, context.progress)
    sound = _without(data, suspicion)
    drives = drive_parts(sound.states, robot_to_fit(sound), _values(identified))
    if drives:
        return _diagnosis_of_drives(data, sound, drives, suspicion, identified, context)
    search = search_now(sound, loss, context)
    diagnosis = diagnosis_of(sound, search)
    context.progress("computing the evidence", 0.9)
    table, evidence = evidence_of(sound, search)
    diagnosis = replace(diagnosis, evidence=evidence, fit_id=fit_id, key=key, registration=data.registration)
    diagnosis = _with_suspects(diagnosis, suspicion, (data, sound), search, loss, context)
    refits = list(refits_of(search, diagnosis))
    sound_index = np.flatnonzero(_kept(data, suspicion))
    table["state"] = sound_index[np.asarray(table["state"], dtype=np.int64)]
    kept = sound_index[search.first.fit.data.index]
    stored_refits = StoredRefits(key=key, entries=[refit.summary for refit in refits])
    falls = tuple(missing.judgement.fall for missing in search.found)
    diagnosis = merged_diagnosis([PartialDiagnosis(diagnosis, falls, len(sound.states)), *rows.parts], in_model)
    refit_table = refit_columns(sound.states, search.first.fit.data, refits, kept)
    return _stored(data, diagnosis, stored_refits, rows, {EVIDENCE: table, REFITS: refit_table})


def _names_in_model(identified: IdentifyResult) -> frozenset[str]:
    """Return the names of the effects that a fitted model holds."""
    return frozenset(entry.type for entry in identified.model.effects)


def _diagnosis_of_drives(
    data: Ingested,
    sound: Ingested,
    drives: Sequence[DrivePart],
    suspicion: Suspicion,
    identified: IdentifyResult,
    context: RunContext,
) -> DiagnoseResult:
    """Diagnose a campaign of clamped runs joint by joint, and store the answer."""
    import numpy as np

    from stiffcal.diagnosis.refits import StoredRefits
    from stiffcal.workflow.diagnose_drives import diagnose_drives

    key = diagnosis_key(data, identified)
    answers = diagnose_drives(sound, drives, np.flatnonzero(_kept(data, suspicion)), identified.loss, context)
    rows = diagnose_rows(data, context)
    diagnosis = merged_diagnosis([*answers.parts, *rows.parts], _names_in_model(identified))
    diagnosis = replace(
        diagnosis,
        fit_id=identified.fit_id,
        key=key,
        registration=data.registration,
        suspects=described(suspicion, data.campaign, data.states, [], identified.loss),
        suspects_not_checked=suspicion.not_checked,
    )
    stored_refits = StoredRefits(key=key, entries=answers.refit_entries)
    return _stored(data, diagnosis, stored_refits, rows, {EVIDENCE: answers.evidence, REFITS: answers.refits})


def _stored(
    data: Ingested,
    diagnosis: DiagnoseResult,
    refits: StoredRefits,
    rows: RowDiagnoses,
    tables: Mapping[str, Columns],
) -> DiagnoseResult:
    """Write a diagnosis into the store with its tables and refits, and return it with the origin of the data."""
    data.commit(
        {**tables, **({ROW_REFITS: rows.columns()} if rows.parts else {})},
        lambda stored: {
            REFITS: document_of(refits),
            **({ROW_REFITS: document_of(replace(refits, entries=rows.entries))} if rows.parts else {}),
            DIAGNOSE: document_of(diagnosis),
            DIAGNOSES: diagnoses_with(stored(DIAGNOSES), data, diagnosis),
        },
        command="diagnose",
    )
    return replace(diagnosis, origin=cast(Origin, data.origin))


def _values(identified: IdentifyResult) -> dict[str, float]:
    """Return the identified values by full name."""
    return {parameter.name: parameter.value for parameter in identified.parameters if parameter.value is not None}


def _without(data: Ingested, suspicion: Suspicion) -> Ingested:
    """Return the campaign without its suspects; a step inside a run stays, as an effect explains it."""
    keep = _kept(data, suspicion)
    return data if keep.all() else replace(data, states=data.states.select(keep))


def _kept(data: Ingested, suspicion: Suspicion) -> Booleans:
    """Return (n,) True for the states that are not of a suspect."""
    from stiffcal.diagnosis.suspects.words import without_steps

    firm = without_steps(suspicion)
    return firm.keep(data.states)


def _with_suspects(
    diagnosis: DiagnoseResult,
    suspicion: Suspicion,
    campaigns: tuple[Ingested, Ingested],
    search: Search,
    loss: str,
    context: RunContext,
) -> DiagnoseResult:
    """Add the suspects, and where some were left out the answer with them.

    Parameters
    ----------
    campaigns : with all states, and without what was left out. search : of the second.
    """
    from stiffcal.diagnosis.document import diagnosis_result

    data, sound = campaigns
    diagnosis = replace(diagnosis, suspects=[], suspects_not_checked=suspicion.not_checked)
    if not suspicion.suspects and suspicion.moved is None:
        return diagnosis
    everything = search if sound is data else search_now(data, loss, context)
    searches = [(sound.states, search)] if sound is data else [(data.states, everything), (sound.states, search)]
    diagnosis = replace(diagnosis, suspects=described(suspicion, data.campaign, data.states, searches, loss))
    if sound is data:
        return diagnosis
    answer = diagnosis_result(data.states, everything)
    remaining_runs = set(sound.states.run.tolist())
    left_out = [
        data.states.runs[suspect.run].name for suspect in suspicion.suspects if suspect.run not in remaining_runs
    ]
    if suspicion.moved is not None and not suspicion.moved.or_drift:
        left_out.append(f"{int(suspicion.moved.leave_out.sum())} rows before or after a move of the base")
    run_names = ", ".join(left_out)
    return replace(
        diagnosis,
        with_suspects=WithSuspects(missing=answer.missing, unexplained=answer.unexplained),
        summary=f"Without the suspect runs ({run_names}): {diagnosis.summary}",
    )


TOO_FEW_READINGS = "No effect can be diagnosed: too few readings per run for load states; log at a higher rate."


def without_states(data: Ingested, identified: IdentifyResult, context: RunContext) -> DiagnoseResult:
    """Return the diagnosis of a campaign without load states and without rows of another kind: nothing to search."""
    from stiffcal.workflow.validate import up_to_date_validation

    validation = up_to_date_validation(data, identified, context)
    return DiagnoseResult(
        warnings=list(validation.warnings),
        adequate=None,
        noise=validation.noise,
        rms=validation.rms,
        lack_of_fit=None,
        missing=[],
        could_be=[],
        findings=[],
        next_measurement=None,
        not_tried=[UntestableEffect("every effect that deflects the robot", "load states: more readings per run")],
        unexplained=None,
        structure=[],
        heldout_rms_after_choosing=Rms(None, None),
        parameters_with_missing=[],
        pace=SearchPace(models=0, candidates=0, signatures=0, seconds=0.0, candidates_per_second=0.0),
        summary=TOO_FEW_READINGS,
        superfluous=[],
        evidence=[],
        fit_id="",
        key="",
    )


def current_diagnosis(data: Ingested, identified: IdentifyResult) -> tuple[DiagnoseResult | None, str]:
    """Return the stored diagnosis where it is of the present fit; else None, and why in words."""
    stored = stored_document(data.store, DIAGNOSE)
    if stored is None:
        return None, "not diagnosed: run stiffcal diagnose"
    if stored.get("key") != diagnosis_key(data, identified):
        of_fit = f" (it is of fit {stored['fit_id']})" if stored.get("fit_id") != identified.fit_id else ""
        return None, f"the last diagnosis is stale{of_fit}: run stiffcal diagnose"
    return result_from(DiagnoseResult, stored, data.store.display_name, DIAGNOSE), ""


def keep_diagnosis(data: Ingested, identified: IdentifyResult, results: TrialResults) -> None:
    """Store the diagnosis of a model that was tried, where it is of just this fit: the same model of the same data.

    Parameters
    ----------
    data : the campaign. identified : its fit. results : of the trial.
    """
    key = diagnosis_key(data, identified)
    document = results.document(DIAGNOSE)
    if document is None or document.get("key") != key:
        return
    diagnosis = replace(
        result_from(DiagnoseResult, document, data.store.display_name, DIAGNOSE), fit_id=identified.fit_id
    )
    refits = {name: results.document(name) for name in (REFITS, ROW_REFITS) if name in results.documents}
    of_states = DIAGNOSES in results.documents
    data.commit(
        {name: results.tables[name] for name in (EVIDENCE, REFITS, ROW_REFITS) if name in results.tables},
        lambda stored: {
            **refits,
            DIAGNOSE: document_of(diagnosis),
            **({DIAGNOSES: diagnoses_with(stored(DIAGNOSES), data, diagnosis)} if of_states else {}),
        },
        command="diagnose",
    )


def diagnosis_key(data: Ingested, identified: IdentifyResult) -> str:
    """Return the key of a diagnosis: of the fit, and of the campaign's own effects as far as they may be tried."""
    from stiffcal.model.campaign_effects import key_of_plugins

    plugins = key_of_plugins(data.campaign)
    return key_of(identified.key, DIAGNOSE, *([plugins] if plugins else []))

"""Is the model good enough, and if not, which physical effect is missing: searched, and kept in the store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, cast

from stiffcal.diagnosis.answers.results import DiagnoseResult, SearchPace, UntestableEffect, WithSuspects
from stiffcal.diagnosis.merging import PartialDiagnosis, merged_diagnosis
from stiffcal.documents import Origin, document_of
from stiffcal.errors import no_progress
from stiffcal.judgement.suspects import described, described_doubts, misplaced_in
from stiffcal.measurements.rms import Rms
from stiffcal.stages.diagnoses.current import diagnosis_key
from stiffcal.stages.diagnoses.of_rows import diagnoses_of_rows
from stiffcal.stages.diagnoses.of_states import diagnose_now, diagnosis_of
from stiffcal.stages.diagnoses.stored_curves import (
    DIAGNOSES,
    EVIDENCE,
    REFITS,
    ROW_REFITS,
    diagnoses_with,
    evidence_of,
    refit_columns,
)
from stiffcal.stages.steps import DIAGNOSE, Ingested, RunContext
from stiffcal.wording import listing

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.suspect_results import Suspect
    from stiffcal.diagnosis.refits.refits import StoredRefits
    from stiffcal.diagnosis.suspects.find import Suspicion
    from stiffcal.judgement.diagnosed import DiagnosedStates
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.stages.diagnoses.of_rows import RowDiagnoses
    from stiffcal.stages.diagnoses.stored_curves import Columns


def diagnose_anew(data: Ingested, identified: IdentifyResult, context: RunContext) -> DiagnoseResult:
    """Diagnose the fit of the present model, and write the diagnosis into the store."""
    import numpy as np

    from stiffcal.diagnosis.refits.refits import StoredRefits, refits_of

    fit_id, key = identified.fit_id, diagnosis_key(data, identified)
    rows, in_model = diagnoses_of_rows(data, context), _names_in_model(identified)
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
    misplaced = misplaced_in(data.campaign, data.states, loss, context.progress)
    in_place = _without(data, misplaced)
    found = diagnose_now(in_place, loss, context)
    sound_index = np.flatnonzero(misplaced.keep(data.states))[found.kept]
    sound = replace(data, states=data.states.select(sound_index))
    diagnosis = diagnosis_of(sound, found)
    context.progress("computing the evidence", 0.98)
    table, evidence = evidence_of(sound, found)
    diagnosis = replace(diagnosis, evidence=evidence, fit_id=fit_id, key=key, registration=data.registration)
    diagnosis = _with_suspects(diagnosis, data, misplaced, found, loss, context)
    refits = list(refits_of(found.first, found.last if found.found else None, diagnosis))
    table["state"] = sound_index[np.asarray(table["state"], dtype=np.int64)]
    kept = sound_index[found.first.fit.data.index]
    stored_refits = StoredRefits(key=key, entries=[refit.summary for refit in refits])
    sizes = tuple(one.group.size for one in found.found)
    diagnosis = merged_diagnosis(
        [PartialDiagnosis(diagnosis, sizes, len(sound.states), explained=found.explained), *rows.parts], in_model
    )
    refit_table = refit_columns(sound.states, found.first.fit.data, refits, kept)
    return _stored(data, diagnosis, stored_refits, rows, {EVIDENCE: table, REFITS: refit_table})


def _names_in_model(identified: IdentifyResult) -> frozenset[str]:
    """Return the names of the effects that a fitted model holds."""
    return frozenset(entry.type for entry in identified.model.effects)


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


def _without(data: Ingested, misplaced: Suspicion) -> Ingested:
    """Return the campaign without what is misplaced."""
    keep = misplaced.keep(data.states)
    return data if keep.all() else replace(data, states=data.states.select(keep))


def _with_suspects(
    diagnosis: DiagnoseResult,
    data: Ingested,
    misplaced: Suspicion,
    found: DiagnosedStates,
    loss: str,
    context: RunContext,
) -> DiagnoseResult:
    """Add the suspects, and where some were left out the answer with them.

    Parameters
    ----------
    data : with all states. misplaced : what was left out before. found : what is missing, without these.
    """
    suspects = [
        *described(misplaced, data.campaign, data.states),
        *described_doubts(found, data.campaign, loss),
    ]
    diagnosis = replace(diagnosis, suspects=suspects, suspects_not_checked=misplaced.not_checked)
    left_out = [_place_of(suspect, data.states) for suspect in suspects if suspect.between is None]
    if misplaced.moved is not None and misplaced.shorter_side is not None:
        left_out.append(misplaced.moved[0].rows_in_words(int(misplaced.shorter_side.sum())))
    if not left_out:
        return diagnosis
    everything = diagnose_now(data, loss, replace(context, progress=no_progress), doubt=False)
    answer = diagnosis_of(data, everything)
    return replace(
        diagnosis,
        with_suspects=WithSuspects(missing=answer.missing, unexplained=answer.unexplained),
        summary=f"Left out of the search, as probably off: {listing(left_out)}. {diagnosis.summary}",
    )


def _place_of(suspect: Suspect, states: LoadStates) -> str:
    """Return a suspect in words: the run, and the row where it is one of several."""
    names = [info.name for info in states.runs]
    alone = int((states.run == names.index(suspect.run)).sum()) == 1
    run = f'run "{suspect.run}"'
    return run if suspect.row is None or alone else f"row {suspect.row} of {run}"


def without_states(data: Ingested, identified: IdentifyResult, context: RunContext) -> DiagnoseResult:
    """Return the diagnosis of a campaign without load states and without rows of another kind: nothing to search."""
    from stiffcal.kinds import all_kinds
    from stiffcal.stages.validation import up_to_date_validation

    measured = {run.experiment for run in data.campaign.manifest.runs}
    reasons = dict.fromkeys(kind.why_not_diagnosed for kind in all_kinds() if kind.name in measured)
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
        not_tried=[UntestableEffect("every effect that deflects the robot", "load states")],
        unexplained=None,
        structure=[],
        heldout_rms_after_choosing=Rms(None, None),
        parameters_with_missing=[],
        pace=SearchPace(models=0, candidates=0, signatures=0, seconds=0.0, candidates_per_second=0.0),
        summary=f"No effect can be diagnosed: {'; '.join(reasons)}.",
        superfluous=[],
        evidence=[],
        fit_id="",
        key="",
    )

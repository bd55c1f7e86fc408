"""What a diagnosis leaves in the store for the report: the evidence of each effect, and the diagnoses before this one.

The table ``evidence`` holds one row per effect and load state; outside stiffcal it reads like any Parquet file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.diagnosis.answers.results import DiagnoseResult, EarlierDiagnosis, EffectEvidenceSummary, RunErrors
from stiffcal.documents import Document, document_of
from stiffcal.model.summary import Where
from stiffcal.stages.steps import Ingested, key_of_table

if TYPE_CHECKING:
    from stiffcal.diagnosis.refits.effect_curves import EffectEvidence
    from stiffcal.diagnosis.refits.refits import Refit
    from stiffcal.identification.readings.observations import Observations
    from stiffcal.judgement.diagnosed import DiagnosedStates
    from stiffcal.measurements.columns import Values
    from stiffcal.measurements.load_states import LoadStates

Columns: TypeAlias = "dict[str, Values]"
"""The columns of a table by name, arrays of one length."""

EVIDENCE, DIAGNOSES, REFITS, ROW_REFITS = "evidence", "diagnoses", "refits", "row_refits"
# A report shows no more pages of evidence than these; a model seldom needs as many effects beyond its joints.
MOST_SHOWN = 12
# Of a diagnosis that a later one has replaced, so many ranks are kept.
RANKS_KEPT = 8


def evidence_of(data: Ingested, found: DiagnosedStates) -> tuple[Columns, list[EffectEvidenceSummary]]:
    """Gather the evidence of every effect that is missing, and of those in the model beyond the basic ones.

    Parameters
    ----------
    data : the campaign, without what is off.
    found : what is missing.

    Returns
    -------
    columns : of the table ``evidence``.
    summaries : one per effect.
    """
    from stiffcal.campaign.model.model_file import default_model
    from stiffcal.diagnosis.refits.effect_curves import evidence_for
    from stiffcal.model.catalogue.campaign_effects import all_effects

    campaign = data.campaign
    experiments = {run.experiment for run in campaign.manifest.runs}
    basic = {entry.type for entry in default_model(campaign.chain.n_joints, experiments).effects}
    present = {
        f"{placed_effect.effect.name} {placed_effect.place.label}": placed_effect.effect.name
        for placed_effect in found.first.fit.robot.placed
        if placed_effect.place.kind != "frames"
    }
    missing = [one.candidate.name for one in found.found]
    beyond = [name for name, effect in present.items() if effect not in basic]
    in_model = {*present} | {f"{name} j{joint}" for name in basic for joint in range(1, campaign.chain.n_joints + 1)}
    catalogue, _ = all_effects(campaign)
    evidence_by_name = {
        f"{evidence.placed.effect.name} {evidence.placed.place.label}": evidence
        for evidence in evidence_for(found.last, {*missing, *beyond}, catalogue, in_model)
    }
    order = [name for name in missing if name in evidence_by_name]
    order += sorted(
        (name for name in evidence_by_name if name not in order),
        key=lambda name: -_rms_reduction(evidence_by_name[name]),
    )
    strongest = {name: evidence_by_name[name] for name in order[:MOST_SHOWN]}
    summaries = [_summary(data, evidence, name in missing) for name, evidence in strongest.items()]
    return evidence_columns(data.states, strongest), summaries


def _rms_reduction(evidence: EffectEvidence) -> float:
    before, after = (getattr(rms, evidence.measure) or 0.0 for rms in (evidence.rms_before, evidence.rms_after))
    return float(before - after)


def _summary(data: Ingested, evidence: EffectEvidence, missing: bool) -> EffectEvidenceSummary:
    names = [info.name for info in data.states.runs]
    return EffectEvidenceSummary(
        effect=evidence.placed.effect.name,
        where=Where.of(evidence.placed.place),
        status="missing" if missing else "in the model",
        driver=evidence.covariate,
        unit=evidence.unit,
        component=evidence.measure,
        lever=evidence.lever,
        heldout_rms_before=evidence.rms_before,
        heldout_rms_after=evidence.rms_after,
        by_run=[RunErrors(label=names[run], before=before, after=after) for run, before, after in evidence.by_run],
    )


def evidence_columns(states: LoadStates, evidence_by_name: Mapping[str, EffectEvidence]) -> Columns:
    """Return the table's columns: rows of one effect stand together, in the order of the entries.

    Parameters
    ----------
    states : all load states of the campaign.
    evidence_by_name : evidence by name of the effect, in the order of the entries.
    """
    from stiffcal.reduction.loads.cycles import LOADING, PEAK, UNLOADING, find_load_cycles

    branch = find_load_cycles(states).branch
    words = np.full(len(branch), "", dtype="<U9")
    if np.any(branch == UNLOADING):
        words[np.isin(branch, (LOADING, PEAK))] = "loading"
        words[branch == UNLOADING] = "unloading"
    entries = list(evidence_by_name.values())

    def joined(name: str) -> Any:
        return np.concatenate([getattr(evidence, name) for evidence in entries]) if entries else np.zeros(0)

    index = joined("index").astype(np.int64)
    # Arrays of words, not lists: an empty list would become a column of numbers.
    return {
        "effect": np.array(
            [evidence.placed.effect.name for evidence in entries for _ in evidence.index], dtype=np.str_
        ),
        "place": np.array([evidence.placed.place.label for evidence in entries for _ in evidence.index], dtype=np.str_),
        "entry": np.repeat(np.arange(len(entries), dtype=np.int64), [len(evidence.index) for evidence in entries]),
        "state": index,
        "run": np.array([states.runs[number].name for number in states.run[index]], dtype=np.str_),
        "branch": words[index],
        "driver": joined("value"),
        "before": joined("before"),
        "after": joined("after"),
        "law": joined("law"),
        **{f"along_{axis}": joined("along").reshape(-1, 3)[:, k] for k, axis in enumerate("xyz")},
    }


def refit_columns(states: LoadStates, data: Observations, refits: Sequence[Refit], index: Integers) -> Columns:
    """Return the columns of the table ``refits``: rows of one refit stand together.

    Parameters
    ----------
    states : load states that were searched.
    data : the observations of the search.
    refits : in the order of the document.
    index : (n,) the observations' states in the campaign's load states.
    """
    from stiffcal.identification.answers.state_tables import residual_columns

    names = residual_columns(states, data, np.zeros_like(data.measured))
    parts = [residual_columns(states, data, refit.residual) for refit in refits]
    return {
        "entry": np.repeat(np.arange(len(refits), dtype=np.int64), len(index)),
        "state": np.tile(index.astype(np.int64), len(refits)),
        **{name: np.concatenate([part[name] for part in parts]) if parts else np.zeros(0) for name in names},
    }


def row_refit_columns(refits: Sequence[Refit], index: Sequence[Integers]) -> Columns:
    """Return the columns of the table ``row_refits``: rows of one refit stand together.

    Parameters
    ----------
    refits : in the order of the document ``refits`` of a campaign without load states.
    index : the rows of each, in the numbering of `DrawnRows`.
    """
    if not refits:
        return {"entry": np.zeros(0, dtype=np.int64), "row": np.zeros(0, dtype=np.int64), "residual": np.zeros(0)}
    return {
        "entry": np.repeat(np.arange(len(refits), dtype=np.int64), [len(rows) for rows in index]),
        "row": np.concatenate(index).astype(np.int64),
        "residual": np.concatenate([refit.residual[0] for refit in refits]),
    }


def diagnoses_with(stored: Document | None, data: Ingested, diagnosis: DiagnoseResult) -> Document:
    """Return the stored diagnoses of these same load states with this one appended; a fit's later one counts."""
    states = key_of_table(data.table)
    earlier = [] if stored is None else stored["entries"]
    entries = [row for row in earlier if row.get("states_key") == states and row.get("fit_id") != diagnosis.fit_id]
    kept = EarlierDiagnosis(
        fit_id=diagnosis.fit_id,
        summary=diagnosis.summary,
        missing=diagnosis.missing,
        next_measurement=diagnosis.next_measurement,
        rms=diagnosis.rms,
        noise=diagnosis.noise,
        heldout_rms_with_missing=diagnosis.heldout_rms_with_missing,
        states_key=states,
        findings=[replace(finding, why="") for finding in diagnosis.findings[:RANKS_KEPT]],
    )
    return {"entries": [*entries, document_of(kept)]}

"""What the report shows of a diagnosis: the result, those that led to it, and the evidence of each effect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.diagnosis.answers.results import DiagnoseResult, EarlierDiagnosis, EffectEvidenceSummary, ProposedEffect
from stiffcal.model.effect import Law
from stiffcal.model.summary import EffectAt
from stiffcal.report.content import EvidenceFigure, ReportContent
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.diagnoses.current import current_diagnosis
from stiffcal.stages.diagnoses.stored_curves import DIAGNOSES, EVIDENCE
from stiffcal.stages.steps import Ingested, key_of_table, stored_document
from stiffcal.store.document_shape import result_from
from stiffcal.store.index import FOREIGN


def with_diagnosis(content: ReportContent, data: Ingested, identified: IdentifyResult) -> ReportContent:
    """Return the content of a report with the diagnosis of the present fit in it, or why there is none.

    Parameters
    ----------
    content : without it.
    data : the campaign.
    identified : the present fit.
    """
    diagnosis, reason = current_diagnosis(data, identified)
    if diagnosis is None:
        return replace(content, not_diagnosed=reason)
    earlier = _earlier_diagnoses(data, diagnosis)
    figures = tuple(_evidence(data, diagnosis, identified, earlier))
    return replace(content, diagnose=diagnosis, earlier_diagnoses=earlier, evidence=figures)


def _earlier_diagnoses(data: Ingested, diagnosis: DiagnoseResult) -> tuple[EarlierDiagnosis, ...]:
    """Return the diagnoses of these states that proposed what the model holds now.

    Entries that came with another user's store are left out of a report on the user's own results: nothing here has
    verified them. In a store that is foreign as a whole, whose results are shown as such, they stay.
    """
    stored = stored_document(data.store, DIAGNOSES) or {"entries": []}
    states = key_of_table(data.table)
    in_model = [evidence for evidence in diagnosis.evidence if evidence.status == "in the model"]
    entries = (
        result_from(EarlierDiagnosis, entry, data.store.display_name, DIAGNOSES)
        for entry in stored["entries"]
        if entry["states_key"] == states
    )
    return tuple(
        entry
        for entry in entries
        if (data.origin == FOREIGN or entry.origin != FOREIGN)
        and entry.fit_id != diagnosis.fit_id
        and any(_same(proposed, evidence) for proposed in entry.missing for evidence in in_model)
    )


def _evidence(
    data: Ingested, diagnosis: DiagnoseResult, identified: IdentifyResult, earlier: tuple[EarlierDiagnosis, ...]
) -> list[EvidenceFigure]:
    from stiffcal.measurements.columns import values_of
    from stiffcal.model.catalogue.campaign_effects import all_effects
    from stiffcal.report.effect_pictures.drawing import effect_picture

    if not diagnosis.evidence:
        return []
    table = data.store.read_table(EVIDENCE)
    columns = {name: np.asarray(values_of(table.column(name))) for name in ("entry", "driver", "before", "after")}
    branch, run = (np.array(table.column(name).to_pylist(), dtype=np.str_) for name in ("branch", "run"))
    catalogue, _ = all_effects(data.campaign)
    figures = []
    for number, evidence in enumerate(diagnosis.evidence):
        rows = columns["entry"] == number
        effect = catalogue[evidence.effect]
        shown_evidence, alternatives = _as_proposed(evidence, diagnosis, earlier)
        fitted = diagnosis.parameters_with_missing if evidence.status == "missing" else identified.parameters
        figures.append(
            EvidenceFigure(
                evidence=evidence,
                value=columns["driver"][rows],
                before=columns["before"][rows],
                after=columns["after"][rows],
                branch=branch[rows],
                run=run[rows],
                path_run=_most_significant_run(evidence) if isinstance(effect, Law) and effect.has_memory else "",
                summary=effect.summary,
                fingerprint=effect.fingerprint,
                check=effect.how_to_check,
                seen=shown_evidence,
                alternatives=alternatives,
                parameters=tuple(
                    parameter
                    for parameter in fitted
                    if parameter.effect == evidence.effect and parameter.where == evidence.where
                ),
                picture=effect_picture(effect),
            )
        )
    return figures


def _most_significant_run(evidence: EffectEvidenceSummary) -> str:
    """Return the run in which the effect takes away most."""
    return max(evidence.by_run, key=lambda run: run.before - run.after).label


def _same(proposed: ProposedEffect, evidence: EffectEvidenceSummary) -> bool:
    return proposed.effect == evidence.effect and proposed.where == evidence.where


def _as_proposed(
    evidence: EffectEvidenceSummary, diagnosis: DiagnoseResult, earlier: tuple[EarlierDiagnosis, ...]
) -> tuple[str, tuple[EffectAt, ...]]:
    """Return the result of the diagnosis that proposed an effect, in words, and its look-alikes."""
    sources: list[DiagnoseResult | EarlierDiagnosis] = [diagnosis, *reversed(earlier)]
    for source in sources:
        for proposed in source.missing:
            if _same(proposed, evidence):
                finding = source.finding_of(proposed)
                explanation = None if finding is None else finding.evidence
                return "" if explanation is None else explanation.seen, tuple(proposed.alternatives)
    return "", ()

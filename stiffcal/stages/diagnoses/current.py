"""The diagnosis that the store holds of the present fit."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal.documents import document_of
from stiffcal.results.value_words import shifted_values
from stiffcal.stages.steps import DIAGNOSE, Ingested, key_of, stored_document
from stiffcal.store.document_shape import result_from

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.results import DiagnoseResult
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.store.trial import TrialResults


def current_diagnosis(data: Ingested, identified: IdentifyResult) -> tuple[DiagnoseResult | None, str]:
    """Return the stored diagnosis where it is of the present fit; else None, and why in words."""
    stored = stored_document(data.store, DIAGNOSE)
    if stored is None:
        return None, "not diagnosed: run stiffcal diagnose"
    if stored.get("key") != diagnosis_key(data, identified):
        of_fit = f" (it is of fit {stored['fit_id']})" if stored.get("fit_id") != identified.fit_id else ""
        return None, f"the last diagnosis is stale{of_fit}: run stiffcal diagnose"
    from stiffcal.diagnosis.answers.results import DiagnoseResult

    return result_from(DiagnoseResult, stored, data.store.display_name, DIAGNOSE), ""


def shifted_by_missing(data: Ingested, identified: IdentifyResult) -> frozenset[str] | None:
    """Return the names of values that adding what the stored diagnosis misses moves beyond their 95 % intervals.

    None where there is no diagnosis of just this fit.
    """
    stored = stored_document(data.store, DIAGNOSE)
    if stored is None or stored.get("key") != diagnosis_key(data, identified):
        return None
    if not stored.get("missing"):
        return frozenset()
    diagnosis, _ = current_diagnosis(data, identified)
    return None if diagnosis is None else shifted_values(diagnosis.before_after)


def keep_diagnosis(data: Ingested, identified: IdentifyResult, results: TrialResults) -> None:
    """Store the diagnosis of a model that was tried, where it is of just this fit: the same model of the same data.

    Parameters
    ----------
    data : the campaign. identified : its fit. results : of the trial.
    """
    from stiffcal.diagnosis.answers.results import DiagnoseResult
    from stiffcal.stages.diagnoses.stored_curves import DIAGNOSES, EVIDENCE, REFITS, ROW_REFITS, diagnoses_with

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
    from stiffcal.model.catalogue.campaign_effects import key_of_plugins

    plugins = key_of_plugins(data.campaign)
    return key_of(identified.key, DIAGNOSE, *([plugins] if plugins else []))

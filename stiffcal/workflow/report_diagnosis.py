"""What the report shows of a diagnosis: the document, those that led to it, and the evidence of each effect."""

from __future__ import annotations

from typing import Any

import numpy as np

from stiffcal.report.content import EvidenceFigure
from stiffcal.store.index import FOREIGN
from stiffcal.workflow.diagnose import current_diagnosis
from stiffcal.workflow.evidence import DIAGNOSES, EVIDENCE
from stiffcal.workflow.steps import Document, Ingested, key_of_table, stored_document


def diagnosis_content(data: Ingested, identified: Document) -> dict[str, Any]:
    """Return the fields of `ReportContent` that speak of a diagnosis.

    Parameters
    ----------
    data : the campaign.
    identified : the `identify` document of the present fit.
    """
    document, reason = current_diagnosis(data, identified)
    if document is None:
        return {"not_diagnosed": reason}
    earlier = _earlier(data, document)
    return {
        "diagnose": document,
        "earlier_diagnoses": earlier,
        "evidence": tuple(_evidence(data, document, identified, earlier)),
    }


def _earlier(data: Ingested, document: Document) -> tuple[Document, ...]:
    """Return the diagnoses of these states that proposed what the model holds now."""
    stored = stored_document(data.store, DIAGNOSES) or {"entries": []}
    states = key_of_table(data.table)
    in_model = {(one["effect"], str(one["where"])) for one in document["evidence"] if one["status"] == "in the model"}
    return tuple(
        one
        for one in stored["entries"]
        if one["states_key"] == states
        and (data.origin == FOREIGN or one.get("origin") != FOREIGN)
        and one["fit_id"] != document["fit_id"]
        and any((each["effect"], str(each["where"])) in in_model for each in one["missing"])
    )


def _evidence(
    data: Ingested, document: Document, identified: Document, earlier: tuple[Document, ...]
) -> list[EvidenceFigure]:
    from stiffcal.model.campaign_effects import all_effects
    from stiffcal.store import values_of
    from stiffcal.workflow.effect_pictures import effect_picture

    if not document["evidence"]:
        return []
    table = data.store.read_table(EVIDENCE)
    columns = {name: np.asarray(values_of(table.column(name))) for name in ("entry", "driver", "before", "after")}
    branch, run = (np.array(table.column(name).to_pylist(), dtype=np.str_) for name in ("branch", "run"))
    catalogue, _ = all_effects(data.campaign)
    found = []
    for number, entry in enumerate(document["evidence"]):
        part = columns["entry"] == number
        effect = catalogue[entry["effect"]]
        named = _named(entry, document, earlier)
        fitted = document["parameters_with_missing"] if entry["status"] == "missing" else identified["parameters"]
        found.append(
            EvidenceFigure(
                effect=entry["effect"],
                where=entry["where"],
                missing=entry["status"] == "missing",
                covariate=entry["driver"],
                unit=entry["unit"],
                rotational=entry["component"] == "rotation",
                lever=entry["lever"],
                value=columns["driver"][part],
                before=columns["before"][part],
                after=columns["after"][part],
                branch=branch[part],
                run=run[part],
                path_run=_most_significant_run(entry) if effect.has_memory else "",
                rms_before=entry["heldout_rms_before"],
                rms_after=entry["heldout_rms_after"],
                by_run=tuple((one["label"], one["before"], one["after"]) for one in entry["by_run"]),
                summary=effect.summary,
                fingerprint=effect.fingerprint,
                check=effect.how_to_check,
                seen=named["seen"],
                alternatives=tuple(named["alternatives"]),
                parameters=tuple(one for one in fitted if _same(one, entry)),
                picture=effect_picture(effect),
            )
        )
    return found


def _most_significant_run(entry: Document) -> str:
    """Return the run in which the effect takes away most."""
    return str(max(entry["by_run"], key=lambda one: one["before"] - one["after"])["label"])


def _same(one: Document, other: Document) -> bool:
    return bool(one["effect"] == other["effect"] and one["where"] == other["where"])


def _named(entry: Document, document: Document, earlier: tuple[Document, ...]) -> Document:
    """Return what the diagnosis that named an effect saw, and which look-alikes it gave."""
    for diagnosis in (document, *reversed(earlier)):
        for missing in diagnosis["missing"]:
            if _same(missing, entry):
                finding = next((one for one in diagnosis["findings"] if _same(one, entry)), None)
                words = (finding or {}).get("evidence") or {}
                return {"seen": words.get("seen", ""), "alternatives": missing["alternatives"]}
    return {"seen": "", "alternatives": []}

"""Fits as `identify` answers them, from the part of the document that a test is about."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from stiffcal.documents import document_of, result_of
from stiffcal.identification.fit_results import IdentifiedParameter
from stiffcal.report.content import ReportContent
from stiffcal.results.identify_result import IdentifyResult

NOTHING: dict[str, Any] = {
    "warnings": [], "model": {"balance": "deformed", "effects": []}, "parameters": [], "n_states": 0, "n_runs": 0,
    "rms": {"translation": None, "rotation": None}, "noise": None, "noise_source": "none", "reduced_chi2": None,
    "condition": None, "not_identifiable": [], "rejected": [], "free_parameters": [], "covariance": [],
    "correlation": [], "expected_rms": None, "expected_error": "",
}  # fmt: skip
"""The document of a fit that has found nothing."""


def fit_of(**document: Any) -> IdentifyResult:
    """Return the fit of a document, of which what is not named is that of a fit that has found nothing."""
    return result_of(IdentifyResult, json.dumps(NOTHING | document))


def with_fit(content: ReportContent, **document: Any) -> ReportContent:
    """Return content whose fit holds other values for these keys of its document."""
    present = NOTHING if content.identify is None else document_of(content.identify)
    return replace(content, identify=fit_of(**(present | document)))


def parameter(name: str, value: float | None, std: float | None = None, **document: Any) -> IdentifiedParameter:
    """Return a parameter of a fit: a compliance where `document` holds its stiffness."""
    effect, _, _ = name.partition(".")
    found: dict[str, Any] = {
        "name": name, "effect": effect, "where": {}, "value": value, "std": std, "interval": None,
        "unit": "rad/(N·m)", "fixed": False, "identifiable": value is not None,
    }  # fmt: skip
    return result_of(IdentifiedParameter, json.dumps(found | document))

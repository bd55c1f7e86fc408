"""Fits and validations as `identify` and `validate` answer them, from the part of the document that a test is about."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from stiffcal.documents import document_of, result_of
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.report.content import ReportContent
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.validate_result import ValidateResult

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


NOT_VALIDATED: dict[str, Any] = {
    "warnings": [], "scheme": "none", "n_states": 0, "n_poses": 0, "noise": None, "worst": [],
    **{key: {"translation": None, "rotation": None} for key in ("rms", "max", "relative", "zero_model")},
    **{f"by_{part}": [] for part in ("run", "direction", "load", "branch", "joint_angle")},
}  # fmt: skip
"""The document of a validation that has judged nothing."""


def validation_of(**document: Any) -> ValidateResult:
    """Return the validation of a document, of which what is not named is that of one that has judged nothing."""
    return result_of(ValidateResult, json.dumps(NOT_VALIDATED | document))


def with_validation(content: ReportContent, **document: Any) -> ReportContent:
    """Return content whose validation holds other values for these keys of its document."""
    present = NOT_VALIDATED if content.validate is None else document_of(content.validate)
    return replace(content, validate=validation_of(**(present | document)))


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

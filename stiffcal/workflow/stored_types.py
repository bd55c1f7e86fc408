"""What documents hold in the store beyond what the commands answer."""

from __future__ import annotations

from typing import Any, Literal, NotRequired

from typing_extensions import TypedDict

from stiffcal.workflow.diagnosis_documents import Diagnose, Missing
from stiffcal.workflow.document_types import Number, Rms
from stiffcal.workflow.documents import Identify, Ingest, Validate

__all__ = ["Ingest"]


class StoredIdentify(Identify):
    """A fit; ``key`` is a hash of all that went into it."""

    key: str
    fit_id: str
    loss: Literal["linear", "huber"]
    free_parameters: list[str]
    covariance: list[list[Number]]


class StoredValidate(Validate):
    """A validation of the fit ``fit_id``."""

    key: str
    fit_id: str


class StoredDiagnose(Diagnose):
    """A diagnosis of the fit ``fit_id``, with what speaks for each effect."""

    key: str
    fit_id: str
    evidence: list[dict[str, Any]]


class ReportMade(TypedDict):
    """Of which results the PDF is."""

    key: str
    sha256: str


class EarlierDiagnosis(TypedDict):
    """What is kept of a diagnosis that a later one has replaced."""

    fit_id: str
    summary: str
    missing: list[Missing]
    rms: Rms
    noise: Rms | None
    states_key: str
    findings: list[dict[str, Any]]
    next_measurement: NotRequired[dict[str, Any] | None]
    heldout_rms_with_missing: NotRequired[Rms | None]

"""What documents hold in the store beyond what the commands answer."""

from __future__ import annotations

from typing import Literal

from typing_extensions import TypedDict

from stiffcal.workflow.document_types import Number
from stiffcal.workflow.documents import Identify, Validate


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


class ReportMade(TypedDict):
    """Of which results the PDF is."""

    key: str
    sha256: str

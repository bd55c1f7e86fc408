"""What documents hold in the store beyond what the commands answer."""

from __future__ import annotations

from typing_extensions import TypedDict

from stiffcal.workflow.documents import Validate


class StoredValidate(Validate):
    """A validation of the fit ``fit_id``."""

    key: str
    fit_id: str


class ReportMade(TypedDict):
    """Of which results the PDF is."""

    key: str
    sha256: str

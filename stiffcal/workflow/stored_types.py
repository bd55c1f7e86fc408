"""What documents hold in the store beyond what the commands answer."""

from __future__ import annotations

from typing_extensions import TypedDict


class ReportMade(TypedDict):
    """Of which results the PDF is."""

    key: str
    sha256: str

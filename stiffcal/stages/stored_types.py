"""What documents hold in the store beyond what the commands answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredReport:
    """Of which results the PDF is that `batch` has made last."""

    schema: Literal["stiffcal/report-made/1"] = "stiffcal/report-made/1"
    key: str
    """A hash of all that it shows."""
    sha256: str | None
    """Of the PDF; None where it was gone again."""

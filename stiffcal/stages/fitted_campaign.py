"""A campaign with its fit, as one of many campaigns of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.stages.steps import Ingested


@dataclass(frozen=True)
class FittedCampaign:
    """One campaign with its fit."""

    folder: Path
    """As it was named."""
    data: Ingested
    """Its load states."""
    fit: IdentifyResult
    """Its fit."""

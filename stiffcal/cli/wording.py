"""Numbers as a terminal shows them: mm, mrad, N·m/rad, three significant digits."""

from __future__ import annotations

from stiffcal.wording import DASH as NOT_KNOWN
from stiffcal.wording import angle, deviation, length, share, significant
from stiffcal.wording import place as places
from stiffcal.wording import place_label as short_places
from stiffcal.wording import ranges as runs_of

__all__ = [
    "NOT_KNOWN",
    "angle",
    "deviation",
    "length",
    "places",
    "runs_of",
    "share",
    "short_places",
    "significant",
]

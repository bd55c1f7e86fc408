"""Numbers as a terminal shows them: mm, mrad, N·m/rad, three significant digits."""

from __future__ import annotations

from stiffcal.wording import DASH as NOT_KNOWN
from stiffcal.wording import deviation, length, share, significant
from stiffcal.wording import place as places
from stiffcal.wording import place_label as short_places

__all__ = [
    "NOT_KNOWN",
    "deviation",
    "length",
    "places",
    "share",
    "short_places",
    "significant",
]

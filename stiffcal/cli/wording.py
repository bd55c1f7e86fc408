"""Numbers as a terminal shows them: mm, mrad, N·m/rad, three significant digits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from stiffcal import wording
from stiffcal.wording import DASH as NOT_KNOWN
from stiffcal.wording import angle, length, share, significant
from stiffcal.wording import place as places
from stiffcal.wording import place_label as short_places
from stiffcal.wording import ranges as runs_of

if TYPE_CHECKING:
    from stiffcal.measurements.rms import Rms

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


def deviation(rms: Rms | Mapping[str, float | None] | None) -> str:
    """Return an rms `{translation, rotation, …}` as one phrase.

    Examples
    --------
    >>> deviation({"translation": 0.0003721, "rotation": 2.5e-4})
    '0.372 mm, 0.250 mrad'
    >>> deviation({"translation": 0.0003721, "rotation": None, "length": 1.2e-6})
    '0.372 mm, 0.00120 mm at the rods'
    """
    return ", ".join(wording.measures(rms)) or NOT_KNOWN

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
    "interval",
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


def interval(value: float | None, low: float | None, high: float | None) -> str:
    """Return `value ± half-width`, or the ends where the interval is lopsided or open.

    Examples
    --------
    >>> interval(2.72e6, 2.28e6, 3.16e6), interval(None, None, None)
    ('(2.72 ± 0.44)·10⁶', '–')
    """
    return NOT_KNOWN if value is None else wording.estimate(value, low, high)

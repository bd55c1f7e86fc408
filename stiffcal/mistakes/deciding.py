"""When what is measured decides between mistakes that were taken back.

Sums of squares of readings whose scatter is known or common are compared by Schwarz' criterion (rods, clocks).
Distances between places that frames with which most rows meet leave, where some rows may be wrong, by their ratio
(tables of absolute places, unloaded poses).
"""

from __future__ import annotations

from math import log

DECISIVE = 10.0
"""By so much one explanation beats another in Schwarz' criterion, "very strong": Kass and Raftery 1995."""

MUCH_BETTER = 0.3
"""A change that explains a distance leaves less than this share of it. The right one leaves what the robot misses by
itself, millimetres where the mistake makes decimetres."""
AS_GOOD = 1.5
"""Changes that leave no more than so many times the least explain it alike. The median distance of ten rows is
known to a sixth, the ratio of two of them to a quarter: this is two standard errors."""
CLEARLY_LESS = 0.9
"""The order of moments' columns, or the unit of moments, is known where another one leaves a tenth more."""


def schwarz(squares: float, count: int, numbers: int, least: float) -> float:
    """Return Schwarz' criterion of an explanation, smaller for better ones (Schwarz 1978).

    Parameters
    ----------
    squares : the sum that it leaves of ``count`` readings.
    numbers : how many were chosen by these readings.
    least : the mean square that noise leaves of any.

    Examples
    --------
    >>> schwarz(8.0, 4, 0, 1.0) > schwarz(4.0, 4, 1, 1.0)
    True
    """
    return count * log(max(squares / count, least)) + numbers * log(count)

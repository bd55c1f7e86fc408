"""Standard uncertainties and 95 % intervals: one quantile, one rule of what counts as poorly known."""

from __future__ import annotations

import math

NORMAL_95 = 1.959963984540054
"""A normal distribution's 97.5 % quantile: standard uncertainties on either side that hold 95 %."""

POORLY_KNOWN = 0.6
"""Half of the 95 % interval over the value: above it a stiffness is not known to within a factor of two or three."""

MEDIAN_OF_NORMAL = 0.6745
"""The median of |N(0, 1)|."""

NORMAL_MAD = 1.4826
"""Standard uncertainties of normal errors in their median absolute deviation: 1 / 0.6745."""


def chi_square_bound(count: int, exponent: float) -> float:
    """Return what χ² of ``count`` numbers exceeds with a probability of at most e^−exponent.

    Laurent and Massart 2000, Lemma 1.

    Examples
    --------
    >>> chi_square_bound(1, 4.0)
    13.0
    """
    return count + 2.0 * math.sqrt(exponent * count) + 2.0 * exponent


def is_poorly_known(value: float, std: float) -> bool:
    """Return whether an estimate's 95 % interval is wide against the estimate itself.

    Parameters
    ----------
    value : the estimate.
    std : its standard uncertainty, in the same unit.

    Examples
    --------
    >>> is_poorly_known(10.0, 1.0), is_poorly_known(10.0, 4.0)
    (False, True)
    """
    return NORMAL_95 * std > POORLY_KNOWN * abs(value)

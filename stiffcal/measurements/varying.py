"""Whether readings change: averages of a constant differ in their last digits, from one processor to another."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats

# Averages of some million readings are rounded to this, relatively.
ROUNDING = 1e-12


def varies(values: Floats) -> bool:
    """Return True where readings (n,) differ by more than rounding; NaN counts as no change.

    Examples
    --------
    >>> varies(np.array([21.3, 21.3 + 4e-15])), varies(np.array([0.0, 1e-9]))
    (False, True)
    """
    if not values.size:
        return False
    return bool(np.ptp(values) > ROUNDING * np.abs(values).max())

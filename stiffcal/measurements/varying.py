"""Whether readings change: averages of a constant differ in their last digits, from one processor to another."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats

# Averages of some million readings are rounded to this, relatively.
ROUNDING = 1e-12


def varies(values: Floats, size: float = 0.0) -> bool:
    """Return True where readings (n,) differ by more than rounding; NaN counts as no change.

    Parameters
    ----------
    values : (n,) the readings. size : of what they were computed from, in their unit, where that may be larger: torques
        about an axis that no load turns are what its products leave.

    Examples
    --------
    >>> varies(np.array([21.3, 21.3 + 4e-15])), varies(np.array([0.0, 1e-9]))
    (False, True)
    >>> varies(np.array([0.0, 1e-14])), varies(np.array([0.0, 1e-14]), size=250.0)
    (True, False)
    """
    if not values.size:
        return False
    return bool(np.ptp(values) > ROUNDING * max(float(np.abs(values).max()), size))

"""A spring's torque as a cubic of its angle, and the angle back from the torque (004, Table 2)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.wording import significant

# A spring that rises by less than this share of its first slope counts as having given way: printed cubics turn over
# (joint 1 of 004's Table 2 at 0.096°), springs do not. From there the curve goes on along its tangent.
LEAST_SLOPE = 0.02
_TABLE = 1025
_CROWDING = 12.0
# Newton's steps end when torque and curve agree to this share of the largest torque; the bracket closes by a bisection
# wherever a step leaves it, so that fifty halve a cell of the table to rounding.
_SETTLED, _MOST_STEPS = 1e-13, 60
# N·m, whose powers are no numbers any more.
_BEYOND = 1e60


def monotonic_range(curve: tuple[float, float, float]) -> tuple[float, float]:
    """Return the angles, rad, between which the cubic's slope stays above `LEAST_SLOPE` of p1; infinite where it does.

    Parameters
    ----------
    curve : p1, p2, p3 in N·m/rad, N·m/rad², N·m/rad³; p1 > 0.

    Examples
    --------
    >>> low, high = monotonic_range((1.30e3, -10.9e3, 28.7e3))  # joint 1 of Table 2, over degrees
    >>> bool(low == -np.inf), round(high, 4)
    (True, 0.0915)
    """
    p1, p2, p3 = curve
    roots = np.roots([3.0 * p3, 2.0 * p2, (1.0 - LEAST_SLOPE) * p1])
    real = roots[np.abs(roots.imag) <= 1e-9 * np.maximum(np.abs(roots.real), 1e-30)].real
    above, below = real[real > 0.0], real[real < 0.0]
    return float(below.max(initial=-np.inf)), float(above.min(initial=np.inf))


def angle_of_torque(torque: Floats, curve: tuple[float, float, float]) -> Floats:
    """Return (n,) rad: the spring's angle under torques, N·m: from a table, then Newton's method on the curve.

    Parameters
    ----------
    torque : (n,) N·m; all angles are NaN where one is infinite or no number.
    curve : p1, p2, p3; p1 > 0.

    Raises
    ------
    ArithmeticError : Newton's steps do not settle.

    Examples
    --------
    >>> angle_of_torque(np.array([-2.0, 0.0, 3.0]), (1.0, 0.0, 0.0)).round(12).tolist()
    [-2.0, 0.0, 3.0]
    """
    torque = np.asarray(torque, dtype=np.float64)
    largest = float(np.abs(torque).max(initial=0.0))
    if not largest < _BEYOND:
        return np.full_like(torque, np.nan)
    low, high, table, torques, slopes = _table(curve, int(np.frexp(largest)[1]))
    cell = np.clip(np.searchsorted(torques, torque) - 1, 0, _TABLE - 2)
    below, above, width = table[cell], table[cell + 1], torques[cell + 1] - torques[cell]
    # the cubic through both ends with the curve's slopes there
    share = (torque - torques[cell]) / width
    chord = above - below
    start, end = slopes[cell] * width - chord, chord - slopes[cell + 1] * width
    angle = below + share * (chord + (1.0 - share) * (start * (1.0 - share) + end * share))
    for _ in range(_MOST_STEPS):
        residual = _between(angle, curve, low, high) - torque
        if np.abs(residual).max(initial=0.0) <= _SETTLED * largest:
            return np.asarray(angle)
        below, above = np.where(residual < 0.0, angle, below), np.where(residual > 0.0, angle, above)
        tried = angle - residual / _slope(angle, curve, low, high)
        angle = np.where((tried < below) | (tried > above), 0.5 * (below + above), tried)
    raise ArithmeticError(f"no angle of the spring exists for a torque of {significant(largest)} N·m")


@lru_cache(maxsize=256)
def _table(curve: tuple[float, float, float], exponent: int) -> tuple[float, float, Floats, Floats, Floats]:
    """Return the monotonic range, angles and their torques (t,) to ± 2 to the power of ``exponent``, and rad/(N·m).

    A fit asks for the same curves in every sweep of the balance: six joints, each for torques of many sizes.
    """
    low, high = monotonic_range(curve)
    largest = float(np.ldexp(1.0, exponent))
    reach = 1.1 * largest / curve[0] + 1e-300
    while _between(reach, curve, low, high) < largest or -_between(-reach, curve, low, high) < largest:
        reach *= 2.0
    table = reach * np.sinh(_CROWDING * np.linspace(-1.0, 1.0, _TABLE)) / np.sinh(_CROWDING)
    return low, high, table, _between(table, curve, low, high), 1.0 / _slope(table, curve, low, high)


def _between(angle: Floats | float, curve: tuple[float, float, float], low: float, high: float) -> Floats:
    """Return the torque, along the tangent outside ``low … high``."""
    p1, p2, p3 = curve
    inside = np.clip(angle, low, high)
    return np.asarray(inside * (p1 + inside * (p2 + inside * p3)) + LEAST_SLOPE * p1 * (angle - inside))


def _slope(angle: Floats, curve: tuple[float, float, float], low: float, high: float) -> Floats:
    """Return N·m/rad, of the tangent outside ``low … high``."""
    p1, p2, p3 = curve
    inside = np.clip(angle, low, high)
    return np.asarray(np.maximum(p1 + inside * (2.0 * p2 + inside * 3.0 * p3), LEAST_SLOPE * p1))

"""A spring's torque as a cubic of its angle, and the angle back from the torque (004, Table 2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# A spring that rises by less than this share of its first slope counts as having given way: printed cubics turn over
# (joint 1 of 004's Table 2 at 0.096°), springs do not. From there the curve goes on along its tangent.
LEAST_SLOPE = 0.02
_HALVINGS = 80


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


def torque_of_angle(angle: Floats, curve: tuple[float, float, float]) -> Floats:
    """Return (n,) N·m of angles counted from the flank, rad; along the tangent beyond the monotonic range."""
    p1, p2, p3 = curve
    low, high = monotonic_range(curve)
    inside = np.clip(angle, low, high)
    return np.asarray(inside * (p1 + inside * (p2 + inside * p3)) + LEAST_SLOPE * p1 * (angle - inside))


def angle_of_torque(torque: Floats, curve: tuple[float, float, float]) -> Floats:
    """Return (n,) rad: the spring's angle under torques, N·m, by bisection on the monotonic curve.

    Parameters
    ----------
    torque : (n,) N·m. curve : p1, p2, p3; p1 > 0.

    Examples
    --------
    >>> angle_of_torque(np.array([-2.0, 0.0, 3.0]), (1.0, 0.0, 0.0)).round(12).tolist()
    [-2.0, 0.0, 3.0]
    """
    torque = np.asarray(torque, dtype=np.float64)
    reach = 2.0 * np.abs(torque).max(initial=0.0) / curve[0] + 1e-300
    while torque_of_angle(np.array([reach]), curve)[0] < torque.max(initial=0.0) or torque_of_angle(
        np.array([-reach]), curve
    )[0] > torque.min(initial=0.0):
        reach *= 2.0
    low, high = np.full(torque.shape, -reach), np.full(torque.shape, reach)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        over = torque_of_angle(middle, curve) > torque
        high, low = np.where(over, middle, high), np.where(over, low, middle)
    return np.asarray(0.5 * (low + high))

"""Least squares with non-negative unknowns, for a handful of them.

Why not scipy's: it is the one thing that checks of logs need of `scipy.optimize`, whose import takes longer than they
do (1 s of each command, and of each process of a batch). A test holds the two equal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def non_negative_least_squares(design: Floats, wanted: Floats) -> tuple[Floats, float]:
    """Minimise ‖design x − wanted‖ over x ≥ 0 (Lawson and Hanson 1974, chapter 23).

    Parameters
    ----------
    design : (m, n). wanted : (m,).

    Returns
    -------
    x (n,), and the norm that is left.
    """
    n = design.shape[1]
    x, free = np.zeros(n), np.zeros(n, dtype=np.bool_)
    tolerance = 10.0 * np.finfo(float).eps * max(design.shape) * float(np.abs(design).sum(axis=0).max(initial=0.0))
    tolerance *= float(np.abs(wanted).max(initial=0.0)) or 1.0
    for _ in range(3 * n):
        downhill = np.where(free, -np.inf, design.T @ (wanted - design @ x))
        if n == 0 or downhill.max() <= tolerance:
            break
        free[int(np.argmax(downhill))] = True
        x = _descended(design, wanted, x, free)
    return x, float(np.linalg.norm(design @ x - wanted))


def _descended(design: Floats, wanted: Floats, x: Floats, free: NDArray[np.bool_]) -> Floats:
    """Go to the least squares of the free unknowns; those that would become negative on the way are held at zero."""
    while free.any():
        goal = np.zeros_like(x)
        goal[free] = np.linalg.lstsq(design[:, free], wanted, rcond=None)[0]
        below = free & (goal <= 0.0)
        if not below.any():
            return goal
        # A goal below zero for what has just been freed is rounding: it stays where it is, at zero.
        share = float((x[below] / np.maximum(x[below] - goal[below], 1e-300)).min())
        x = x + share * (goal - x)
        free &= ~(below & (x <= 1e-12 * np.abs(x).max(initial=0.0)))
        x = np.where(free, x, 0.0)
    return np.zeros_like(x)

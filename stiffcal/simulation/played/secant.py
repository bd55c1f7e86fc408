"""Secant steps to the root of many small systems at once, which all are evaluated in one call (Broyden 1965)."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats

# A residual that grows by more than this was a step too far: the next one is half as long.
_GROWS = 2.0
# Steps shorter than this, relative to the longest, hold nothing but rounding: no slope is drawn from them.
_LEAST_STEP = 1e-9
# No slope is taken for smaller than this, relative to the one at the start: its next step would be endless.
_LEAST_SLOPE = 1e-3


class SecantSteps:
    """Broyden's first method for b systems r(x) = 0 of d unknowns, each with a slope of its own.

    Near a root a smooth system of d unknowns gains more with every step; for a linear one it ends after 2 d steps.

    Parameters
    ----------
    slope : (b,) −∂r/∂x to start from, the same along all unknowns; positive. Too large only makes the first steps
        short.
    unknowns : d.

    Examples
    --------
    >>> root, x = SecantSteps(np.array([1.0]), 1), np.array([[0.0]])
    >>> for _ in range(8):
    ...     x = root.step(x, 2.0 - x**2)
    >>> round(float(x[0, 0]), 12) == round(2.0**0.5, 12)
    True
    """

    def __init__(self, slope: Floats, unknowns: int) -> None:
        self._start = np.asarray(slope, dtype=np.float64)[:, None, None] * np.eye(unknowns)
        self._slope = self._start.copy()
        self._moved: Floats | None = None
        self._left: Floats | None = None

    def step(self, x: Floats, left: Floats) -> Floats:
        """Return (b, d) the next x, for the present one (b, d) and its residual r(x) (b, d)."""
        if self._moved is not None and self._left is not None:
            self._learn(self._moved, left - self._left)
            worse = np.linalg.norm(left, axis=1) > _GROWS * np.linalg.norm(self._left, axis=1)
            self._start[worse] *= 2.0
            self._slope[worse] = self._start[worse]
        step = np.asarray(np.linalg.solve(self._slope, left[:, :, None])[:, :, 0], dtype=np.float64)
        self._moved, self._left = step, left
        return np.asarray(x + step)

    def _learn(self, step: Floats, change: Floats) -> None:
        """Make each slope agree with the last step, where that was long enough to say anything."""
        square = np.sum(step**2, axis=1)
        long = square > _LEAST_STEP**2 * square.max(initial=0.0)
        missing = -change - np.einsum("bij,bj->bi", self._slope, step)
        update = missing[:, :, None] * step[:, None, :] / np.where(long, square, 1.0)[:, None, None]
        learnt = self._slope + np.where(long[:, None, None], update, 0.0)
        # A slope that has lost a direction would make the next step endless: such a system keeps the one it has.
        singular = np.linalg.svd(learnt, compute_uv=False)[:, -1]
        sound = singular > _LEAST_SLOPE * self._start[:, 0, 0]
        self._slope = np.where(sound[:, None, None], learnt, self._slope)

"""The lag between two logs at which a loss is least: all minima in a range, and whether the data distinguish them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats

PARTS = 4
"""Parts of a run by which two lags are compared."""
# Student's t, three degrees of freedom, one-sided 95 %: of `PARTS` differences.
DISTINGUISHED = 2.353
# A parabola through three points of the scan says how deep a minimum is, nearly: of so many the depth is found.
MOST_REFINED = 8
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@dataclass(frozen=True)
class LagMinimum:
    """A local minimum of a loss over the lag."""

    lag: float
    """s."""
    loss: float
    """The loss there."""
    inside: bool
    """False where the loss still falls at the end of the range."""


def lag_minima(
    loss: Callable[[float], float], low: float, high: float, spacing: float, settled: float
) -> list[LagMinimum]:
    """Return the local minima of a loss in a range of lags, the least first.

    The whole range is scanned; around each minimum of the scan the lag is bracketed, and found by golden section.

    Parameters
    ----------
    loss : of a lag, s. low, high : ends of the range, s. spacing : of the scan, s: two minima that are nearer count
        as one. settled : s, the largest error of a lag.
    """
    lags = np.linspace(low, high, max(int(np.ceil((high - low) / spacing)) + 1, 3))
    losses = np.array([loss(float(lag)) for lag in lags])
    padded = np.concatenate([[np.inf], losses, [np.inf]])
    lowest = np.flatnonzero((losses <= padded[:-2]) & (losses < padded[2:]))
    lowest = lowest[np.argsort([_depth(losses, int(k)) for k in lowest], kind="stable")][:MOST_REFINED]
    found = []
    for k in lowest.tolist():
        if k in (0, len(lags) - 1):
            found.append(LagMinimum(float(lags[k]), float(losses[k]), False))
        else:
            found.append(_golden(loss, float(lags[k - 1]), float(lags[k + 1]), settled))
    return sorted(found, key=lambda minimum: minimum.loss)


def nearest_minimum(
    loss: Callable[[float], float], start: float, spacing: float, most: float, settled: float
) -> LagMinimum:
    """Return the minimum that lies downhill from a lag.

    Parameters
    ----------
    loss, settled : as of `lag_minima`. start : s. spacing : s, of the steps downhill.
    most : s, how far it may be.
    """
    middle, at_middle = start, loss(start)
    way = spacing if loss(start + spacing) < loss(start - spacing) else -spacing
    while (ahead := loss(middle + way)) < at_middle:
        middle, at_middle = middle + way, ahead
        if abs(middle - start) >= most:
            return LagMinimum(middle, at_middle, False)
    return _golden(loss, middle - spacing, middle + spacing, settled)


def are_distinguished(best: Sequence[float] | Floats, other: Sequence[float] | Floats) -> bool:
    """Return whether one lag leaves clearly less than another in most parts of a run (a one-sided t-test of pairs).

    Parameters
    ----------
    best, other : (PARTS,) the loss of each part at the one lag and at the other.
    """
    more = np.asarray(other, dtype=np.float64) - np.asarray(best, dtype=np.float64)
    return bool(more.mean() > DISTINGUISHED * more.std(ddof=1) / np.sqrt(more.size))


def _depth(losses: Floats, k: int) -> float:
    """Return the least of a parabola through a point of the scan and its neighbours."""
    if k in (0, len(losses) - 1):
        return float(losses[k])
    bend, slope = losses[k - 1] - 2.0 * losses[k] + losses[k + 1], 0.5 * (losses[k + 1] - losses[k - 1])
    return float(losses[k] - 0.5 * slope**2 / bend) if bend > 0.0 else float(losses[k])


def _golden(loss: Callable[[float], float], low: float, high: float, settled: float) -> LagMinimum:
    """Return the minimum between two lags, to ``settled``, s."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = loss(left), loss(right)
    while high - low > settled:
        if at_left <= at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = loss(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = loss(right)
    return LagMinimum(0.5 * (low + high), min(at_left, at_right), True)

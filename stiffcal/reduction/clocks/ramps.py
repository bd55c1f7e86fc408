"""The last milliseconds of an offset between two clocks: what each ramp of the load gives by itself.

All ramps go through a few sums together: a campaign of a hundred logs asks for them a thousand times.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.uncertainty import NORMAL_MAD

MOST_STEPS = 50  # of what is found step by step: a lag, a robust mean
LEAST_STEP_SQUARED = 50.0  # noises², of the load over a ramp: seven noises of its sensor, else there is no step here
LEAST_ON_RAMP = 5  # readings: level, gain and lag of a ramp are three numbers
ENDS_OF_RAMP = 6  # one of so many parts of a ramp at each end: their means give the direction of the load
HUBER = 2.0  # scales from the middle: answers within them count whole (Huber 1981: 1.5 to 2)
SETTLED = 1e-9  # of the answers' range


class Integral:
    """Running means of a log at any time and width, by its integral."""

    def __init__(self, time: Floats, values: Floats) -> None:
        self._time = time
        self.first, self.last = float(time[0]), float(time[-1])
        steps = 0.5 * (values[1:] + values[:-1]) * np.diff(time)[:, None]
        self._integral = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(steps, axis=0)])
        self._values = values

    def course(self, time: Floats, width: float) -> tuple[Floats, Floats]:
        """Return the running mean and its slope: of the means over the half width after and before."""
        after, middle, before = (self._at(time + shift) for shift in (0.5 * width, 0.0, -0.5 * width))
        return (after - before) / width, (after - 2.0 * middle + before) / (0.5 * width) ** 2

    def _at(self, time: Floats) -> Floats:
        # the integral of a piecewise linear log is piecewise quadratic; between samples its own slope counts
        k = np.clip(np.searchsorted(self._time, time, side="right") - 1, 0, len(self._time) - 2)
        passed = np.clip(time - self._time[k], 0.0, self._time[k + 1] - self._time[k])
        share = (passed / (self._time[k + 1] - self._time[k]))[:, None]
        value = self._values[k] + 0.5 * share * (self._values[k + 1] - self._values[k])
        return np.asarray(self._integral[k] + value * passed[:, None])


def ramp_answers(
    windows: Sequence[tuple[float, float, float]],
    running: Integral,
    time: Floats,
    white: Floats,
    lag: float,
    scale: float,
) -> tuple[Floats, Floats]:
    """Return each ramp's own correction to ``lag``, s, and its weight (1/s², noise alone)."""
    first, last = running.first + scale, running.last - scale
    begin, end = (np.array([window[side] for window in windows]) for side in (0, 1))
    start, stop = np.searchsorted(time, [np.maximum(begin, first) + lag, np.minimum(end, last) + lag])
    start, stop = start[stop - start >= LEAST_ON_RAMP], stop[stop - start >= LEAST_ON_RAMP]
    if start.size == 0:
        return np.zeros(0), np.zeros(0)
    load, slope = running.course(time[_stretches(start, stop)] - lag, scale)
    # one scalar per ramp: the load along the direction in which it changes
    count = stop - start
    edges, sixth = np.cumsum(count) - count, np.maximum(count // ENDS_OF_RAMP, 1)
    sums = np.add.reduceat(load, np.stack([edges, edges + sixth, edges + count - sixth], axis=1).ravel(), axis=0)
    direction = (sums[2::3] - sums[::3]) / sixth[:, None]
    length = np.sum(direction**2, axis=1)
    ramps = length >= LEAST_STEP_SQUARED
    if not ramps.any():
        return np.zeros(0), np.zeros(0)
    ramp_of_sample = np.repeat(ramps, count)
    count = count[ramps]
    along = np.repeat(direction[ramps] / length[ramps, None], count, axis=0)
    ramp = _Ramps(count)
    course, slope = (
        ramp.centred(np.sum(load[ramp_of_sample] * along, axis=1)),
        np.sum(slope[ramp_of_sample] * along, axis=1),
    )
    measured = ramp.centred(white[_stretches(start[ramps], stop[ramps])])
    squares = ramp.sums(course**2)
    gain = ramp.sums(course[:, None] * measured) / squares[:, None]
    # what a level and a gain of each ramp's own leave
    gains = np.repeat(gain, count, axis=0)
    residual = measured - course[:, None] * gains
    slope = ramp.centred(slope)
    slope_change = slope - course * np.repeat(ramp.sums(course * slope) / squares, count)
    weights = np.sum(gain**2, axis=1) * ramp.sums(slope_change**2)
    # later lag: the load is read at an earlier time, the course falls by its slope
    steps = -ramp.sums(slope_change * np.sum(residual * gains, axis=1))
    weighted = (weights > 0.0) & np.isfinite(weights)
    return steps[weighted] / weights[weighted], weights[weighted]


def _stretches(start: Integers, stop: Integers) -> Integers:
    """Return the indices start … stop − 1 of each stretch, one stretch after the other."""
    count = stop - start
    return np.asarray(np.arange(count.sum()) + np.repeat(start - (np.cumsum(count) - count), count))


class _Ramps:
    """Sums over stretches of readings that follow each other, `count` in each."""

    def __init__(self, count: Integers) -> None:
        self._count, self._edges = count, np.cumsum(count) - count

    def sums(self, values: Floats) -> Floats:
        return np.asarray(np.add.reduceat(values, self._edges, axis=0))

    def centred(self, values: Floats) -> Floats:
        count = self._count.reshape(-1, *[1] * (values.ndim - 1))
        return np.asarray(values - np.repeat(self.sums(values) / count, self._count, axis=0))


def robust_mean(steps: Floats, weights: Floats) -> tuple[float, Floats]:
    """Return the weighted mean and the weights it used: answers far from the median are let go gently (Huber)."""
    order = np.argsort(steps)
    cumulated = np.cumsum(weights[order])
    centre = float(steps[order[int(np.searchsorted(cumulated, 0.5 * cumulated[-1]))]])
    for _ in range(MOST_STEPS):  # a mean that has not settled moves the lag, whose own test judges it
        away = np.abs(steps - centre) * np.sqrt(weights)
        scale = max(NORMAL_MAD * _median(away), 1e-12)
        gentle = weights * np.minimum(1.0, HUBER * scale / np.maximum(away, 1e-300))
        before, centre = centre, float((gentle @ steps) / gentle.sum())
        if abs(centre - before) <= SETTLED * float(np.ptp(steps)):
            break
    return centre, gentle


def _median(values: Floats) -> float:
    """Return the median of a few values; `numpy.median` takes ten times as long for them."""
    ordered, middle = np.sort(values), len(values) // 2
    return float(ordered[middle] if len(values) % 2 else 0.5 * (ordered[middle - 1] + ordered[middle]))


def spread_of(steps: Floats, weights: Floats, gentle: Floats, width: float) -> float:
    """Return the standard uncertainty of the mean, s: scatter between ramps, not less than the noise within them."""
    within = 1.0 / np.sqrt(weights.sum())
    share = gentle / gentle.sum()
    effective = 1.0 / float(share @ share)
    if effective < 2.0:
        return float(np.hypot(within, 0.5 * width))
    scatter = np.sqrt(float(share**2 @ steps**2) * effective / (effective - 1.0))
    return float(max(within, scatter))

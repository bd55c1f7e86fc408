"""The clock of a log of forces against that of a log of angles: force follows the motion, alike there and back."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.reduction.clocks.lag_minima import PARTS, are_distinguished, lag_minima, nearest_minimum
from stiffcal.reduction.clocks.offsets import SourceClockOffset
from stiffcal.reduction.logs.blocks import noise_of

# What an encoder behind a gear shows of a joint that is held: below a fifth of an arc second nothing has moved.
STANDS_RAD = 1e-6
# A joint has moved where its span is this many times its reading's noise or step.
MOVED = 10.0
# Two logs of one run have at least this share of the shorter one in common.
LEAST_OVERLAP = 0.6
# Of the even grid on which both logs are compared: its work grows with them.
_MOST_POINTS = 1 << 13
# Bins of the angle in which the force is compared on the way there and back.
_BINS = 120
# A lag that moves by less has settled, s.
_SETTLED_S = 1e-6
# Lags that are tried in half a period: the openness of a loop bends on the scale of the loop's flanks.
_SCANNED = 128
# Lags within so many standard uncertainties are one.
_SAME_LAG = 5.0
# Of a period, on each side of the lag at which both logs agree best: beyond it the motion goes the other way.
_OF_PERIOD = 0.25
# Steps of the grid in the shortest period that is looked for: fewer show no shape.
_LEAST_PERIOD = 8.0
# Of a step: two halves of a run that agree by chance know the lag no better.
_LEAST_SPREAD = 0.05
# Of a component's range, for the noise of one that shows none.
_LEAST_NOISE = 1e-6
# Readings by which the direction of the force is found: it is one direction of six.
_FOR_DIRECTION = 2000
_NOT_FOLLOWED = "the force does not follow the motor motion"


def lag_of(time: Floats, angle: Floats, other_time: Floats, wrench: Floats) -> SourceClockOffset:
    """Return by how much the wrench's clock is ahead, from the force that follows the motion.

    First the lag at which both logs agree best over all they have in common; then the one at which the force is most
    nearly a curve over the angle, the same on the way there and back.

    Parameters
    ----------
    time, angle : (n,) s and rad. other_time : (m,) s. wrench : (m, 6).

    Returns
    -------
    SourceClockOffset
        Its ``value`` is None, with the reason, where no force follows the motion, or fits it at several lags.
    """
    if min(time.size, other_time.size) < 2:  # logs of a moment hold no motion
        return SourceClockOffset(None, None, _NOT_FOLLOWED)
    step = max(
        float(np.median(np.diff(time))), float(np.median(np.diff(other_time))),
        max(np.ptp(time), np.ptp(other_time)) / _MOST_POINTS,
    )  # fmt: skip
    force = leading_component(wrench)
    if np.ptp(angle) < STANDS_RAD or force is None:
        return SourceClockOffset(None, None, _NOT_FOLLOWED)
    a = np.interp(np.arange(time[0], time[-1], step), time, angle)
    b = np.interp(np.arange(other_time[0], other_time[-1], step), other_time, force)
    if min(a.size, b.size) < 2:
        return SourceClockOffset(None, None, _NOT_FOLLOWED)
    a, b = a - a.mean(), b - b.mean()
    size = 1 << int(np.ceil(np.log2(a.size + b.size)))
    product = np.abs(np.fft.irfft(np.fft.rfft(b, size) * np.conj(np.fft.rfft(a, size)), size))
    lags = np.arange(size)
    lags = np.where(lags < b.size, lags, lags - size)
    overlap = np.minimum(b.size, lags + a.size) - np.maximum(0, lags)
    coarse = int(np.argmax(np.where(overlap >= LEAST_OVERLAP * min(a.size, b.size), product, -1.0)))
    shift = float(lags[coarse]) * step
    start = float(other_time[0] - time[0]) + shift
    # The period's own shape makes the product flat at its top; the narrow loop is found nearby.
    period = max(_period(a, step), _LEAST_PERIOD * step)
    width = _OF_PERIOD * period

    def openness(part: Booleans) -> Callable[[float], float]:
        return lambda lag: _openness(time[part], angle[part], other_time, force, lag)

    spacing = max(2.0 * width / _SCANNED, step)
    best, *rivals = lag_minima(
        openness(np.ones(time.size, dtype=np.bool_)), start - width, start + width, spacing, _SETTLED_S
    )
    if not best.inside:
        return SourceClockOffset(
            None, None, "the force follows the motion best at the end of the range of lags searched"
        )
    halves = [openness(half) for half in (time < np.median(time), time >= np.median(time))]
    half_lags = [nearest_minimum(half, best.lag, step, width, _SETTLED_S).lag for half in halves]
    spread = float(max(0.5 * abs(half_lags[0] - half_lags[1]), _LEAST_SPREAD * step))
    edges = np.quantile(time, np.linspace(0.0, 1.0, PARTS + 1))
    parts = [openness((time >= first) & (time <= last)) for first, last in pairwise(edges)]
    for rival in rivals:
        same = abs(rival.lag - best.lag) <= max(_SAME_LAG * spread, 2.0 * spacing)
        if not same and not are_distinguished(*([part(lag) for part in parts] for lag in (best.lag, rival.lag))):
            reason = f"the force follows the motion as well at {best.lag:.3g} s as at {rival.lag:.3g} s"
            return SourceClockOffset(None, None, reason)
    return SourceClockOffset(best.lag, spread)


def leading_component(wrench: Floats) -> Floats | None:
    """Return (m,) the combination of components that moves most over its noise, or None where none moves."""
    noise = noise_of(wrench)
    scale = np.where(noise > 0.0, noise, np.maximum(np.ptp(wrench, axis=0) * _LEAST_NOISE, 1e-12))
    scaled = (wrench - np.median(wrench, axis=0)) / scale
    if not np.ptp(scaled, axis=0).max() > 2.0 * MOVED:
        return None
    thin = scaled[:: max(1, len(scaled) // _FOR_DIRECTION)]
    _, _, axes = np.linalg.svd(thin, full_matrices=False)
    return np.asarray(scaled @ axes[0])


def _period(a: Floats, step: float) -> float:
    """Return the time of one sweep to and fro, s: twice the time between crossings of the middle."""
    middle = 0.5 * (a.max() + a.min())
    crossings = np.flatnonzero(np.diff(np.signbit(a - middle)))
    return float(2.0 * step * np.median(np.diff(crossings))) if crossings.size > 2 else a.size * step


def _openness(time: Floats, angle: Floats, other_time: Floats, force: Floats, lag: float) -> float:
    """Return how far the force is from one curve over the angle: its mean variance about a line in each narrow bin."""
    at = np.interp(time + lag, other_time, force)
    low = angle.min()
    bins = np.minimum((_BINS * (angle - low) / max(np.ptp(angle), 1e-15)).astype(np.int64), _BINS - 1)
    count = np.maximum(np.bincount(bins, minlength=_BINS), 1)

    def within(values: Floats) -> Floats:
        return np.asarray(values - (np.bincount(bins, weights=values, minlength=_BINS) / count)[bins])

    f, a = within(at), within(angle)
    spread = np.bincount(bins, weights=a**2, minlength=_BINS)
    slope = np.bincount(bins, weights=a * f, minlength=_BINS) / np.maximum(spread, np.finfo(float).tiny)
    return float(np.mean((f - slope[bins] * a) ** 2))

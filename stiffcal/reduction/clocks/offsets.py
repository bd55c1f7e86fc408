"""Offsets between the clocks of one run's logs, from what the devices measured in common.

Why two steps: load cycles repeat, so the whole log is needed to find the right cycle (a regression of one log on the
other at every lag, by Fourier transforms); but between holds instruments wander by more than a ramp resolves, so the
last milliseconds come from the ramps alone, each with its own level and gain. The scatter of the ramps' own answers
is the uncertainty.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Annotated

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.documents import KeyIf, Number
from stiffcal.quantities import unit, unit_names
from stiffcal.reduction.clocks.ramps import MOST_STEPS, Integral, ramp_answers, robust_mean, spread_of
from stiffcal.reduction.holds.finding import Holds, find_holds
from stiffcal.reduction.logs.blocks import noise_of
from stiffcal.wording import significant

LEAST_OVERLAP = 0.3  # of the shorter log
# Logs of one run begin and end within a part of it; a rate or unit that is wrong is so by more than this factor.
MOST_APART = 3.0
# Logs of one run that differ in length by more than this share do not hold the same loads.
AS_LONG = 0.1
MOST_GRID = 1 << 14  # points of the common grid on which every lag is tried
# A log moves where the slow part of it, so many means, scatters by more than white noise leaves of them: 200 means of
# that scatter by 1 ± 0.05, and half as much again leaves room for noise that is not quite white. A few readings move
# where they differ at all.
FEW_READINGS, MEANS, MOVING = 16, 200, 1.5
# A log follows another where a regression explains so many squares of noise for each of its numbers, and so many more:
# χ² of n numbers is below n + 2 √(n t) + 2 t but for e⁻ᵗ (Laurent and Massart 2000), for one of 16 000 lags in ten
# thousand runs t is 19, and noise of logs is not white. And this share of all squares, as a drift of both explains
# some.
FOLLOWS_PER_NUMBER, FOLLOWS, LEAST_SHARE = 4.0, 60.0, 0.02
# A second lag counts where it explains as much but for this factor; what is explained whole has no second one.
AGAIN, WHOLLY = 1.02, 0.999
# Steps from hold to hold agree by so much in −2 times the log-likelihood for each number, and so much more: likewise,
# of the one lag, with t = 5.
STEPS_PER_NUMBER, STEPS = 3.0, 10.0
SETTLED_S = 1e-6  # a lag that moves by less has settled: a fiftieth of the quickest logs' step
# Of a log's range, for the noise of one that shows none (coarse digits, a simulation): less than any sensor's.
LEAST_NOISE, LEAST_NOISE_OF_LOAD = 1e-6, 1e-9
ROUNDING = 1e-6  # of a step of the grid: a reading that is on a grid point but for rounding is on it
OF_STILL_COMPONENT = 1e-6  # of a regression's mean square: components of a load that do not move have no gain
LEAST_LEFT = 1e-9  # of the squares: what is explained whole has a finite likelihood
OF_RAMP = 0.25  # of the usual ramp: over it the load is averaged, so that a ramp has four such means
SPARE_STEPS = 4  # steps more than components of a load: fewer show no contradiction
RANK = 1e-6  # of the largest step: components that do not move
END_SHARE = 0.25  # of a stretch at each end, whose means give its step
LEAST_HOLDS = 4  # whose ramps determine a lag: three, of which two can outvote one
MOST_OF_HOLD = 0.4  # of the way from hold to hold, on each side of a ramp: windows do not meet
LEAST_OF_HOLD = 0.2  # of a hold on each side of a ramp: its level is known
LEVEL_READINGS, NEARLY_ALL = 4.0, 0.9  # likewise of a slow log: so many readings, of no more than this of the hold
WINDOWS, RAMPS_A_WINDOW = 24, 10.0  # where there are no holds: equal stretches, each averaged over a tenth of it


@dataclass(frozen=True)
class SharedSignal:
    """What a device measured that another may have measured too, on its own clock."""

    source: str
    """The source's name."""
    time: Floats
    """(m,) s."""
    values: Floats
    """(m, c) wrench, position, joint angles, lengths: anything that follows the load linearly, nearly."""
    leads: bool
    """True for the load itself (wrench): the others are regressed on it."""

    @cached_property
    def holds(self) -> Holds:
        """Where its values stand still: every other log that is aligned to this one asks for them."""
        return find_holds(self.time, self.values)


@dataclass(frozen=True)
class SourceClockOffset:
    """How much more a source's clock shows than the first source's, s."""

    value: Number
    """None where nothing is shared."""
    std: Number
    """Standard uncertainty; 0 where the value was given."""
    reason: Annotated[str, KeyIf("has_reason")] = ""
    """Why there is no value."""
    rate: Annotated[Number, KeyIf("has_rate")] = None
    """How much the clock gains on that of ``rate_against``, s per s; None where the run does not determine it."""
    rate_std: Annotated[Number, KeyIf("has_rate")] = None
    """Its standard uncertainty."""
    rate_against: Annotated[str, KeyIf("has_rate")] = ""
    """A source."""

    @property
    def has_reason(self) -> bool:
        """Whether there is something to explain."""
        return bool(self.reason)

    @property
    def has_rate(self) -> bool:
        """Whether the rate is known."""
        return self.rate is not None


def align_clocks(
    signals: Sequence[SharedSignal], stated_offsets: Mapping[str, float] | None = None
) -> dict[str, SourceClockOffset]:
    """Find every source's clock against the first one's.

    Parameters
    ----------
    signals : one per source, the first being the clock that counts. Start times carry no information.
    stated_offsets : offsets that the manifest states, s; they are taken as they are.

    Returns
    -------
    Source to offset. A source that shares nothing with the first is tried against those already aligned.
    """
    stated_offsets = dict(stated_offsets or {})
    first = signals[0]
    offsets = {first.source: SourceClockOffset(0.0, 0.0)}
    for signal in signals[1:]:
        if signal.source in stated_offsets:
            offsets[signal.source] = SourceClockOffset(
                float(stated_offsets[signal.source]), 0.0, "given in the manifest"
            )
    waiting = [signal for signal in signals[1:] if signal.source not in offsets]
    reasons: dict[str, str] = {}
    # the load first: what follows it is best aligned to it
    waiting.sort(key=lambda signal: not signal.leads)
    for signal in waiting:
        measured_offsets = [
            signal_on_clock
            for signal_on_clock in signals
            if signal_on_clock.source in offsets and offsets[signal_on_clock.source].value is not None
        ]
        measured_offsets.sort(
            key=lambda signal_on_clock: (not signal_on_clock.leads, signal_on_clock.source != first.source)
        )
        for reference in measured_offsets:
            offset = offset_between(reference, signal)
            if offset.value is None:
                reasons.setdefault(signal.source, offset.reason)
                continue
            base = offsets[reference.source]
            assert base.value is not None
            assert base.std is not None
            assert offset.std is not None
            offsets[signal.source] = SourceClockOffset(base.value + offset.value, float(np.hypot(base.std, offset.std)))
            break
        else:
            offsets[signal.source] = SourceClockOffset(
                None, None, reasons.get(signal.source, "no other log to align to")
            )
    return {signal.source: offsets[signal.source] for signal in signals}


def offset_between(first: SharedSignal, second: SharedSignal) -> SourceClockOffset:
    """Return how much more ``second``'s clock shows than ``first``'s."""
    if not moves(first.values):
        return SourceClockOffset(None, None, f"{first.source} contains only noise")
    if not moves(second.values):
        return SourceClockOffset(None, None, f"{second.source} contains only noise: nothing shared with {first.source}")
    if second.leads and not first.leads:
        reverse_offset = offset_between(second, first)
        return SourceClockOffset(
            None if reverse_offset.value is None else -reverse_offset.value, reverse_offset.std, reverse_offset.reason
        )
    coarse = _coarse_lag(first, second)
    if isinstance(coarse, str):
        return SourceClockOffset(None, None, coarse)
    return _refine_lag(first, second, coarse)


def offset_near(first: SharedSignal, second: SharedSignal, lag: float) -> SourceClockOffset:
    """Return how much more ``second``'s clock shows than ``first``'s, where it is nearly known."""
    if not moves(first.values) or not moves(second.values):
        return SourceClockOffset(None, None, "one of them contains only noise")
    return _refine_lag(first, second, lag)


def moves(values: Floats) -> bool:
    """Return whether a log shows more than noise: its slow part against what white noise would leave of it.

    Examples
    --------
    >>> import numpy as np
    >>> moves(np.random.default_rng(0).normal(size=(1000, 6)))
    False
    """
    if len(values) < FEW_READINGS:
        return bool(np.ptp(values, axis=0).max(initial=0.0) > 0.0) if len(values) > 1 else False
    noise = noise_of(values)
    size = max(len(values) // MEANS, 1)
    n_used = (len(values) // size) * size
    means = values[:n_used].reshape(-1, size, values.shape[1]).mean(axis=1)
    quiet = noise == 0.0
    if quiet.any() and bool((np.ptp(values[:, quiet], axis=0) > 0.0).any()):
        return True
    spread = means.std(axis=0) / np.maximum(noise / np.sqrt(size), np.finfo(float).tiny)
    return bool((spread[~quiet] > MOVING).any())


def _coarse_lag(first: SharedSignal, second: SharedSignal) -> float | str:
    """Return the lag at which a regression of ``second`` on ``first`` leaves least, s, or why there is none."""
    span = max(np.ptp(first.time), np.ptp(second.time))
    step = max(_interval(first.time), _interval(second.time), span / MOST_GRID)
    u = _on_grid(first, step)
    y = _on_grid(second, step)
    u = (u - u.mean(axis=0)) / np.maximum(u.std(axis=0), 1e-12 * max(np.abs(u).max(), 1e-300))
    noise = np.maximum(noise_of(second.values), LEAST_NOISE * np.maximum(np.ptp(second.values, axis=0), 1e-300))
    y = (y - y.mean(axis=0)) / noise
    lags, gain, share = _gain_of_lags(u, y)
    if lags.size == 0:
        return f"{first.source} and {second.source} overlap too little{_of_another_length(first, second)}"
    best = int(np.argmax(gain))
    n_free = u.shape[1] * y.shape[1]
    explained = share[best] * min(len(u), len(y))
    if explained < FOLLOWS_PER_NUMBER * n_free + FOLLOWS or share[best] < LEAST_SHARE:
        return f"{second.source} does not follow {first.source}{_of_another_length(first, second)}"
    # the next best lag outside the peak: loads that repeat exactly do not distinguish one cycle from the next
    falls = np.flatnonzero(gain < 0.5 * gain[best])
    left = falls[falls < best].max(initial=-1)
    right = falls[falls > best].min(initial=gain.size)
    elsewhere = np.concatenate([gain[: left + 1], gain[right:]])
    if elsewhere.size and share[best] < WHOLLY and gain[best] < AGAIN * elsewhere.max():
        found = f"the loads repeat: {second.source} matches {first.source} at more than one time offset"
        lasts, other = float(np.ptp(second.time)), float(np.ptp(first.time))
        if min(lasts, other) > (1.0 - AS_LONG) * max(lasts, other):
            return found
        return (
            f"{found}, and lasts {significant(lasts, 4)} s where that lasts {significant(other, 4)} "
            f"s: did the log of one end early?"
        )
    return float(lags[best] * step + second.time[0] - first.time[0])


def _of_another_length(first: SharedSignal, second: SharedSignal) -> str:
    """Return in words that the two logs last so differently that a rate or a unit of time is wrong, or "".

    Which unit it is, the logs decide: with times in it one follows the other.
    """
    lasts, other = float(np.ptp(second.time)), float(np.ptp(first.time))
    if _as_long(lasts, other):
        return ""
    sentence = f"; {second.source} lasts {significant(lasts, 4)} s, {first.source} {significant(other, 4)} s: "
    for name in unit_names("time"):
        factor = unit(name, "time").factor
        for scale, numbers, taken in ((factor, name, "s"), (1.0 / factor, "s", name)):
            if not _as_long(scale * lasts, other):
                continue
            scaled = SharedSignal(second.source, scale * second.time, second.values, second.leads)
            if not isinstance(_coarse_lag(first, scaled), str):
                return (
                    f"{sentence}they agree where the times of {second.source} are in {numbers} and were taken for "
                    f"{taken}, or those of {first.source} the other way round"
                )
    return f"{sentence}check rate_hz or the unit of time of both"


def _as_long(lasts: float, other: float) -> bool:
    return other <= MOST_APART * lasts and lasts <= MOST_APART * other


def _interval(time: Floats) -> float:
    return float(np.median(np.diff(time)))


def _on_grid(signal: SharedSignal, step: float) -> Floats:
    """Return the values averaged in steps from the log's start, gaps filled from their neighbours."""
    index = np.floor((signal.time - signal.time[0]) / step + ROUNDING).astype(np.int64)
    n = int(index[-1]) + 1
    count = np.bincount(index, minlength=n)
    sums = np.stack([np.bincount(index, weights=column, minlength=n) for column in signal.values.T], axis=1)
    have = np.flatnonzero(count)
    means = sums[have] / count[have, None]
    if have.size == n:
        return np.asarray(means)
    return np.stack([np.interp(np.arange(n), have, column) for column in means.T], axis=1)


def _gain_of_lags(u: Floats, y: Floats) -> tuple[Floats, Floats, Floats]:
    """Regress y (N, c) on u (M, p) at every lag: y[i] against u[i - lag].

    Returns lags, the gain in log-likelihood over a constant, and the share of y's square sum that is explained.
    """
    n_u, n_y = len(u), len(y)
    design = np.concatenate([np.ones((n_u, 1)), u], axis=1)
    lags = np.arange(-(n_u - 1), n_y)
    first, last = np.maximum(lags, 0), np.minimum(n_y, n_u + lags)  # the part of y that has a partner
    overlap = last - first
    keep = overlap >= max(LEAST_OVERLAP * min(n_u, n_y), 2 * design.shape[1])
    lags, first, last, overlap = lags[keep], first[keep], last[keep], overlap[keep]
    if lags.size == 0:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    outer = np.zeros((n_u + 1, design.shape[1], design.shape[1]))
    np.cumsum(design[:, :, None] * design[:, None, :], axis=0, out=outer[1:])
    gram = outer[last - lags] - outer[first - lags]
    size = 1 << int(np.ceil(np.log2(n_u + n_y)))
    spectrum_u = np.conj(np.fft.rfft(design, size, axis=0))
    spectrum_y = np.fft.rfft(y, size, axis=0)
    cross = np.empty((lags.size, design.shape[1], y.shape[1]))
    for column in range(y.shape[1]):
        cross[:, :, column] = np.fft.irfft(spectrum_u * spectrum_y[:, column : column + 1], size, axis=0)[lags % size]
    ridge = (
        OF_STILL_COMPONENT * np.trace(gram, axis1=1, axis2=2)[:, None, None] / design.shape[1] * np.eye(design.shape[1])
    )
    explained = np.einsum("lpc,lpc->l", cross, np.linalg.solve(gram + ridge, cross))
    squares = np.concatenate([np.zeros((1, y.shape[1])), np.cumsum(y * y, axis=0)])
    sums = np.concatenate([np.zeros((1, y.shape[1])), np.cumsum(y, axis=0)])
    total = (squares[last] - squares[first]).sum(axis=1)
    constant = ((sums[last] - sums[first]) ** 2).sum(axis=1) / overlap
    about = np.maximum(total - constant, 1e-300)
    residual = np.clip(total - explained, LEAST_LEFT * about, about)
    return lags.astype(np.float64), overlap * np.log(about / residual), 1.0 - residual / about


def _refine_lag(first: SharedSignal, second: SharedSignal, lag: float) -> SourceClockOffset:
    """Refine a lag on the ramps between holds (on equal windows where there are no holds)."""
    width = max(_interval(second.time), _interval(first.time))
    windows = _windows(first, first.holds, width)
    if not _steps_agree(windows, first, second, lag):
        return SourceClockOffset(None, None, f"{second.source} does not show the load steps in {first.source}")
    noise = np.maximum(noise_of(second.values), LEAST_NOISE * np.maximum(np.ptp(second.values, axis=0), 1e-300))
    white = second.values / noise
    running = Integral(
        first.time,
        first.values / np.maximum(noise_of(first.values), LEAST_NOISE_OF_LOAD * np.ptp(first.values) + 1e-300),
    )
    scale = max(width, OF_RAMP * float(np.median([ramp for _, _, ramp in windows])))
    move, share, steps, weights, gentle = np.inf, 1.0, *np.zeros((3, 0))
    for _ in range(MOST_STEPS):
        steps, weights = ramp_answers(windows, running, second.time, white, lag, scale)
        if steps.size == 0:
            return SourceClockOffset(None, None, f"no load step is in both {first.source} and {second.source}")
        mean, gentle = robust_mean(steps, weights)
        before, move = move, float(np.clip(mean, -scale, scale))
        if np.isfinite(before) and move * before < 0.0 and abs(move) > 0.5 * abs(before):
            share *= 0.5  # to and fro between two lags: each full step goes beyond what lies between them
        lag += share * move
        if share * abs(move) < SETTLED_S:
            break
    spread = spread_of(steps, weights, gentle, width)
    if abs(move) > max(spread, SETTLED_S):
        return SourceClockOffset(
            None, None, f"the time offset between {first.source} and {second.source} does not converge"
        )
    # Ramps come into the windows and leave them: what the lag still moves by is not known of it.
    return SourceClockOffset(lag, spread if abs(move) < SETTLED_S else float(np.hypot(spread, move)))


def _steps_agree(
    windows: Sequence[tuple[float, float, float]], first: SharedSignal, second: SharedSignal, lag: float
) -> bool:
    """Return whether the steps of one log follow those of the other, linearly, beyond chance.

    Two logs that merely wander agree somewhere over their whole length; their steps from hold to hold do not.
    """
    steps = [(_step(first, begin, end), _step(second, begin + lag, end + lag)) for begin, end, _ in windows]
    complete = [(a, b) for a, b in steps if a is not None and b is not None]
    n_free = first.values.shape[1]
    if len(complete) < n_free + SPARE_STEPS:
        return True  # too few to judge by
    u, y = np.stack([a for a, _ in complete]), np.stack([b for _, b in complete])
    y = y / np.maximum(np.sqrt(np.mean(y**2, axis=0)), 1e-300)
    residual = y - u @ np.linalg.lstsq(u, y, rcond=RANK)[0]
    share = float(np.sum(residual**2) / np.sum(y**2))
    return bool(len(complete) * np.log(1.0 / max(share, 1e-12)) > STEPS_PER_NUMBER * n_free + STEPS)


def _step(signal: SharedSignal, begin: float, end: float) -> Floats | None:
    """Return the change of a log from the first to the last quarter of a stretch, None where it has no readings."""
    quarter = END_SHARE * (end - begin)
    a, b, c, d = np.searchsorted(signal.time, [begin, begin + quarter, end - quarter, end])
    if a >= b or c >= d:
        return None
    return np.asarray(signal.values[c:d].mean(axis=0) - signal.values[a:b].mean(axis=0))


def _windows(signal: SharedSignal, holds: Holds, width: float) -> list[tuple[float, float, float]]:
    """Return begin, end and ramp time of the stretches that determine the lag."""
    if len(holds) >= LEAST_HOLDS:
        ramp = holds.reached[1:] - holds.left[:-1]
        margin = np.minimum(
            np.maximum(ramp, 0.0), MOST_OF_HOLD * np.minimum(np.diff(holds.left), np.diff(holds.reached))
        )
        # on either side enough to know the level: of a slow log four readings
        margin = np.maximum(margin, LEAST_OF_HOLD * (holds.left - holds.reached)[1:])
        shorter_hold = np.minimum((holds.left - holds.reached)[1:], (holds.left - holds.reached)[:-1])
        margin = np.maximum(margin, np.minimum(LEVEL_READINGS * width, NEARLY_ALL * shorter_hold))
        return [
            (float(a), float(b), float(r))
            for a, b, r in zip(holds.left[:-1] - margin, holds.reached[1:] + margin, ramp, strict=True)
        ]
    edges = np.linspace(signal.time[0], signal.time[-1], WINDOWS + 1)
    return [(float(a), float(b), float(b - a) / RAMPS_A_WINDOW) for a, b in pairwise(edges)]

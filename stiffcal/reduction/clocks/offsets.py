"""Offsets between the clocks of one run's logs, from what the devices measured in common.

Why two steps: load cycles repeat, so the whole log is needed to find the right cycle (a regression of one log on the
other at every lag, by Fourier transforms); but between holds instruments wander by more than a ramp resolves, so the
last milliseconds come from the ramps alone, each with its own level and gain. The scatter of the ramps' own answers
is the uncertainty.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.documents import KeyIf, Number
from stiffcal.reduction.clocks.gaps import set_in_a_gap
from stiffcal.reduction.clocks.lag_search import (
    LEAST_NOISE,
    LEAST_NOISE_OF_LOAD,
    SharedSignal,
    coarse_lag,
    interval_of,
    moves,
)
from stiffcal.reduction.clocks.ramps import MOST_STEPS, Integral, ramp_answers, robust_mean, spread_of
from stiffcal.reduction.holds.finding import Holds
from stiffcal.reduction.logs.blocks import noise_of

# Steps from hold to hold agree by so much in −2 times the log-likelihood for each number, and so much more: likewise,
# of the one lag, with t = 5.
STEPS_PER_NUMBER, STEPS = 3.0, 10.0
SETTLED_S = 1e-6  # a lag that moves by less has settled: a fiftieth of the quickest logs' step
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
    coarse = coarse_lag(first, second)
    if isinstance(coarse, str):
        return SourceClockOffset(None, None, coarse)
    clock_set = set_in_a_gap(first, second, coarse)
    if clock_set:
        return SourceClockOffset(None, None, clock_set)
    return _refine_lag(first, second, coarse.value)


def offset_near(first: SharedSignal, second: SharedSignal, lag: float) -> SourceClockOffset:
    """Return how much more ``second``'s clock shows than ``first``'s, where it is nearly known."""
    if not moves(first.values) or not moves(second.values):
        return SourceClockOffset(None, None, "one of them contains only noise")
    return _refine_lag(first, second, lag)


def _refine_lag(first: SharedSignal, second: SharedSignal, lag: float) -> SourceClockOffset:
    """Refine a lag on the ramps between holds (on equal windows where there are no holds)."""
    width = max(interval_of(second.time), interval_of(first.time))
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

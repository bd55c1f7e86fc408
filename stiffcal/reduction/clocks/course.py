"""Clocks that do not run evenly relative to each other: a drift in parts per million, a jump in the middle of a run.

One offset per run is what the states are made with. Here the run is cut into pieces, each aligned by itself, and what
the offsets do from piece to piece is given, where it is more than their own uncertainty and matters to a hold. How fast
a clock gains on the other, and how well that is known, stands next to its offset in any case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.quantity import DELAY, RATE
from stiffcal.reduction.clocks.offsets import SharedSignal, SourceClockOffset, offset_near
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import in_unit

PIECES = 6  # of a log: two on either side of a step, and those it may lie in; each has to hold ramps of its own
LEAST_PIECES = 4  # with an answer: a line and a step have three numbers, and one is left to contradict them
# Holds are read from a few hundredths of their second after the ramp: less than this moves no reading out of its hold.
MATTERS_S = 0.03
SURE = 6.0  # standard uncertainties
CLEARLY = 4.0  # times the squares left by a straight line that a step must save


def clock_courses(
    run: str, shared: Sequence[SharedSignal], clocks: Mapping[str, SourceClockOffset]
) -> tuple[dict[str, SourceClockOffset], list[str]]:
    """Find how the clocks run relative to that of the load.

    Parameters
    ----------
    run : its name.
    shared : the signal of each device.
    clocks : source to the offset of the whole run.

    Returns
    -------
    The clocks, with their rates where these can be determined, and a line for every one that does not run evenly.
    """
    with_rates = dict(clocks)
    leading = next((signal for signal in shared if signal.leads and clocks[signal.source].value is not None), shared[0])
    remarks: list[str] = []
    for signal in shared:
        leading_offset, signal_offset = clocks[leading.source].value, clocks[signal.source].value
        if signal is leading or leading_offset is None or signal_offset is None or clocks[signal.source].reason:
            continue
        time, offset, std = _pieces(leading, signal, signal_offset - leading_offset)
        if time.size >= LEAST_PIECES:
            rate, rate_std, lines = _course(run, leading.source, signal.source, time, offset, std)
            with_rates[signal.source] = replace(
                clocks[signal.source], rate=rate, rate_std=rate_std, rate_against=leading.source
            )
            remarks += lines
    return with_rates, remarks


def _pieces(first: SharedSignal, second: SharedSignal, lag: float) -> tuple[Floats, Floats, Floats]:
    """Return middle, offset and standard uncertainty of the pieces that can be aligned by themselves, s."""
    begin, end = max(first.time[0], second.time[0] - lag), min(first.time[-1], second.time[-1] - lag)
    edges = np.linspace(begin, end, PIECES + 1)
    offsets = []
    for a, b in pairwise(edges):
        piece, second_piece = _cut(first, a, b), _cut(second, a + lag, b + lag)
        if len(piece.time) < 32 or len(second_piece.time) < 16:
            continue
        offset = offset_near(piece, second_piece, lag)
        if offset.value is not None and offset.std is not None and abs(offset.value - lag) < 0.5 * (b - a):
            offsets.append((0.5 * (a + b), offset.value, offset.std))
    table = np.array(offsets).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2]


def _cut(signal: SharedSignal, begin: float, end: float) -> SharedSignal:
    samples = slice(*np.searchsorted(signal.time, [begin, end]))
    return SharedSignal(signal.source, signal.time[samples], signal.values[samples], signal.leads)


def _course(
    run: str, leader: str, name: str, time: Floats, offset: Floats, std: Floats
) -> tuple[float, float, list[str]]:
    """Return the rate at which a clock gains on the other, its standard uncertainty, and a warning on it."""
    weight = 1.0 / np.maximum(std, 1e-3) ** 2
    about = np.average(time, weights=weight)
    leverage = float(weight @ (time - about) ** 2)
    slope = float((weight * (time - about)) @ offset) / leverage
    left_line = _misfit(offset - slope * time, weight)
    steps = [(_misfit(offset[:k], weight[:k]) + _misfit(offset[k:], weight[k:]), k) for k in range(1, time.size)]
    left_step, k = min(steps)
    before, after = (float(np.average(offset[p], weights=weight[p])) for p in (slice(k), slice(k, None)))
    jump = after - before
    spread = np.sqrt(1.0 / weight[:k].sum() + 1.0 / weight[k:].sum())
    degrees = max(time.size - 2, 1)
    slope_std = float(np.sqrt(max(left_line / degrees, 1.0) / leverage))
    if abs(jump) > max(SURE * spread, MATTERS_S) and left_line > CLEARLY * max(left_step, degrees):
        line = (
            f"run {run}: the clock of {name} jumps by {jump:+.3f} s against {leader} between {time[k - 1]:.1f} s and "
            f"{time[k]:.1f} s; one offset is used for the whole run: correct the times in a copy of the log, "
            "or split the run there"
        )
        return slope, slope_std, [line]
    span = float(np.ptp(time)) * PIECES / (PIECES - 1)
    if abs(slope) > SURE * slope_std and abs(slope) * span > MATTERS_S:
        ppm = RATE.usual
        line = (
            f"run {run}: the clock of {name} gains {ppm.factor * slope:+.0f} ± "
            f"{ppm.factor * NORMAL_95 * slope_std:.0f} {ppm.name} "
            f"on {leader}, "
            f"{in_unit(abs(slope) * span, DELAY.usual)} over the run; one offset, that of its middle, "
            f"is used: dwells shorter "
            "than that are misread; correct the times in a copy of the log, or split the run"
        )
        return slope, slope_std, [line]
    return slope, slope_std, []


def _misfit(offset: Floats, weight: Floats) -> float:
    return float(weight @ (offset - np.average(offset, weights=weight)) ** 2)

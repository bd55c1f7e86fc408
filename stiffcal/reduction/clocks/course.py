"""How the clocks of a run's logs run relative to each other.

One offset per run is what the states are made with. Here the run is cut into pieces, each aligned by itself. How fast
a clock gains on the other, and how well that is known, stands next to its offset; whether the course is one of a clock
that is in order is judged by `stiffcal.mistakes.clocks`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.reduction.clocks.lag_search import SharedSignal
from stiffcal.reduction.clocks.offsets import SourceClockOffset, offset_between, offset_near

PIECES = 6  # of a log: two on either side of a step, and those it may lie in; each has to hold ramps of its own
LEAST_PIECES = 4  # with an answer: a line and a step have three numbers, and one is left to contradict them
LEAST_READINGS, LEAST_OTHERS = 32, 16  # of a piece in the log of the load and in the other one: less is no ramp
LEAST_STD_S = 1e-3  # of a piece's offset: what clocks of computers wander by within one
NEAR = 0.5  # of a piece's length, by which its offset may differ from the run's: more is another load


@dataclass(frozen=True)
class ClockCourse:
    """Where a clock stands against the first source's, in k pieces of a run."""

    source: str
    """Whose clock it is."""
    against: str
    """The source with which the pieces were aligned."""
    time: Floats
    """(k,) s, the middle of each piece, on the clock of ``against``."""
    offset: Floats
    """(k,) s that it shows more than the first source's clock."""
    std: Floats
    """(k,) s, standard uncertainties."""
    stated: float | None = None
    """s, what the manifest says of it; None where the offset is estimated."""

    @property
    def weight(self) -> Floats:
        """(k,) 1/s²."""
        return np.asarray(1.0 / np.maximum(self.std, LEAST_STD_S) ** 2)

    @property
    def lasts(self) -> float:
        """How long the run lasts, s."""
        return float(np.ptp(self.time)) * PIECES / (PIECES - 1)

    @property
    def rate(self) -> float:
        """How much the clock gains, s per s."""
        away = self._away
        return float((self.weight * away) @ self.offset / (self.weight @ away**2))

    @property
    def rate_std(self) -> float:
        """Its standard uncertainty, by the scatter about the line where that is more than the pieces'."""
        left = self.misfit(self.offset - self.rate * self.time)
        degrees = max(self.time.size - 2, 1)
        return float(np.sqrt(max(left / degrees, 1.0) / (self.weight @ self._away**2)))

    @property
    def _away(self) -> Floats:
        return self.time - np.average(self.time, weights=self.weight)

    def misfit(self, offset: Floats, pieces: slice = slice(None)) -> float:
        """Return the weighted squares about the mean of offsets (k,), of some of the pieces."""
        weight, own = self.weight[pieces], offset[pieces]
        return float(weight @ (own - np.average(own, weights=weight)) ** 2)


def clock_courses(
    shared: Sequence[SharedSignal], clocks: Mapping[str, SourceClockOffset], stated: Mapping[str, float]
) -> tuple[dict[str, SourceClockOffset], list[ClockCourse]]:
    """Find how the clocks run relative to that of the load.

    Parameters
    ----------
    shared : the signal of each device.
    clocks : source to the offset of the whole run.
    stated : those of the manifest, s.

    Returns
    -------
    The clocks, with their rates where these can be determined, and the course of each that can be compared.
    """
    with_rates = dict(clocks)
    leading = next((signal for signal in shared if signal.leads and clocks[signal.source].value is not None), shared[0])
    courses: list[ClockCourse] = []
    for signal in shared:
        leading_offset, clock = clocks[leading.source].value, clocks[signal.source]
        is_stated = signal.source in stated
        if signal is leading or leading_offset is None or clock.value is None or (clock.reason and not is_stated):
            continue
        lag = offset_between(leading, signal).value if is_stated else clock.value - leading_offset
        if lag is None:
            continue
        time, offset, std = _pieces(leading, signal, lag)
        if time.size < LEAST_PIECES:
            continue
        value = stated.get(signal.source)
        course = ClockCourse(signal.source, leading.source, time, offset + leading_offset, std, value)
        courses.append(course)
        if not is_stated:
            with_rates[signal.source] = replace(
                clock, rate=course.rate, rate_std=course.rate_std, rate_against=leading.source
            )
    return with_rates, courses


def _pieces(first: SharedSignal, second: SharedSignal, lag: float) -> tuple[Floats, Floats, Floats]:
    """Return middle, offset and standard uncertainty of the pieces that can be aligned by themselves, s."""
    begin, end = max(first.time[0], second.time[0] - lag), min(first.time[-1], second.time[-1] - lag)
    edges = np.linspace(begin, end, PIECES + 1)
    offsets = []
    for a, b in pairwise(edges):
        piece, second_piece = _cut(first, a, b), _cut(second, a + lag, b + lag)
        if len(piece.time) < LEAST_READINGS or len(second_piece.time) < LEAST_OTHERS:
            continue
        offset = offset_near(piece, second_piece, lag)
        if offset.value is not None and offset.std is not None and abs(offset.value - lag) < NEAR * (b - a):
            offsets.append((0.5 * (a + b), offset.value, offset.std))
    table = np.array(offsets).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2]


def _cut(signal: SharedSignal, begin: float, end: float) -> SharedSignal:
    samples = slice(*np.searchsorted(signal.time, [begin, end]))
    return SharedSignal(signal.source, signal.time[samples], signal.values[samples], signal.leads)

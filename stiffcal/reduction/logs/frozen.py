"""Readings that stop changing: a stuck channel, a tracker that repeats its last value when the target is lost.

An instrument's readings differ from one to the next, by noise if by nothing else; how often two in a row are equal
all the same (coarse resolution, a load that is held) shows in the rest of the log, which gives how long a row of equal
ones chance would give. Nothing is reported of channels that repeat themselves most of the time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats

CHANCE = 1e-9  # of a row of equal readings as long as this anywhere in the log
RESTLESS = 0.5  # share of equal neighbours below which a channel is one that changes
LEAST_ROW = 6  # of equal readings: fewer are common where an instrument reads in coarse steps
LEAST_READINGS = 30  # from which the share of equal neighbours is known to a tenth: 0.5 / √30


@dataclass
class FrozenChannels:
    """Counts, batch by batch, rows in which all channels (k, n) of a group stay the same."""

    n_pairs: int = 0
    """Pairs of neighbouring rows."""
    n_equal: int = 0
    """Pairs of neighbouring rows that are equal."""
    longest: int = 0
    """Readings in the longest row of equal ones."""
    first: int = 0
    """Its first row in the file."""
    last: int = 0
    """Its last row in the file."""
    value: Floats | None = None
    """(k,) its readings."""
    _row: int = 1
    _began: int = 0
    _before: Floats | None = None

    def update(self, number: NDArray[np.int64], values: Floats) -> None:
        """Look at a batch: rows' numbers (n,), values (k, n)."""
        if number.size == 0:
            return
        equal = np.empty(number.size, dtype=np.bool_)
        np.equal(values[:, 1:], values[:, :-1]).all(axis=0, out=equal[1:])
        begins = self._before is None
        equal[0] = self._before is not None and bool((values[:, 0] == self._before).all())
        self.n_pairs += number.size - begins
        self.n_equal += int(equal.sum())
        starts = np.flatnonzero(~equal)  # each begins a row of equal readings
        ends = np.append(starts[1:], number.size)
        lead = int(starts[0]) if starts.size else number.size
        if lead and not begins:
            self._row += lead
            self._keep(self._row, self._began, int(number[lead - 1]), values[:, 0])
        if starts.size:
            length = ends - starts
            k = int(np.argmax(length))
            self._keep(int(length[k]), int(number[starts[k]]), int(number[ends[k] - 1]), values[:, starts[k]])
            self._row, self._began = int(length[-1]), int(number[starts[-1]])
        self._before = values[:, -1].copy()

    def _keep(self, length: int, first: int, last: int, value: Floats) -> None:
        if length > self.longest:
            self.longest, self.first, self.last, self.value = length, first, last, value.copy()

    @property
    def frozen(self) -> bool:
        """True where the longest row of equal readings is no chance."""
        outside = self.n_pairs - (self.longest - 1)
        if self.n_pairs < LEAST_READINGS or self.longest < LEAST_ROW or outside < LEAST_ROW:
            return False
        # one more equal pair than was counted, so that a log without any is not taken for one that can have none
        usual = (self.n_equal - (self.longest - 1) + 1) / (outside + 1)
        return usual < RESTLESS and self.n_pairs * usual ** (self.longest - 1) < CHANCE

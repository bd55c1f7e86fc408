"""A few readings of each log, from rows that lie evenly apart: what logs of whole runs are compared by.

A copy of a log has the same rows, so that of two logs of equal length the same rows are taken. What is taken is what
instruments read and noise is in: forces, torques, places; joint angles of a programme that is run again may be equal.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.reduction.copies.rounded import Layout

MOST_ROWS = 32
"""That are taken; of a log with more of them at least half as many."""
_TAKEN = ("wrench", "translation", "position", "marker", "lengths", "displacement")
_TAKEN_OF_JOINTS = ("joints.torque", "joints.current")


@dataclass(frozen=True)
class SampledReadings:
    """Readings of k rows of a log."""

    layout: Layout
    """Of the c channels."""
    values: Floats
    """(k, c) in the units of the file; NaN where there is none."""
    scatter: Floats
    """(k, c) distance of each reading from the mean of the one before and the one after it: of noise, where the rows
    follow each other faster than what is measured changes."""


@dataclass
class ReadingSampler:
    """Takes the readings out of a log, batch by batch."""

    columns: Mapping[str, Sequence[str]]
    """Of each signal in the file."""
    units: Mapping[str, float]
    """What one of a column's unit is of what `update` is given; 1 of columns that are not listed."""
    _n_rows: int = 0
    _stride: int = 1
    _before: dict[str, Floats] = field(default_factory=dict)
    """Signal to its last two readings."""
    _rows: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    _values: dict[str, Floats] = field(default_factory=dict)
    _scatter: dict[str, Floats] = field(default_factory=dict)

    def update(self, signals: Mapping[str, Floats]) -> None:
        """Take in a batch: signals' names to (c, n), SI."""
        names = sorted(name for name in signals if self._is_taken(name))
        taken = {name: signals[name][: len(self.columns[name])] for name in names}
        n = next((values.shape[1] for values in taken.values()), 0)
        if n == 0:
            return
        begin, end = max(1, self._n_rows - 1), self._n_rows + n - 1  # rows of which both neighbours are known
        while (end - 1) // self._stride > MOST_ROWS:
            self._stride *= 2
        kept = self._rows % self._stride == 0
        first = -(-begin // self._stride) * self._stride
        new = np.arange(first, end, self._stride)
        for name, values in taken.items():
            before = self._before.get(name)
            known = values if before is None else np.concatenate([before, values], axis=1)
            place = new - self._n_rows + (known.shape[1] - n)
            own = known[:, place]
            apart = np.abs(own - 0.5 * (known[:, place - 1] + known[:, place + 1]))
            unit = np.array([[self.units.get(column, 1.0)] for column in self.columns[name][: len(own)]])
            for of_signal, added in ((self._values, own / unit), (self._scatter, apart / np.abs(unit))):
                earlier = of_signal[name][:, kept] if name in of_signal else np.zeros((len(own), 0))
                of_signal[name] = np.concatenate([earlier, added], axis=1)
        self._before = {
            name: np.concatenate([self._before.get(name, values[:, :0]), values[:, -2:]], axis=1)[:, -2:]
            for name, values in taken.items()
        }
        self._rows = np.concatenate([self._rows[kept], new])
        self._n_rows += n

    def readings(self) -> SampledReadings | None:
        """Return what was taken so far; None where the log holds none of it."""
        if not self._rows.size:
            return None
        layout = tuple((name, len(values)) for name, values in self._values.items())
        values, scatter = (np.concatenate(list(own.values())).T for own in (self._values, self._scatter))
        return SampledReadings(layout, values, scatter)

    def _is_taken(self, name: str) -> bool:
        is_measured = name in _TAKEN_OF_JOINTS or name.partition(".")[0] in _TAKEN
        return is_measured and bool(self.columns.get(name))

"""Block averages: a log of any length, reduced while it streams past, in bounded memory.

Why: holds, clocks and states need the log's shape, not each sample. A block keeps count, sum and sum of squares, so
means and scatter over any number of blocks are exact; when the blocks become too many, neighbours are joined and the
duration doubles. A slow log keeps every sample as its own block.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.uncertainty import MEDIAN_OF_NORMAL

# Finer than any tracker's interval (the fastest give 1 kHz, typically 25 to 100 Hz) and than the 10 ms asked of clocks.
SHORTEST_BLOCK_S = 0.005
MOST_BLOCKS = 1 << 17
# Share of the time from block to block; an interpolation over an excluded stretch gives it no more weight than this.
_SAME_TIME = 1e-3
# Variances of differences of white noise: sums of squared binomial coefficients.
SECOND_DIFFERENCE, FOURTH_DIFFERENCE = 6.0, 70.0


@dataclass(frozen=True)
class Blocks:
    """A log as m block averages, on the device's own clock."""

    time: Floats
    """(m,) s, mean of the block's sample times."""
    start: Floats
    """(m,) s, the block's first sample."""
    end: Floats
    """(m,) s, its last sample."""
    count: Integers
    """(m,) samples in the block."""
    mean: dict[str, Floats]
    """Signal name to (m, c), in the units that were fed."""
    variance: dict[str, Floats]
    """Signal name to (m, c), of single samples about the block's mean (0 where one sample)."""
    dropped: int = 0
    """Samples left out because a value was missing."""
    excluded: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    """(k, 2) s, stretches between two samples where the manifest excludes all that was logged: the times of the last
    sample before it and of the first after it."""

    def __len__(self) -> int:
        return int(self.time.shape[0])

    @property
    def interval(self) -> float:
        """Typical time from block to block, s (0 where there is one block)."""
        return float(np.median(np.diff(self.time))) if len(self) > 1 else 0.0

    def in_excluded(self, time: Floats) -> Booleans:
        """Return (n,) True where a value at a time (n,), s, would be interpolated over excluded samples.

        Samples that are excluded within a block do not count: its mean is that of the others.
        """
        middle = self.excluded.mean(axis=1)
        before = np.searchsorted(self.end, middle) - 1
        # the block after the one that ends before a stretch may hold it: then nothing is interpolated
        between = before[(before >= 0) & (self.start[np.minimum(before + 1, len(self) - 1)] > middle)]
        if between.size == 0:
            return np.zeros(time.shape, dtype=np.bool_)
        place = np.clip(np.searchsorted(self.time, time) - 1, 0, len(self) - 2)
        # rounding of times: what lies this near to a block's time is its mean
        near = _SAME_TIME * self.interval
        inside = (time > self.time[place] + near) & (time < self.time[place + 1] - near)
        return np.asarray(inside & np.isin(place, between))


class BlockAverager:
    """Consume batches of a log, in order, and keep block averages.

    Parameters
    ----------
    shortest : s, duration of a block to begin with.
    most : blocks kept; beyond that neighbours are joined.

    Examples
    --------
    >>> import numpy as np
    >>> averager = BlockAverager(shortest=1.0)
    >>> averager.add(np.array([0.0, 0.4, 1.1]), {"wrench": np.array([[1.0, 3.0, 7.0]])})
    >>> averager.blocks().mean["wrench"].ravel().tolist()
    [2.0, 7.0]
    """

    def __init__(self, shortest: float = SHORTEST_BLOCK_S, most: int = MOST_BLOCKS) -> None:
        self._duration = shortest
        self._most = most
        self._origin: float | None = None
        self._names: list[tuple[str, int]] = []
        self._zero = np.zeros(0)
        self._quaternion: dict[str, Floats] = {}
        self._index: list[Integers] = []
        # rows: count, Σ(t−t0), first, last, then Σx and Σx² of every channel (about the log's first sample)
        self._sums: list[Floats] = []
        self._stored = 0
        self.dropped = 0

    def add(self, time: Floats, signals: Mapping[str, Floats]) -> None:
        """Add a batch: time (n,) s; signals name to (c, n), channels first so that each is contiguous.

        A signal whose name begins with ``quaternion`` is brought to one sign first (q and −q are one rotation).
        Samples with a missing value are left out and counted in ``dropped``.
        """
        if self._origin is None:
            self._begin(signals)
        fed = {name: self._one_sign(name, values) for name, values in signals.items()}
        data = np.concatenate([fed[name] for name, _ in self._names]) if self._names else np.zeros((0, time.size))
        if not np.isfinite(data.sum()) or not np.isfinite(time.sum()):
            finite = np.isfinite(data).all(axis=0) & np.isfinite(time)
            self.dropped += int((~finite).sum())
            data, time = data[:, finite], time[finite]
        if time.size == 0:
            return
        if self._origin is None:
            self._origin = float(time[0])
            self._zero = data[:, 0].copy()
        self._append(time - self._origin, data - self._zero[:, None])

    def _begin(self, signals: Mapping[str, Floats]) -> None:
        self._names = [(name, int(values.shape[0])) for name, values in signals.items()]

    def _one_sign(self, name: str, values: Floats) -> Floats:
        if not name.startswith("quaternion") or values.shape[1] == 0:
            return np.asarray(values, dtype=np.float64)
        guide = self._quaternion.setdefault(name, values[:, 0].copy())
        return np.asarray(np.where(guide @ values < 0.0, -values, values), dtype=np.float64)

    def _append(self, time: Floats, data: Floats) -> None:
        index = np.floor(time / self._duration).astype(np.int64)
        begins = np.flatnonzero(np.diff(index, prepend=index[0] - 1))
        ends = np.append(begins[1:], time.size) - 1
        n_channels = data.shape[0]
        sums = np.empty((4 + 2 * n_channels, begins.size))
        sums[0] = ends - begins + 1
        sums[2], sums[3] = time[begins], time[ends]
        if begins.size == time.size:
            sums[1], sums[4 : 4 + n_channels], sums[4 + n_channels :] = time, data, data * data
        else:
            sums[1] = np.add.reduceat(time, begins)
            for channel in range(n_channels):
                sums[4 + channel] = np.add.reduceat(data[channel], begins)
                sums[4 + n_channels + channel] = np.add.reduceat(data[channel] ** 2, begins)
        self._index.append(index[begins])
        self._sums.append(sums)
        self._stored += begins.size
        if self._stored > 2 * self._most:
            self._join()

    def _join(self) -> None:
        """Join what belongs to one block, and neighbours while there are too many."""
        index, sums = np.concatenate(self._index), np.concatenate(self._sums, axis=1)
        while True:
            begins = np.flatnonzero(np.diff(index, prepend=index[0] - 1))
            if begins.size < index.size:
                last = sums[3, np.append(begins[1:], index.size) - 1]
                first = sums[2, begins]
                sums = np.add.reduceat(sums, begins, axis=1)
                sums[2], sums[3], index = first, last, index[begins]
            if index.size <= self._most:
                break
            self._duration *= 2.0
            index = index >> 1
        self._index, self._sums, self._stored = [index], [sums], int(index.size)

    def blocks(self) -> Blocks:
        """Return the averages so far. Raises ValueError where nothing was fed."""
        if self._origin is None:
            raise ValueError("no samples were fed")
        self._join()
        sums = self._sums[0]
        count = sums[0]
        n_channels = self._zero.size
        mean = sums[4 : 4 + n_channels] / count
        variance = np.maximum(sums[4 + n_channels :] / count - mean**2, 0.0) * np.where(
            count > 1, count / np.maximum(count - 1, 1), 0.0
        )
        mean += self._zero[:, None]
        means: dict[str, Floats] = {}
        variances: dict[str, Floats] = {}
        place = 0
        for name, width in self._names:
            means[name] = np.ascontiguousarray(mean[place : place + width].T)
            variances[name] = np.ascontiguousarray(variance[place : place + width].T)
            place += width
        return Blocks(
            time=self._origin + sums[1] / count,
            start=self._origin + sums[2],
            end=self._origin + sums[3],
            count=count.astype(np.int64),
            mean=means,
            variance=variances,
            dropped=self.dropped,
        )


def blocks_of(time: Floats, signals: Mapping[str, Floats], shortest: float = SHORTEST_BLOCK_S) -> Blocks:
    """Return the block averages of a log in memory: time (n,), signals name to (n, c).

    Examples
    --------
    >>> import numpy as np
    >>> len(blocks_of(np.arange(5.0), {"joints": np.zeros((5, 6))}))
    5
    """
    averager = BlockAverager(shortest)
    averager.add(time, {name: np.ascontiguousarray(values.T) for name, values in signals.items()})
    return averager.blocks()


def noise_of(values: Floats) -> Floats:
    """Return the standard deviation (c,) of fast noise in values (m, c); steps, ramps and spikes do not affect it.

    From second differences, which straight ramps leave at zero; their median is not moved by rare steps.
    """
    if values.shape[0] < 3:
        return np.zeros(values.shape[1])
    bend = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2])
    noise = np.median(bend, axis=0) / (MEDIAN_OF_NORMAL * np.sqrt(SECOND_DIFFERENCE))
    return np.asarray(noise, dtype=np.float64)


def noise_along_a_course(values: Floats) -> float:
    """Return the standard deviation of fast noise in values (n,) of one course; its curvature does not affect it.

    From fourth differences, which leave more of the course at zero than `noise_of`, and need more readings. Of fewer
    than five it is 0.
    """
    if values.size < 5:
        return 0.0
    return float(np.median(np.abs(np.diff(values, 4))) / (MEDIAN_OF_NORMAL * np.sqrt(FOURTH_DIFFERENCE)))

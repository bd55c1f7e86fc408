"""Faults of rods, tried on their readings: what each leaves of the contradiction, and how many numbers it takes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers
from stiffcal.links.rods import RodDesign

FaultKind: TypeAlias = Literal["loose", "swapped-sign", "exchanged", "drifting", "warming", "unexplained"]


@dataclass(frozen=True)
class RodReadings:
    """The rods' readings and what holds them together."""

    lengths: Floats
    """(n, m) m, less their run's mean."""
    sigma: float
    """m, one number, or 0 where not known."""
    time: Floats | None
    """(n,) s, or None."""
    run: Integers | None
    """(n,) or None."""
    columns: Floats | None
    """(p, n, m) what the rods read per unknown of the load model; None: the field alone."""
    design: RodDesign
    """Of the field."""
    used: NDArray[np.bool_]
    """(m,) False for rods that were already found loose."""
    signed: bool = True
    """True where flexibilities cannot be negative."""
    growth: Floats | None = None
    """(n, m) m, what the rods would grow by the logged temperature if the link expanded by 1/K more than they, less its
    run's mean; None where no temperature changes.
    """


@dataclass(frozen=True)
class RodFaultTrial:
    """One fault, tried: its readings mended, the squared contradiction left, and how many numbers that took."""

    kind: FaultKind | None
    rods: tuple[int, ...]
    mended: RodReadings
    squares: float
    numbers: int
    size: float

    def score(self, count: int, sigma: float) -> float:
        """Schwarz' criterion; noise is the least that can be left."""
        mean = max(self.squares / count, sigma**2, 1e-22)
        return count * float(np.log(mean)) + self.numbers * float(np.log(count))


def trials_of(readings: RodReadings) -> Iterator[RodFaultTrial]:
    """Try no fault first, then each fault at each place."""
    count = np.flatnonzero(readings.used)
    known = 0 if readings.columns is None else len(readings.columns)
    yield RodFaultTrial(None, (), readings, *_squares(readings), 0.0)
    flips = [(int(i),) for i in count] + ([tuple(int(i) for i in count)] if known else [])
    for rods in flips:
        sign = np.ones(readings.lengths.shape[1])
        sign[list(rods)] = -1.0
        yield _mended("swapped-sign", rods, readings, readings.lengths * sign)
    if known and readings.growth is not None:
        yield _warming(readings)
    for a, b in combinations(count, 2):
        order = np.arange(readings.lengths.shape[1])
        order[[a, b]] = order[[b, a]]
        yield _mended("exchanged", (int(a), int(b)), readings, readings.lengths[:, order])
    for i in count:
        if readings.time is not None:
            yield _drifting(int(i), readings)
        used = readings.used.copy()
        used[i] = False
        without_rod = replace(readings, used=used)
        if readings.columns is not None or int(used.sum()) > len(readings.design.carried):
            yield from _loose(int(i), readings, without_rod)


def _loose(rod: int, readings: RodReadings, left: RodReadings) -> Iterator[RodFaultTrial]:
    """Leave a rod out; or, where the load is known, let it answer the load in its own way, for fewer free numbers."""
    squares, numbers = _squares(left)
    off = left_over(left, readings.lengths)[:, rod]
    size = float(np.sqrt(np.mean(off**2)))
    yield RodFaultTrial("loose", (rod,), left, squares, numbers + len(off), size)
    if readings.columns is not None:
        only_rod = np.zeros(len(readings.used), dtype=np.bool_)
        only_rod[rod] = True
        alone, more = _squares(replace(readings, used=only_rod, signed=False))
        yield RodFaultTrial("loose", (rod,), left, squares + alone, numbers + more, size)


def _mended(kind: FaultKind, rods: tuple[int, ...], readings: RodReadings, lengths: Floats) -> RodFaultTrial:
    mended = replace(readings, lengths=lengths)
    size = float(np.sqrt(np.mean((lengths - readings.lengths)[:, list(rods)] ** 2)))
    return RodFaultTrial(kind, rods, mended, *_squares(mended), size)


def _drifting(rod: int, readings: RodReadings) -> RodFaultTrial:
    """Take out of one rod what grows with the time since each run began, bent by a square."""
    time = _since_start(readings)
    span = max(float(time.max()), 1e-12)
    columns = np.zeros((2, *readings.lengths.shape))
    columns[0, :, rod], columns[1, :, rod] = time / span, (time / span) ** 2
    centred = np.stack([centred_by_run(readings.run, column) for column in columns])
    drifts = [left_over(readings, column)[:, readings.used].ravel() for column in centred]
    target = left_over(readings, readings.lengths)[:, readings.used].ravel()
    rate = np.linalg.lstsq(np.stack(drifts, axis=1), target, rcond=None)[0]
    mended = replace(readings, lengths=readings.lengths - np.einsum("p,pnm->nm", rate, centred))
    squares, numbers = _squares(mended)
    size = float(np.sqrt(np.mean((rate @ columns[:, :, rod]) ** 2)))
    return RodFaultTrial("drifting", (rod,), mended, squares, numbers + 2, size)


def _warming(readings: RodReadings) -> RodFaultTrial:
    """Take out of all rods what they grow by with the temperature, at one expansion for all."""
    assert readings.growth is not None
    expected = left_over(readings, readings.growth)[:, readings.used].ravel()
    target = left_over(readings, readings.lengths)[:, readings.used].ravel()
    expansion = float(expected @ target / max(float(expected @ expected), np.finfo(float).tiny))
    mended = replace(readings, lengths=readings.lengths - expansion * readings.growth)
    squares, numbers = _squares(mended)
    rods = tuple(int(i) for i in np.flatnonzero(readings.used))
    return RodFaultTrial("warming", rods, mended, squares, numbers + 1, expansion)


def _since_start(readings: RodReadings) -> Floats:
    """Return (n,) seconds since each run's first state: gauges are zeroed with each run."""
    time = np.zeros(len(readings.lengths)) if readings.time is None else readings.time
    if readings.run is None:
        return time
    begun = time.copy()
    for run in np.unique(readings.run):
        begun[readings.run == run] = time[readings.run == run].min()
    return np.asarray(time - begun)


def count_of(readings: RodReadings) -> int:
    """Return how many numbers hold the rods to each other."""
    n, rods = len(readings.lengths), readings.lengths.shape[1]
    return int(n * (rods if readings.columns is not None else max(rods - len(readings.design.carried), 1)))


def _squares(readings: RodReadings) -> tuple[float, int]:
    """Return the squared contradiction of the rods in use, and how many numbers the explanation took."""
    contradiction = left_over(readings, readings.lengths)[:, readings.used]
    offsets = 0 if readings.run is None else len(np.unique(readings.run)) * int(readings.used.sum())
    numbers = 0 if readings.columns is None else len(readings.columns)
    return float(np.sum(contradiction**2)), numbers + offsets


def centred_by_run(run: Integers | None, lengths: Floats) -> Floats:
    """Return (n, m) readings less their run's mean."""
    if run is None:
        return lengths
    result = lengths.copy()
    for number in np.unique(run):
        members = run == number
        result[members] -= result[members].mean(axis=0)
    return result


def left_over(readings: RodReadings, read: Floats) -> Floats:
    """Return (n, m) what the load model, or the field alone, leaves of readings; all rods, fitted to those in use."""
    used = readings.used
    if readings.columns is None:
        matrix = readings.design.matrix
        return np.asarray(read - read[:, used] @ np.linalg.pinv(matrix[used]).T @ matrix.T)
    columns = readings.columns
    rows = columns[:, :, used].reshape(len(columns), -1).T
    size = np.linalg.norm(rows, axis=0)
    size[size == 0.0] = 1.0
    flexible = np.linalg.lstsq(rows / size, read[:, used].ravel(), rcond=1e-9)[0] / size
    # A link does not bend against its load: that is a sign, not a flexibility.
    if readings.signed:
        flexible[[0, 1, 3, 4]] = np.maximum(flexible[[0, 1, 3, 4]], 0.0)
    return np.asarray(read - np.einsum("p,pnm->nm", flexible, columns))

"""A log cut wherever its level changes by more than its noise explains, and neighbours of one level joined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.reduction.holds.whitened import SAME_LEVEL
from stiffcal.uncertainty import chi_square_bound

MEANS_OF = (8, 32)  # readings: noise slower than single readings shows in means of so many
OUTER = 4  # one of so many parts of a hold at each end may hold the end of a ramp: noise and level are the middle's
LEAST_SPREADS = 8  # of means, from which the noise in them is known to a quarter: 1 / √(2 · 8)
SAME_LOAD = 0.01  # of the log's range: holds side by side that differ by less are one (sensor drift, relaxation)
ADJACENT = 0.1  # of the shorter of two holds: what cuts one load for no longer is a passing disturbance
CUT_EXPONENT = 16.0  # a cut by chance: at most e⁻¹⁶, 1e-7, a place
SURE = 3.0  # noises of the mean of a few blocks, and tolerances at most, in which two levels may be one
CHUNK = 256  # blocks that are segmented at a time: keeps the work proportional to the length


@dataclass(frozen=True)
class Piece:
    """Blocks first … last-1 at one level: mean (c,) of the whitened values."""

    first: int
    last: int
    mean: Floats


def side_by_side(holds: Sequence[Piece], tolerance: float) -> list[Piece]:
    """Join holds of one load that a slow drift or a passing disturbance has cut."""
    merged = list(holds[:1])
    for piece in holds[1:]:
        last = merged[-1]
        is_adjacent = piece.first - last.last <= ADJACENT * min(piece.last - piece.first, last.last - last.first)
        if is_adjacent and np.linalg.norm(piece.mean - last.mean) < tolerance * SAME_LOAD / SAME_LEVEL:
            n, n_added = last.last - last.first, piece.last - piece.first
            merged[-1] = Piece(last.first, piece.last, (n * last.mean + n_added * piece.mean) / (n + n_added))
        else:
            merged.append(piece)
    return merged


def segment(white: Floats, tolerance: float) -> list[Piece]:
    """Cut at every change of level: chunk by chunk, each where the step is most significant, until nothing changes."""
    n_channels = white.shape[1]
    bound = chi_square_bound(n_channels, CUT_EXPONENT)
    pieces: list[Piece] = []
    for begin in range(0, len(white), CHUNK):
        stack = [(begin, min(begin + CHUNK, len(white)))]
        while stack:
            first, last = stack.pop()
            cut = _best_cut(white[first:last], bound, 0.5 * tolerance)
            if cut:
                stack += [(first + cut, last), (first, first + cut)]
            else:
                pieces.append(Piece(first, last, mean_of(white[first:last])))
    return pieces


def _best_cut(white: Floats, bound: float, smallest: float) -> int:
    """Return the index at which the level of (n, c) values of unit noise changes most, or 0 where it does not."""
    n = len(white)
    if n < 2:
        return 0
    left = np.cumsum(white, axis=0)
    k = np.arange(1, n)
    step = left[:-1] / k[:, None] - (left[-1] - left[:-1]) / (n - k)[:, None]
    squared = np.einsum("kc,kc->k", step, step)
    statistic = squared * (k * (n - k) / n)
    best = int(np.argmax(statistic))
    return best + 1 if statistic[best] > bound and squared[best] > smallest**2 else 0


def mean_of(values: Floats) -> Floats:
    """Return the mean (c,) of (n, c)."""
    return np.asarray(np.add.reduce(values, axis=0) / len(values))  # of so few `numpy.mean` takes five times as long


def merge_alike(pieces: Sequence[Piece], tolerance: float) -> list[Piece]:
    """Join neighbours of one level."""
    merged = [pieces[0]]
    for piece in pieces[1:]:
        current = merged[-1]
        # the level of a piece of a few blocks is known only to its own noise
        uncertain = SURE * np.sqrt(piece.mean.size / (piece.last - piece.first))
        if np.linalg.norm(piece.mean - current.mean) < max(tolerance, min(uncertain, SURE * tolerance)):
            n, n_added = current.last - current.first, piece.last - piece.first
            mean = (n * current.mean + n_added * piece.mean) / (n + n_added)
            merged[-1] = Piece(current.first, piece.last, mean)
        else:
            merged.append(piece)
    return merged


def slow_noise(white: Floats, holds: Sequence[Piece]) -> Floats:
    """Return (c,) how much more means of several readings scatter inside holds than white noise of the same size."""
    most = np.ones(white.shape[1])
    for size in MEANS_OF:
        spreads = []
        for piece in holds:
            n = piece.last - piece.first
            inside = white[piece.first + n // OUTER : piece.last - n // OUTER]
            n_used = len(inside) // size * size
            if n_used >= 3 * size:
                means = inside[:n_used].reshape(-1, size, white.shape[1]).mean(axis=1)
                spreads.append(0.5 * np.diff(means, axis=0) ** 2 * size)
        if sum(len(spread) for spread in spreads) >= (1 if size == MEANS_OF[0] else LEAST_SPREADS):
            most = np.maximum(most, np.sqrt(np.concatenate(spreads).mean(axis=0)))
    return np.asarray(most)

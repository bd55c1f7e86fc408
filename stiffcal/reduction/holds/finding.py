"""Load states found in a log: the times in which the load was held.

Why this way: no threshold is set by hand. The log is cut wherever its level changes by more than its own noise can
explain (binary segmentation: Scott & Knott 1974, with a chi-square bound), neighbours of one level are joined, pieces
of ramps show by the change inside them, pauses and settling by their length among the other holds. Edges are
then walked outwards from the middle of each hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.reduction.holds.pieces import OUTER, Piece, mean_of, merge_alike, segment, side_by_side, slow_noise
from stiffcal.reduction.holds.unused import UnusedCode, UnusedStretch
from stiffcal.reduction.holds.whitened import tolerance_of, whiten
from stiffcal.uncertainty import chi_square_bound

LEAST_BLOCKS = 4  # of a level; a log needs two of them
EDGE_EXPONENT = 12.0  # an edge by chance: at most e⁻¹², 6e-6, a window
EDGES = 5  # likewise where a hold is distinguished from a slice of a ramp, which is shorter
STEADY = 0.25  # of the tolerance: by what a level may change inside
SLOW = 1.3  # times the noise of single readings, in means of several: it is not white
MOST_LOOKS = 30  # for noise that is not white: each finds less of it, and it ends where none is left
REST = 1.6  # times as long at a level as the ramps need to pass it: perhaps a hold
USUAL_REST = 2.2  # where none is clear, the median of all that may be holds: less is a ramp in uneven slices
CLEAR_REST = 6.0  # likewise: surely a hold, whose durations give what is usual
SLICE = 0.05  # of what most of the time is spent in: a slice of a ramp, not a hold
SHORT_HOLD = 0.35  # of the usual duration: shorter ones are pauses or settling
SHORT_PAUSE = 0.1  # likewise: shorter ones are not worth separating from the ramps
LEAST_USUAL = 3  # holds, whose median is the usual one whatever one of them is
LONG_END = 1.25  # of the median: a log that runs on before the first or after the last load is cut to the median
EDGE_SHARE = 0.03  # of a hold: the window that looks for its edges, and the margin left off at each


@dataclass(frozen=True)
class Holds:
    """h holds of a run, in order, in s on the clock of the log they were found in."""

    start: Floats
    """(h,) where the averaged stretch begins."""
    end: Floats
    """(h,) where it ends."""
    reached: Floats
    """(h,) when the load was reached."""
    left: Floats
    """(h,) when the load was left: ``left - reached`` is how long it was held."""
    dropped: tuple[UnusedStretch, ...] = ()
    """What was thrown away, and why."""

    def __len__(self) -> int:
        return int(self.start.shape[0])


def given_holds(start: Floats, end: Floats) -> Holds:
    """Return holds that a table states; nothing is trimmed.

    Examples
    --------
    >>> import numpy as np
    >>> len(given_holds(np.array([0.0, 3.0]), np.array([2.0, 5.0])))
    2
    """
    return Holds(start, end, start.copy(), end.copy())


def find_holds(time: Floats, values: Floats) -> Holds:
    """Find the times in which ``values`` (m, c) stayed at a level; ``time`` (m,) s.

    The values are a wrench log (force and moment, any units), or positions where no wrench is logged.

    Examples
    --------
    >>> import numpy as np
    >>> time = np.arange(0.0, 12.0, 0.01)
    >>> load = 100.0 * np.floor(time / 4.0) + np.random.default_rng(1).normal(0.0, 1.0, time.size)
    >>> len(find_holds(time, load[:, None]))
    3
    """
    if time.size < 2 * LEAST_BLOCKS:
        return _none(UnusedStretch(0.0, 0.0, UnusedCode.TOO_FEW_READINGS))
    white, tolerance = whiten(values)
    kept, pauses = _levels(time, white, tolerance)
    for _ in range(MOST_LOOKS):
        # Noise that is not white (vibration, mains) moves means more than its single readings show: look again. It also
        # cuts holds, and what is left of them shows the less of it: several times.
        coarse = slow_noise(white, kept)
        if not (coarse > SLOW).any():
            break
        white = white / np.maximum(coarse, 1.0)
        tolerance = tolerance_of(white)
        kept, pauses = _levels(time, white, tolerance)
    else:
        return _none(UnusedStretch(float(time[0]), float(time[-1]), UnusedCode.NOISE_UNSTEADY))
    if not kept:
        return _none(UnusedStretch(float(time[0]), float(time[-1]), UnusedCode.NEVER_HELD))
    return _with_edges(time, white, kept, pauses, tolerance)


def _none(dropped: UnusedStretch) -> Holds:
    nothing = np.zeros(0)
    return Holds(nothing, nothing, nothing, nothing, (dropped,))


def _levels(time: Floats, white: Floats, tolerance: float) -> tuple[list[Piece], list[Piece]]:
    """Return the pieces that are holds, and those held too briefly."""
    pieces = merge_alike(segment(white, tolerance), tolerance)
    stay = _stay(time, white, pieces)
    level = np.array([_is_level(white, piece, tolerance) for piece in pieces], dtype=np.bool_) & (stay > REST)
    holds = [piece for piece, is_level in zip(pieces, level, strict=True) if is_level]
    if not holds or (stay[level].max() < CLEAR_REST and float(np.median(stay[level])) < USUAL_REST):
        return [], []
    duration = np.array([time[piece.last - 1] - time[piece.first] for piece in holds])
    # half of all the time held is held for longer than this: slices of ramps, however many, take little time
    inner = np.sort([d for d, p in zip(duration, holds, strict=True) if p.first > 0 and p.last < len(time)] or duration)
    heavy = inner[np.searchsorted(np.cumsum(inner), 0.5 * inner.sum())]
    clear = duration[(stay[level] > CLEAR_REST) & (duration > SLICE * heavy)]
    usual = float(np.median(clear if clear.size >= LEAST_USUAL else duration))
    long_enough = duration >= SHORT_HOLD * usual
    # Before the first load nobody waits longer than until nothing moves; that is the reference.
    long_enough |= (stay[level] > CLEAR_REST) & np.array([piece.first == 0 for piece in holds], dtype=np.bool_)
    selected = [piece for piece, keep in zip(holds, long_enough, strict=True) if keep]
    is_pause = ~long_enough & (duration >= SHORT_PAUSE * usual)
    pauses = [piece for piece, is_short in zip(holds, is_pause, strict=True) if is_short]
    return side_by_side(selected, tolerance), pauses


def _stay(time: Floats, white: Floats, pieces: Sequence[Piece]) -> Floats:
    """Return how many times longer the load stayed at each level than the ramps, at their speed, need to pass it.

    The ramps' speed is that at which half of the whole way is gone: holds of any length, breaks included, do not
    move it.
    """
    if len(pieces) < 2:
        return np.full(len(pieces), np.inf)
    begin = time[[piece.first for piece in pieces]]
    stop = time[[min(piece.last, len(time) - 1) for piece in pieces]]
    speed, change = _ramps(time, white, pieces)
    order = np.argsort(speed)
    half = np.searchsorted(np.cumsum(change[order]), 0.5 * change.sum())
    usual = speed[order[min(int(half), len(order) - 1)]]
    # the way through a level: half of the steps to it and from it; an end of the log counts once
    steps = np.linalg.norm(np.diff([piece.mean for piece in pieces], axis=0), axis=1)
    through = 0.5 * (np.append(steps[:1], steps) + np.append(steps, steps[-1:]))
    return np.asarray((stop - begin) * usual / np.maximum(through, np.finfo(float).tiny))


def _ramps(time: Floats, white: Floats, pieces: Sequence[Piece]) -> tuple[Floats, Floats]:
    """Return the speed between neighbouring pieces and the way between them.

    A step leaves a piece of one block, or of a few, half-way; they are the ramp, not what it leads to.
    """
    ends = [piece for piece in pieces if piece.last - piece.first >= LEAST_BLOCKS]
    if len(ends) < 2:
        ends = list(pieces)
    change = np.linalg.norm(np.diff([piece.mean for piece in ends], axis=0), axis=1)
    passing = np.empty(len(ends) - 1)
    for k, (before, after) in enumerate(pairwise(ends)):
        gap = time[after.first] - time[before.last - 1] - (time[1] - time[0])
        mean_gap = 0.5 * (time[before.last - 1] - time[before.first] + time[after.last - 1] - time[after.first])
        passing[k] = gap + mean_gap * (1.0 - _abruptness(white, before, after, float(change[k])))
    return change / np.maximum(passing, np.median(np.diff(time))), change


def _abruptness(white: Floats, before: Piece, after: Piece, way: float) -> float:
    """Return the share of the way between two levels that lies at their border: 1 for a step, a quarter in a ramp."""
    quarter = max(min(before.last - before.first, after.last - after.first) // OUTER, 1)
    step = mean_of(white[after.first : after.first + quarter]) - mean_of(white[before.last - quarter : before.last])
    squared = float(step @ step) - 2.0 * white.shape[1] / quarter
    return min(float(np.sqrt(max(squared, 0.0))) / max(way, 1e-300), 1.0)


def _is_level(white: Floats, piece: Piece, tolerance: float) -> bool:
    """Distinguish a hold from a slice of a ramp: by what changes inside its middle, edges of ramps being left out."""
    n = piece.last - piece.first
    if n < LEAST_BLOCKS:
        return False
    edge = n // EDGES
    half = max((n - 2 * edge) // 2, 1)
    inside = white[piece.first + edge : piece.last - edge]
    change = np.linalg.norm(mean_of(inside[-half:]) - mean_of(inside[:half]))
    return bool(change < STEADY * tolerance + 2.0 * np.sqrt(2.0 * white.shape[1] / half))


def _with_edges(time: Floats, white: Floats, kept: Sequence[Piece], pauses: Sequence[Piece], tolerance: float) -> Holds:
    """Walk outwards from the middle of each hold to its edges, and list what is left out."""
    lowest = [0, *(piece.last for piece in kept[:-1])]
    highest = [*(piece.first for piece in kept[1:]), len(time)]
    piece_edges = [_edges(white, *around, tolerance) for around in zip(kept, lowest, highest, strict=True)]
    edges = np.array(piece_edges, dtype=np.int64)
    reached, left = time[edges[:, 0]], time[edges[:, 1]]
    margin = EDGE_SHARE * (left - reached)
    start, end = reached + margin, left - margin
    dropped = [
        UnusedStretch(float(time[piece.first]), float(time[piece.last - 1]), UnusedCode.HELD_BRIEFLY)
        for piece in pauses
    ]
    dropped += [
        UnusedStretch(float(end[k - 1]), float(start[k]), UnusedCode.LOAD_CHANGING) for k in range(1, len(kept))
    ]
    start, end, ends = _short_ends(start, end)
    dropped += ends
    return Holds(start, end, reached, left, tuple(sorted(dropped, key=lambda stretch: stretch.start)))


def _edges(white: Floats, piece: Piece, lowest: int, highest: int, tolerance: float) -> tuple[int, int]:
    """Return the first and last block of the hold around the middle half of ``piece``."""
    n = piece.last - piece.first
    begin, stop = piece.first + n // OUTER, piece.last - n // OUTER
    level = white[begin:stop].mean(axis=0)
    window = max(int(EDGE_SHARE * n), 1)
    n_channels = white.shape[1]
    allowed = chi_square_bound(n_channels, EDGE_EXPONENT) / window + (0.5 * tolerance) ** 2
    after = np.concatenate([np.zeros((1, n_channels)), np.cumsum(white[lowest:highest] - level, axis=0)])
    running = (after[window:] - after[:-window]) / window
    inside = np.einsum("kc,kc->k", running, running) <= allowed
    # running[k] covers blocks lowest+k … lowest+k+window-1; one outlier does not end a hold, two in a row do
    outside = ~inside
    outside[1:] &= ~inside[:-1]
    before = np.flatnonzero(outside[: max(begin - lowest - window + 1, 0)])
    behind = np.flatnonzero(outside[stop - lowest :])
    first = lowest + int(before[-1]) + window if before.size else lowest
    last = stop + int(behind[0]) - 1 if behind.size else highest - 1
    return min(first, begin), max(last, stop - 1)


def _short_ends(start: Floats, end: Floats) -> tuple[Floats, Floats, list[UnusedStretch]]:
    """Cut the open ends of a log to the usual hold, next to the load.

    Before the first load and after the last nothing marks when the hold began or ended; minutes of it would be another
    average (drift, noise) than the other states.
    """
    if start.size < LEAST_USUAL:
        return start, end, []
    usual = float(np.median(end[1:-1] - start[1:-1]))
    start, end = start.copy(), end.copy()
    dropped: list[UnusedStretch] = []
    if end[0] - start[0] > LONG_END * usual:
        dropped.append(UnusedStretch(float(start[0]), float(end[0] - usual), UnusedCode.BEFORE_FIRST_LOAD))
        start[0] = end[0] - usual
    if end[-1] - start[-1] > LONG_END * usual:
        dropped.append(UnusedStretch(float(start[-1] + usual), float(end[-1]), UnusedCode.AFTER_LAST_LOAD))
        end[-1] = start[-1] + usual
    return start, end, dropped

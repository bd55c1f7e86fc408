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
from stiffcal.reduction.holds.unused import UnusedCode, UnusedStretch
from stiffcal.reduction.logs.blocks import SECOND_DIFFERENCE, noise_of
from stiffcal.uncertainty import chi_square_bound

SAME_LEVEL = 0.003  # of the log's range: changes smaller than this do not cut a hold
SAME_LOAD = 0.01  # of the log's range: holds side by side that differ by less are one (sensor drift, relaxation)
LEAST_BLOCKS = 4  # of a level; a log needs two of them
ADJACENT = 0.1  # of the shorter of two holds: what cuts one load for no longer is a passing disturbance
MEANS_OF = (8, 32)  # readings: noise slower than single readings shows in means of so many
TAILS = 0.005  # of a log's readings at each end of its range: they may be spikes
LEAST_NOISE = 1e-4  # of the largest range: stands in for the noise of a log that has none
SPIKE = 6.0  # noises from the median of its neighbours: by chance one normal reading in 5·10⁸
NEIGHBOURS = 2  # on each side, with which a spike is compared: more than half of five are sound next to two
CORNER = 5.0  # noises of a second difference: the start of a ramp, not noise
MANY_CORNERS = 0.05  # of the readings: ramps are a few readings long, and their corners are not smooth noise
SMOOTH_MEANS = (2, 4)  # readings, in whose means the noise of a filtered sensor shows
SMOOTH = (1.35, 1.5)  # times as much as single readings: white noise shows 1, means of two readings 1.9 and 2.2
MOST_SMOOTH = 8.0  # times the noise of single readings: a filter over 64 of them
LEAST_MEANS = 12  # of which a quartile is known to a half
QUARTER, FIRST_QUARTILE = 0.25, 0.3186  # of |N(0, 1)|: ramps and steps leave the smallest quarter of differences alone
CUT_EXPONENT = 16.0  # a cut by chance: at most e⁻¹⁶, 1e-7, a place
EDGE_EXPONENT = 12.0  # an edge by chance: at most e⁻¹², 6e-6, a window
OUTER = 4  # one of so many parts of a hold at each end may hold the end of a ramp: noise and level are the middle's
EDGES = 5  # likewise where a hold is distinguished from a slice of a ramp, which is shorter
SURE = 3.0  # noises of the mean of a few blocks, and tolerances at most, in which two levels may be one
STEADY = 0.25  # of the tolerance: by what a level may change inside
SLOW = 1.3  # times the noise of single readings, in means of several: it is not white
MOST_LOOKS = 30  # for noise that is not white: each finds less of it, and it ends where none is left
LEAST_SPREADS = 8  # of means, from which the noise in them is known to a quarter: 1 / √(2 · 8)
CHUNK = 256  # blocks that are segmented at a time: keeps the work proportional to the length
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


@dataclass(frozen=True)
class _Piece:
    """Blocks first … last-1 at one level: mean (c,) of the whitened values."""

    first: int
    last: int
    mean: Floats


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
    white, tolerance = _whiten(values)
    kept, pauses = _levels(time, white, tolerance)
    for _ in range(MOST_LOOKS):
        # Noise that is not white (vibration, mains) moves means more than its single readings show: look again. It also
        # cuts holds, and what is left of them shows the less of it: several times.
        coarse = _slow_noise(white, kept)
        if not (coarse > SLOW).any():
            break
        white = white / np.maximum(coarse, 1.0)
        tolerance = _tolerance(white)
        kept, pauses = _levels(time, white, tolerance)
    else:
        return _none(UnusedStretch(float(time[0]), float(time[-1]), UnusedCode.NOISE_UNSTEADY))
    if not kept:
        return _none(UnusedStretch(float(time[0]), float(time[-1]), UnusedCode.NEVER_HELD))
    return _with_edges(time, white, kept, pauses, tolerance)


def _none(dropped: UnusedStretch) -> Holds:
    nothing = np.zeros(0)
    return Holds(nothing, nothing, nothing, nothing, (dropped,))


def _levels(time: Floats, white: Floats, tolerance: float) -> tuple[list[_Piece], list[_Piece]]:
    """Return the pieces that are holds, and those held too briefly."""
    pieces = _merge_alike(_segment(white, tolerance), tolerance)
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
    return _side_by_side(selected, tolerance), pauses


def _side_by_side(holds: Sequence[_Piece], tolerance: float) -> list[_Piece]:
    """Join holds of one load that a slow drift or a passing disturbance has cut."""
    merged = list(holds[:1])
    for piece in holds[1:]:
        last = merged[-1]
        is_adjacent = piece.first - last.last <= ADJACENT * min(piece.last - piece.first, last.last - last.first)
        if is_adjacent and np.linalg.norm(piece.mean - last.mean) < tolerance * SAME_LOAD / SAME_LEVEL:
            n, n_added = last.last - last.first, piece.last - piece.first
            merged[-1] = _Piece(last.first, piece.last, (n * last.mean + n_added * piece.mean) / (n + n_added))
        else:
            merged.append(piece)
    return merged


def _slow_noise(white: Floats, holds: Sequence[_Piece]) -> Floats:
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


def _whiten(values: Floats) -> tuple[Floats, float]:
    """Return values over their noise with single spikes taken out, and the difference below which levels are one."""
    low, high = np.quantile(values, [TAILS, 1.0 - TAILS], axis=0)
    spread = high - low
    # A log without noise (a simulation, coarse digits) still has levels: its resolution stands in.
    floor = np.maximum(LEAST_NOISE * spread.max(), np.finfo(float).tiny)
    noise = np.maximum(_noise(values), floor)
    white = (values - np.median(values, axis=0)) / noise
    padded = np.pad(white, ((NEIGHBOURS, NEIGHBOURS), (0, 0)), mode="edge")
    around = np.median(np.stack([padded[k : k + len(white)] for k in range(2 * NEIGHBOURS + 1)]), axis=0)
    white = np.where(np.abs(white - around) > SPIKE, around, white)
    return white, _tolerance(white)


def _noise(values: Floats) -> Floats:
    """Return the noise (c,) that means of several readings show, as the size of white noise that would show it.

    Filtered sensors have smooth noise, which differences of single readings hardly show. A slow log, whose ramps are a
    few readings long, looks smooth too; its corners stand out from the noise, and it is left alone.
    """
    fine = noise_of(values)
    bend = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2])
    if np.mean((bend > CORNER * np.sqrt(SECOND_DIFFERENCE) * fine).any(axis=1)) > MANY_CORNERS:
        return fine
    pairs, fours = (_noise_of_means(values, size) for size in SMOOTH_MEANS)
    noisy = fine > 0.0
    smooth = noisy.any() and all(
        np.median(means[noisy] / fine[noisy]) > least for means, least in zip((pairs, fours), SMOOTH, strict=True)
    )
    return np.asarray(np.clip(fours, fine, MOST_SMOOTH * fine)) if smooth else fine


def _noise_of_means(values: Floats, size: int) -> Floats:
    """Return the noise (c,) by means of `size` readings: from the smallest quarter of their second differences.

    Ramps and steps leave that quarter alone. Of too few readings it is 0.
    """
    n_used = len(values) // size * size
    means = values[:n_used].reshape(-1, size, values.shape[1]).mean(axis=1)
    if len(means) < LEAST_MEANS:
        return np.zeros(values.shape[1])
    bend = np.abs(means[2:] - 2.0 * means[1:-1] + means[:-2])
    return np.asarray(
        np.quantile(bend, QUARTER, axis=0) / (FIRST_QUARTILE * np.sqrt(SECOND_DIFFERENCE)) * np.sqrt(size)
    )


def _tolerance(white: Floats) -> float:
    """Return the change of level, in units of noise, that is too small to matter or to be detected."""
    low, high = np.quantile(white, [TAILS, 1.0 - TAILS], axis=0)
    return max(SAME_LEVEL * float(np.linalg.norm(high - low)), 0.5)


def _segment(white: Floats, tolerance: float) -> list[_Piece]:
    """Cut at every change of level: chunk by chunk, each where the step is most significant, until nothing changes."""
    n_channels = white.shape[1]
    bound = chi_square_bound(n_channels, CUT_EXPONENT)
    pieces: list[_Piece] = []
    for begin in range(0, len(white), CHUNK):
        stack = [(begin, min(begin + CHUNK, len(white)))]
        while stack:
            first, last = stack.pop()
            cut = _best_cut(white[first:last], bound, 0.5 * tolerance)
            if cut:
                stack += [(first + cut, last), (first, first + cut)]
            else:
                pieces.append(_Piece(first, last, _mean(white[first:last])))
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


def _mean(values: Floats) -> Floats:
    return np.asarray(np.add.reduce(values, axis=0) / len(values))  # of so few `numpy.mean` takes five times as long


def _merge_alike(pieces: Sequence[_Piece], tolerance: float) -> list[_Piece]:
    """Join neighbours of one level."""
    merged = [pieces[0]]
    for piece in pieces[1:]:
        current = merged[-1]
        # the level of a piece of a few blocks is known only to its own noise
        uncertain = SURE * np.sqrt(piece.mean.size / (piece.last - piece.first))
        if np.linalg.norm(piece.mean - current.mean) < max(tolerance, min(uncertain, SURE * tolerance)):
            n, n_added = current.last - current.first, piece.last - piece.first
            mean = (n * current.mean + n_added * piece.mean) / (n + n_added)
            merged[-1] = _Piece(current.first, piece.last, mean)
        else:
            merged.append(piece)
    return merged


def _stay(time: Floats, white: Floats, pieces: Sequence[_Piece]) -> Floats:
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


def _ramps(time: Floats, white: Floats, pieces: Sequence[_Piece]) -> tuple[Floats, Floats]:
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


def _abruptness(white: Floats, before: _Piece, after: _Piece, way: float) -> float:
    """Return the share of the way between two levels that lies at their border: 1 for a step, a quarter in a ramp."""
    quarter = max(min(before.last - before.first, after.last - after.first) // OUTER, 1)
    step = _mean(white[after.first : after.first + quarter]) - _mean(white[before.last - quarter : before.last])
    squared = float(step @ step) - 2.0 * white.shape[1] / quarter
    return min(float(np.sqrt(max(squared, 0.0))) / max(way, 1e-300), 1.0)


def _is_level(white: Floats, piece: _Piece, tolerance: float) -> bool:
    """Distinguish a hold from a slice of a ramp: by what changes inside its middle, edges of ramps being left out."""
    n = piece.last - piece.first
    if n < LEAST_BLOCKS:
        return False
    edge = n // EDGES
    half = max((n - 2 * edge) // 2, 1)
    inside = white[piece.first + edge : piece.last - edge]
    change = np.linalg.norm(_mean(inside[-half:]) - _mean(inside[:half]))
    return bool(change < STEADY * tolerance + 2.0 * np.sqrt(2.0 * white.shape[1] / half))


def _with_edges(
    time: Floats, white: Floats, kept: Sequence[_Piece], pauses: Sequence[_Piece], tolerance: float
) -> Holds:
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


def _edges(white: Floats, piece: _Piece, lowest: int, highest: int, tolerance: float) -> tuple[int, int]:
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

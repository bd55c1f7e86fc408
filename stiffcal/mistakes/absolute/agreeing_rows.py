"""The largest set of rows of a table of absolute places that agree, where many or most rows are wrong.

Random sample consensus (Fischler and Bolles 1981): few rows at a time give the frames of tracker and targets, and those
count with which most rows meet. Mistakes come in blocks (a page, a day, a second file) or at every second row, so that
rows one after the other are tried first. The frames of few rows follow from linear equations: with R m + t = p + B o,
where m is measured and p, B the carrying body's placement, all of R, t and the offsets o enter linearly, and the
nearest rotation takes the place of R.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Booleans, Integers
from stiffcal.mistakes.absolute.met_places import LEAST_ROWS, MeasuredPlaces, Met, far_from, meet
from stiffcal.mistakes.some_rows import some_of
from stiffcal.reduction.registration.registering import WORST_M

# Where half of the rows are wrong, one of 128 samples of seven rows (of one target; of three targets one of 32) has
# none of these: so many samples hold a right one with 79 % (99.8 %), next to those of rows one after the other.
N_DRAWN = 200
# Rows one after the other, every second and every third: a mistake of a page, of one of two or three files.
STRIDES = (1, 2, 3)
# Of the samples that leave the least so many are followed to their end; the best of them all may have one wrong row.
BEST = 5
# Two rows more than give as many equations as there are unknown numbers.
SPARE = 2


def agreeing(places: MeasuredPlaces) -> tuple[Met, float, Booleans] | None:
    """Return frames with which the most rows meet, these rows' median distance in m, and (n,) which rows are far.

    None where no set of rows is large enough.

    Parameters
    ----------
    places : the rows; rows of which not all targets were measured are not drawn.
    """
    whole = np.flatnonzero(np.isfinite(places.measured).all(axis=(1, 2)))
    whole = whole[some_of(len(whole))] if len(whole) else whole
    n_targets = places.measured.shape[1]
    size = -(-(12 + 3 * n_targets) // (3 * n_targets)) + SPARE
    if len(whole) < max(LEAST_ROWS, size):
        return None
    some = places.at(whole)
    starts = _frames_of(some, _samples(len(whole), size))
    near = np.array([np.minimum(start.distance(some).max(axis=1), WORST_M).sum() for start in starts])
    found: tuple[Met, float, Booleans] | None = None
    for k in np.argsort(near, kind="stable")[:BEST]:
        met = meet(places, starts[int(k)])
        distance = met.worst(places)
        within = distance[distance <= WORST_M]
        if len(within) < LEAST_ROWS or not met.settled:
            continue
        usual = float(np.median(within))
        far = np.asarray(distance > far_from(usual))
        if found is None or far.sum() < found[2].sum():
            found = met, usual, far
    return found


def _samples(n: int, size: int) -> Integers:
    """Return (S, size) rows to take together."""
    blocks = [
        first + stride * np.arange(size)
        for stride in STRIDES
        for first in range(0, n - stride * (size - 1), max(1, size // 2))
    ]
    rng = np.random.default_rng(0)
    drawn = [rng.choice(n, size, replace=False) for _ in range(N_DRAWN)]
    return np.array([*blocks, *drawn], dtype=np.int64)


def _frames_of(places: MeasuredPlaces, samples: Integers) -> list[Met]:
    """Return the frames that the rows of each sample give.

    Parameters
    ----------
    places : n rows in which all targets were measured. samples : (S, s) rows.
    """
    n, n_targets, _ = places.measured.shape
    equations = np.zeros((n, n_targets, 3, 12 + 3 * n_targets))
    for axis in range(3):
        equations[:, :, axis, 3 * axis : 3 * axis + 3] = places.measured
        equations[:, :, axis, 9 + axis] = 1.0
    for b in range(n_targets):
        equations[:, b, :, 12 + 3 * b : 15 + 3 * b] = -places.rotation[:, b]
    chosen = equations[samples].reshape(len(samples), -1, equations.shape[-1])
    known = places.position[samples].reshape(len(samples), -1, 1)
    solved = (np.linalg.pinv(chosen, rcond=1e-9) @ known)[:, :, 0]
    left, _, right = np.linalg.svd(solved[:, :9].reshape(-1, 3, 3))
    signs = np.ones((len(samples), 3))
    signs[:, 2] = np.sign(np.linalg.det(left @ right))
    turns = left @ (signs[:, :, None] * right)
    return [
        Met(turn, numbers[9:12], numbers[12:].reshape(n_targets, 3))
        for turn, numbers in zip(turns, solved, strict=True)
    ]

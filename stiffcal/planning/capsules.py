"""Links as capsules: lines between the joints with a radius, and whether they keep apart from each other."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Booleans, Floats

# Links between which less of the arm lies than so many radii are neighbours: their capsules overlap, or nearly so, in
# most poses, and joint limits keep them apart.
NEIGHBOUR = 4.0


def keep_apart(starts: Sequence[Floats], ends: Sequence[Floats], along: Sequence[float], radius: float) -> Booleans:
    """Return (n,) True where no capsule meets another one that is not its neighbour.

    Parameters
    ----------
    starts, ends : (n, 3) of each capsule's line, base axes, m, from the base outwards.
    along : length of the arm up to each capsule's start, m.
    radius : of the capsules, m.
    """
    apart = np.ones(len(starts[0]), dtype=np.bool_)
    for first, second in itertools.combinations(range(len(starts)), 2):
        length = float(np.max(np.linalg.norm(ends[first] - starts[first], axis=1), initial=0.0))
        if along[second] - along[first] - length < NEIGHBOUR * radius:
            continue
        distance = distance_of_lines(starts[first], ends[first], starts[second], ends[second])
        apart &= distance >= 2.0 * radius
    return apart


def distance_of_lines(start: Floats, end: Floats, other_start: Floats, other_end: Floats) -> Floats:
    """Return (n,) the least distance of two straight lines between their ends, m.

    It lies between inner points of both, or at an end of one of them (C. Ericson, Real-Time Collision Detection, 2005,
    5.1.9).

    Parameters
    ----------
    start, end, other_start, other_end : (n, 3), m.
    """
    at_ends = [
        _distance_to_line(point, *line)
        for point, line in (
            (start, (other_start, other_end)),
            (end, (other_start, other_end)),
            (other_start, (start, end)),
            (other_end, (start, end)),
        )
    ]
    least = np.min(at_ends, axis=0)
    along, other, between = end - start, other_end - other_start, start - other_start
    a, b, c = (np.sum(x * y, axis=1) for x, y in ((along, along), (along, other), (other, other)))
    d, e = np.sum(along * between, axis=1), np.sum(other * between, axis=1)
    determinant = a * c - b * b
    crossing = determinant > 1e-12 * a * c
    safe = np.where(crossing, determinant, 1.0)
    s, t = (b * e - c * d) / safe, (a * e - b * d) / safe
    inner = crossing & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    gap = np.linalg.norm(between + s[:, None] * along - t[:, None] * other, axis=1)
    return np.asarray(np.where(inner, np.minimum(gap, least), least))


def _distance_to_line(point: Floats, start: Floats, end: Floats) -> Floats:
    along = end - start
    square = np.sum(along * along, axis=1)
    share = np.sum((point - start) * along, axis=1) / np.where(square > 0.0, square, 1.0)
    nearest = start + np.clip(share, 0.0, 1.0)[:, None] * along
    return np.asarray(np.linalg.norm(point - nearest, axis=1))

"""Readings of three components that differ by less than a step, and how many there are, without a table of pairs."""

from __future__ import annotations

from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

# Readings up to which a table of all pairs takes a megabyte and less time than loading a library for trees.
FEW = 200
# Of no use to any rig: readings that are far from each other in space are so along it, as a rule.
_ASLANT = np.array([0.48, 0.6, 0.64])


class LikeReadings:
    """m readings, and which of them differ by less than a step.

    Parameters
    ----------
    readings : (m, 3). step : in their unit.
    """

    def __init__(self, readings: Floats, step: float) -> None:
        self._share = readings / step

    @cached_property
    def _tree(self) -> cKDTree:
        from scipy.spatial import cKDTree

        return cKDTree(self._share)

    @cached_property
    def _table(self) -> Booleans | None:
        """(m, m) which are alike, of few readings; None of many."""
        if len(self._share) > FEW:
            return None
        return np.asarray(((self._share[:, None] - self._share) ** 2).sum(axis=2) <= 1.0)

    @cached_property
    def counts(self) -> Integers:
        """(m,) how many readings are like each, itself included."""
        if _all_apart(self._share):
            return np.ones(len(self._share), dtype=np.int64)
        if self._table is not None:
            return np.asarray(self._table.sum(axis=1), dtype=np.int64)
        return np.asarray(self._tree.query_ball_point(self._share, 1.0, return_length=True), dtype=np.int64)

    def of(self, reading: int) -> Integers:
        """Return the readings like one, itself among them, ascending."""
        if self.counts[reading] == 1:
            return np.array([reading], dtype=np.int64)
        if self._table is not None:
            return np.flatnonzero(self._table[reading])
        return np.sort(np.asarray(self._tree.query_ball_point(self._share[reading], 1.0), dtype=np.int64))


def _all_apart(share: Floats) -> bool:
    """Return whether readings (m, 3) in steps are further apart than one already along one direction."""
    return bool((np.diff(np.sort(share @ _ASLANT)) >= 1.0).all())


def most_alike_from(readings: Floats, step: float, starts: Integers) -> Integers:
    """Return (s,) an upper bound of how many readings from each start on are like one of them.

    Parameters
    ----------
    readings : (m, 3). step : in their unit. starts : (s,) ascending.
    """
    if not len(starts) or _all_apart(readings[starts[0] :] / step):
        return np.asarray(np.minimum(len(readings) - starts, 1))
    cells, own = np.unique(np.floor(readings / step).astype(np.int64), axis=0, return_inverse=True)
    number = {cell: k for k, cell in enumerate(map(tuple, cells.tolist()))}
    around = [
        [number[near] for near in ((x + i, y + j, z + k) for i, j, k in _AROUND) if near in number]
        for x, y, z in cells.tolist()
    ]
    counts = [0] * len(cells)
    most, bound, stop = 0, np.zeros(len(starts), dtype=np.int64), len(readings)
    cell_of = own.ravel().tolist()
    for k in range(len(starts) - 1, -1, -1):
        for reading in range(int(starts[k]), stop):
            for near in around[cell_of[reading]]:
                counts[near] += 1
                most = max(most, counts[near])
        stop = min(stop, int(starts[k]))
        bound[k] = most
    return bound


_AROUND = tuple(product((-1, 0, 1), repeat=3))

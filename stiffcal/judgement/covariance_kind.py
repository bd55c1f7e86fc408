"""What a judgement asks of a way in which readings err together: their covariance V at each of several sizes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.judgement.numbers import DIRECTIONS_AT_ONCE


class CovarianceKind(Protocol):
    """A way in which readings err together, of several sizes, next to what lasts in runs."""

    @property
    def sizes(self) -> Floats:
        """(s,) grid of its size."""

    def weights(self, size: float) -> Floats:
        """Return (w,) what V⁻¹ has at a size."""

    def log_determinant(self, size: float) -> float:
        """Return log |V|, that of what lasts left out."""

    def along(self, rows: Floats) -> Floats:
        """Return (k, d) the parts of whitened rows (k, r) that inner products are made of."""

    def products(self, rows: Floats, along: Floats, others: Floats, along_others: Floats, plain: Floats) -> Floats:
        """Return (s, k, l) by how much inner products of rows are less under V⁻¹ at each size.

        Parameters
        ----------
        rows, others : whitened (k, r), (l, r). along, along_others : their parts. plain : (k, l) inner products next to
            what lasts in runs.
        """

    def taken_out(self, rows: Floats, weights: Floats, found: Floats | None = None) -> Floats:
        """Return V⁻¹ times whitened rows (k, r), of weights (w,).

        Parameters
        ----------
        found : (k, r) the rows next to what lasts in runs, changed in place; None where nothing does.
        """

    def leverage(self, weights: Floats) -> Floats:
        """Return (r,) the share of each row that V⁻¹ of weights (w,) takes, beyond what lasts."""

    def variance_of_noise(self, weights: Floats) -> Floats:
        """Return (r,) the variance of each row's noise next to all else that is read."""


def weighed_products(weights: Floats, mine: Floats, theirs: Floats) -> Floats:
    """Return (s, k, l) the inner products of (k, d) and (l, d), each direction weighed by (s, d)."""
    if mine is theirs:
        return _symmetric(weights, mine)
    if len(mine) > len(theirs):
        return np.swapaxes(weighed_products(weights, theirs, mine), 1, 2)
    found = np.zeros((len(weights) * len(mine), len(theirs)))
    for at in _parts(weights.shape[1]):
        # of all sizes in one product of matrices: those of a few rows each take twice the time
        scaled = weights[:, None, at] * mine[:, at]
        found += scaled.reshape(len(found), scaled.shape[-1]) @ theirs[:, at].T
    return found.reshape(len(weights), len(mine), len(theirs))


def _symmetric(weights: Floats, rows: Floats) -> Floats:
    """Return (s, k, k) the inner products of rows (k, d) with each other: half is made."""
    found = np.zeros((len(weights), len(rows), len(rows)))
    for at in _parts(weights.shape[1]):
        own, weight = rows[:, at], weights[:, at]
        for j, one in enumerate(own):
            found[:, j:, j] += weight @ (own[j:] * one).T
    for j in range(len(rows)):
        found[:, j, j:] = found[:, j:, j]
    return found


def _parts(count: int) -> Iterator[slice]:
    """Give the directions, as many at a time as stay in the processor's cache."""
    for first in range(0, count, DIRECTIONS_AT_ONCE):
        yield slice(first, first + DIRECTIONS_AT_ONCE)

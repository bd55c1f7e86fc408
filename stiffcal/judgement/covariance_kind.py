"""What a judgement asks of a way in which readings err together: their covariance V at each of several sizes."""

from __future__ import annotations

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
    found = np.zeros((len(weights), len(mine), len(theirs)))
    same = mine is theirs
    for first in range(0, weights.shape[1], DIRECTIONS_AT_ONCE):
        at = slice(first, first + DIRECTIONS_AT_ONCE)
        own, weight = mine[:, at], weights[:, at]
        for j, one in enumerate(theirs[:, at]):
            # of what is symmetric half is made
            k = j if same else 0
            found[:, k:, j] += weight @ (own[k:] * one).T
    for j in range(len(mine) if same else 0):
        found[:, j, j:] = found[:, j:, j]
    return found

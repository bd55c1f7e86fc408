"""Whitened rows with each run's offset taken out: the space in which signatures are compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.identification.least_squares import run_edges
from stiffcal.identification.noise import Whitening
from stiffcal.identification.observation import Observations

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Projection:
    """Turns displacements (k, m, n) into whitened rows (k, m · n), run offsets eliminated.

    Attributes
    ----------
    data, whitening : the observations and their noise.
    edges, counts : where each run begins, and how many states it has.
    precision : (m, m, n) inverse covariances, None where diagonal.
    inverse_total : (R, m, m) inverse of each run's summed precision (m, R reciprocals where diagonal).
    """

    data: Observations
    whitening: Whitening
    edges: Integers
    counts: Integers
    precision: Floats | None
    inverse_total: Floats

    @classmethod
    def of(cls, data: Observations, whitening: Whitening) -> Projection:
        """Prepare the projection."""
        edges = run_edges(data.run)
        counts = np.diff(np.append(edges, data.n_states))
        if whitening.diagonal:
            total = np.add.reduceat(whitening.scale**2, edges, axis=1)
            inverse = np.where(total > 0.0, 1.0 / np.where(total > 0.0, total, 1.0), 0.0)
            return cls(data, whitening, edges, counts, None, inverse)
        precision = whitening.precision()
        sums = np.moveaxis(np.add.reduceat(precision, edges, axis=2), -1, 0)
        return cls(data, whitening, edges, counts, precision, np.linalg.pinv(sums, hermitian=True))

    def centred(self, stack: Floats) -> Floats:
        """Return (k, m, n) with each run's weighted mean taken out (unchanged where runs carry no offset)."""
        stack = np.where(self.data.seen, stack, 0.0)
        if not self.data.free_offset:
            return stack
        if self.precision is None:
            weighted = np.add.reduceat(stack * self.whitening.scale**2, self.edges, axis=2)
            mean = weighted * self.inverse_total
        else:
            weighted = np.zeros_like(stack)
            for a in range(stack.shape[1]):
                for b in range(stack.shape[1]):
                    weighted[:, a] += self.precision[a, b] * stack[:, b]
            sums = np.add.reduceat(weighted, self.edges, axis=2)
            mean = np.einsum("rab,kbr->kar", self.inverse_total, sums)
        return np.where(self.data.seen, stack - np.repeat(mean, self.counts, axis=2), 0.0)

    def rows(self, stack: Floats) -> Floats:
        """Return (k, m · n) whitened rows."""
        return self.whitening.apply(self.centred(stack)).reshape(len(stack), -1)

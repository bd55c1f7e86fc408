"""Noise of readings that belong together: covariance within a run or a bin, and a free constant of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers


@dataclass(frozen=True)
class GroupNoise:
    """Noise of (m, n) readings whose columns fall into groups (`stiffcal.estimation.rows.RowSpace`)."""

    group: Integers
    """(n,) number of each column's group."""
    covariance: tuple[Floats, ...]
    """Of each group with k columns (m · k, m · k), the readings of its first row before those of the next; positive
    definite.
    """
    constant: Booleans
    """(G,) True for groups of which each row has a free constant."""

    @classmethod
    def independent(cls, sigma: Floats, group: Integers, constant: bool = False) -> GroupNoise:
        """Return the noise of readings that are independent, with standard deviations (m, n)."""
        n_groups = int(group.max()) + 1
        covariance = tuple(np.diag(sigma[:, group == g].ravel() ** 2) for g in range(n_groups))
        return cls(group, covariance, np.full(n_groups, constant, dtype=np.bool_))

    @cached_property
    def n_constants(self) -> int:
        """How many constants are free."""
        m = [len(covariance) // np.count_nonzero(self.group == g) for g, covariance in enumerate(self.covariance)]
        return int(np.sum(np.array(m) * self.constant))

    def rows(self, stack: Floats) -> Floats:
        """Return (k, m · n) independent rows of unit variance of (k, m, n), constants taken out, group after group."""
        return np.concatenate(list(self._of_groups(stack)), axis=1)

    def _of_groups(self, stack: Floats) -> Iterator[Floats]:
        k, m, _ = stack.shape
        for g, covariance in enumerate(self.covariance):
            own = stack[:, :, self.group == g].reshape(k, -1)
            lower = np.linalg.cholesky(covariance)
            white = np.linalg.solve(lower, own.T)
            if self.constant[g]:
                unit = np.linalg.solve(lower, np.repeat(np.eye(m), own.shape[1] // m, axis=0))
                basis = np.linalg.qr(unit)[0]
                white = white - basis @ (basis.T @ white)
            yield white.T

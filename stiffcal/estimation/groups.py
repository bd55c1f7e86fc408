"""Noise of readings that belong together: covariance within a run or a bin, and a free constant of each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.estimation.constants import without_constants


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
    read: Booleans
    """(m, n) True where something was read."""

    @classmethod
    def independent(cls, sigma: Floats, group: Integers, constant: bool = False) -> GroupNoise:
        """Return the noise of independent readings with standard deviations (m, n), NaN where nothing was read."""
        n_groups = int(group.max()) + 1
        covariance = tuple(np.diag(sigma[:, group == g].ravel() ** 2) for g in range(n_groups))
        return cls(group, covariance, np.full(n_groups, constant, dtype=np.bool_), np.isfinite(sigma))

    @cached_property
    def n_constants(self) -> int:
        """How many constants are free: of the rows of which a group has readings."""
        rows = [self.read[:, self.group == g].any(axis=1).sum() for g in range(len(self.covariance))]
        return int(np.sum(np.array(rows) * self.constant))

    def rows(self, stack: Floats) -> Floats:
        """Return (k, m · n) independent rows of unit variance of (k, m, n), group after group, constants taken out.

        Zero for what was not read.
        """
        return np.concatenate([self._of_group(stack, g) for g in range(len(self.covariance))], axis=1)

    def _of_group(self, stack: Floats, g: int) -> Floats:
        k, m, _ = stack.shape
        members = np.flatnonzero(self.group == g)
        read = self.read[:, members].ravel()
        white = np.zeros((k, len(read)))
        if not read.any():
            return white
        lower = np.linalg.cholesky(self.covariance[g][np.ix_(read, read)])
        own = np.linalg.solve(lower, stack[:, :, members].reshape(k, -1)[:, read].T)
        if self.constant[g]:
            unit = np.repeat(np.eye(m), len(members), axis=0)[read]
            own = without_constants(own.T, np.linalg.solve(lower, unit)).T
        white[:, read] = own.T
        return white

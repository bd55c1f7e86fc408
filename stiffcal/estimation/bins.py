"""Means of neighbouring readings: fewer rows that show what all of them show, with the noise of their means."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from stiffcal.arrays import Floats, Integers


def noise_of_mean(count: Integers | Floats, correlation: float) -> Floats:
    """Return by what the noise of single readings is multiplied in a mean over ``count`` neighbours (b,).

    Parameters
    ----------
    correlation : of neighbours, of the next but one its square and so on.
    """
    n = np.asarray(count, dtype=np.float64)
    if correlation == 0.0:
        return np.asarray(1.0 / np.sqrt(n))
    rho = correlation
    inflation = (1.0 + rho) / (1.0 - rho) - 2.0 * rho * (1.0 - rho**n) / (n * (1.0 - rho) ** 2)
    return np.asarray(np.sqrt(np.maximum(inflation, 1.0 / n) / n))


@dataclass(frozen=True)
class Bins:
    """Which of n neighbouring readings stand together as one mean."""

    number: Integers
    """(n,) bin of each, from 0 on without gaps."""

    @classmethod
    def of(cls, part: Integers, stretch: Integers, most: int) -> Self:
        """Return bins of like length, so many at most for each part as far as its stretches allow.

        Parameters
        ----------
        part : (n,) what has bins of its own: the joint. Parts with no more readings than ``most`` stay as they are.
        stretch : (n,) number of what is averaged with nothing else, its readings in order: a pass, a branch of a sweep.
        """
        number = np.arange(len(part))
        for one in np.unique(part):
            own = np.flatnonzero(part == one)
            size = -(-len(own) // most)
            for label in np.unique(stretch[own]) if size > 1 else ():
                members = own[stretch[own] == label]
                parts = max(len(members) // size, 1)
                part_of = np.arange(len(members)) * parts // len(members)
                number[members] = members[np.searchsorted(part_of, part_of)]
        return cls(np.unique(number, return_inverse=True)[1].astype(np.int64))

    @cached_property
    def count(self) -> Integers:
        """(b,) readings of each."""
        return np.bincount(self.number)

    @property
    def first(self) -> Integers:
        """(b,) position of the first reading of each."""
        return np.unique(self.number, return_index=True)[1]

    def means(self, values: Floats) -> Floats:
        """Return the means (…, b) of values (…, n)."""
        if len(self.count) == len(self.number):
            return values
        flat = values.reshape(-1, values.shape[-1])
        sums = np.array([np.bincount(self.number, weights=row, minlength=len(self.count)) for row in flat])
        return np.asarray(sums.reshape(*values.shape[:-1], len(self.count)) / self.count)

    def sigma(self, sigma: Floats, correlation: float = 0.0) -> Floats:
        """Return (b,) the noise of the means, from that of single readings (n,) and the correlation of neighbours."""
        return np.asarray(np.sqrt(self.means(sigma**2)) * noise_of_mean(self.count, correlation))

"""Noise that lingers from reading to reading: air, filters of instruments. It is as large as the noise, no discrepancy.

Autoregressive of first order: of each reading's noise a share ρ is left in the next one of its run. Cosines over a run
are its principal axes but for the ends, with the variances (1 − ρ²) / (1 + ρ² − 2 ρ cos ω) of one in the mean (Box and
Jenkins 1970, spectrum of the first-order process). Its inverse takes each reading and its two neighbours,

    N⁻¹ = 1 + β (2 ρ − L),    β = ρ / (1 − ρ²),

where L is the sum of a reading's neighbours, at the ends of a run one of them itself: of L the cosines have 2 cos ω. So
one inner product with neighbours serves every ρ. What lingers so repeats in no cycle, and between one reading and the
next at least (1 − ρ) / (1 + ρ) of its variance is left: a law, or a target that wanders, has neither.

What lasts in every run as well is next to it: V = S⁻¹ N S⁻¹, S of `stiffcal.judgement.discrepancy`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.judgement.discrepancy import Discrepancy
from stiffcal.judgement.numbers import LINGERS
from stiffcal.judgement.space import Space


@dataclass(frozen=True)
class LingeringNoise:
    """Noise of which a share is left in the next reading."""

    before: Integers
    """(r,) position of the reading before each row's in its run; its own where none is."""
    after: Integers
    """(r,) of the one after it."""
    lingers: Floats
    """(r,) 1, or 0 for a reading alone in its run."""
    cosine: Floats
    """(d,) of the frequencies of all runs, but of those that a constant of a run has taken out."""
    lasting: Discrepancy | None = None
    """What is in each run as well."""

    @classmethod
    def of(cls, space: Space, group: Integers, order: Integers, lasting: Discrepancy | None = None) -> LingeringNoise:
        """Prepare.

        Parameters
        ----------
        group : (n,) number of what was read without a break. order : (n,) states in the order in which they were read.
        lasting : a discrepancy of one noise that is there as well; not in runs of one reading.
        """
        m, n = space.free.shape
        share = space.free.ravel()
        before, after, lingers, cosine = np.arange(m * n), np.arange(m * n), np.zeros(m * n), [np.zeros(0)]
        for component, mask in enumerate(space.data.measured_mask):
            for number in np.unique(group):
                place = component * n + order[mask[order] & (group[order] == number)]
                if len(place) < 2:
                    continue
                before[place[1:]], after[place[:-1]], lingers[place] = place[:-1], place[1:], 1.0
                first = min(round(len(place) - float(share[place].sum())), 1)
                cosine.append(np.cos(np.pi * np.arange(first, len(place)) / len(place)))
        return cls(before, after, lingers, np.concatenate(cosine), lasting)

    @property
    def sizes(self) -> Floats:
        """Grid of the share that is left in the next reading."""
        return LINGERS

    def weights(self, size: float) -> Floats:
        """Return 2 ρ β and β, where so much is left in the next reading."""
        return np.array([2.0 * size, 1.0]) * size / (1.0 - size**2)

    def log_determinant(self, size: float) -> float:
        """Return log |N|."""
        return float(np.sum(np.log((1.0 - size**2) / (1.0 + size**2 - 2.0 * size * self.cosine))))

    def along(self, rows: Floats) -> Floats:
        """Return (k, r) S L S times whitened rows (k, r)."""
        return self._next_to_lasting(self._neighbours(self._next_to_lasting(rows)))

    def products(self, rows: Floats, along: Floats, others: Floats, along_others: Floats, plain: Floats) -> Floats:
        """Return (s, k, l) by how much inner products are less at each size; as of `CovarianceKind.products`."""
        alone = self._alone
        lingering = plain - rows[:, alone] @ others[:, alone].T if len(alone) else plain
        own, neighbours = self._weights.T
        return np.asarray(np.multiply.outer(neighbours, rows @ along_others.T) - np.multiply.outer(own, lingering))

    def taken_out(self, rows: Floats, weights: Floats, found: Floats | None = None) -> Floats:
        """Return V⁻¹ times rows (k, r), of weights (2,).

        Parameters
        ----------
        found : (k, r) rows from which what lasts was taken, that are changed in place.
        """
        found = rows.copy() if found is None else found
        found += weights[0] * (found * self.lingers) - weights[1] * self.along(rows)
        return found

    def variance_of_noise(self, weights: Floats) -> Floats:
        """Return (r,) the variance of each row's noise next to all others of its run."""
        return np.asarray(1.0 / (1.0 + weights[0] * self.lingers - weights[1] * self._itself))

    def leverage(self, weights: Floats) -> Floats:
        """Return (r,) the share of each row that lies along what lingers, of weights (2,)."""
        return np.asarray(weights[1] * self._diagonal[1] - weights[0] * self._diagonal[0])

    @cached_property
    def _weights(self) -> Floats:
        """(s, 2) of every size."""
        return np.array([self.weights(size) for size in self.sizes])

    @cached_property
    def _alone(self) -> Integers:
        """Positions of readings that are alone in their run."""
        return np.flatnonzero(self.lingers == 0.0)

    @property
    def _itself(self) -> Floats:
        """(r,) how often a reading is its own neighbour: the diagonal of L."""
        here = np.arange(len(self.before))
        return np.asarray(self.lingers * ((self.before == here) + 1.0 * (self.after == here)))

    @cached_property
    def _diagonal(self) -> tuple[Floats, Floats]:
        """(r,) the diagonals of S S and of S L S where noise lingers, S = 1 − Y Yᵀ run by run."""
        if self.lasting is None:
            return self.lingers, self._itself
        roots = 1.0 - 1.0 / np.sqrt(1.0 + self.lasting.variance)
        of_run = replace(self.lasting, variance=roots).of_run
        number = np.zeros(len(self.before), dtype=np.int64)
        # the directions of different runs have no rows in common: as many rows as a run has directions hold all
        half = np.zeros((max(len(root) for _, _, root in of_run), len(self.before)))
        for k, (place, basis, root) in enumerate(of_run, start=1):
            number[place] = k
            half[: len(root), place] = (basis * np.sqrt(root)).T
        moved = self._neighbours(half)
        found = self._itself - 2.0 * np.sum(half * moved, axis=0)
        for first in half:
            for second, there in zip(half, moved, strict=True):
                found += first * second * np.bincount(number, first * there)[number]
        return self.lingers * (1.0 - self.lasting.leverage(self.lasting.weights(1.0))), found

    def _neighbours(self, rows: Floats) -> Floats:
        """Return L times rows (k, r)."""
        found = np.take(rows, self.before, axis=1)
        found += np.take(rows, self.after, axis=1)
        found *= self.lingers
        return found

    def _next_to_lasting(self, rows: Floats) -> Floats:
        """Return rows (k, r) from which half of what lasts in runs is taken: S times them."""
        if self.lasting is None:
            return rows
        return self.lasting.taken_out(rows, 1.0 - 1.0 / np.sqrt(1.0 + self.lasting.variance))

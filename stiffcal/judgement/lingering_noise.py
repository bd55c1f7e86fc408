"""Noise that lingers from reading to reading: air, filters of instruments. It is as large as the noise, no discrepancy.

Autoregressive of first order: of each reading's noise a share ρ is left in the next one of its run. Cosines over a run
are its principal axes but for the ends, with the variances (1 − ρ²) / (1 + ρ² − 2 ρ cos ω) of one in the mean (Box and
Jenkins 1970, spectrum of the first-order process). What lingers so repeats in no cycle, and between one reading and the
next at least (1 − ρ) / (1 + ρ) of its variance is left: a law, or a target that wanders, has neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.judgement.discrepancy import Discrepancy
from stiffcal.judgement.numbers import LINGERS
from stiffcal.judgement.space import Space


@dataclass(frozen=True)
class RunsOfLength:
    """Runs of single components with as many readings."""

    place: Integers
    """(g, n) positions of their rows, in the order in which they were read."""
    at: Integers
    """(g, n) places of their cosines among all directions."""


@dataclass(frozen=True)
class LingeringNoise:
    """Noise of which a share is left in the next reading."""

    runs: Sequence[RunsOfLength]
    """All of them."""
    n_rows: int
    """Whitened rows of all."""
    cosine: Floats
    """(d,) of each direction's frequency; 0 where a constant of its run has taken it out."""
    free: Floats
    """(d,) 1, or 0 there."""
    lasting: Discrepancy | None = None
    """What is in each run as well: noise lingers next to it, in rows from which half of it is taken (S of
    `stiffcal.judgement.discrepancy`)."""

    @classmethod
    def of(cls, space: Space, group: Integers, order: Integers, lasting: Discrepancy | None = None) -> LingeringNoise:
        """Prepare.

        Parameters
        ----------
        group : (n,) number of what was read without a break. order : (n,) states in the order in which they were read.
        lasting : a discrepancy of one noise that is there as well.
        """
        n = space.free.shape[1]
        places = [
            component * n + states
            for component, mask in enumerate(space.data.measured_mask)
            for number in np.unique(group)
            if len(states := order[mask[order] & (group[order] == number)]) > 1
        ]
        lengths = np.array([len(place) for place in places], dtype=np.int64)
        runs, cosine, free = list[RunsOfLength](), [np.zeros(0)], [np.zeros(0)]
        share, first = space.free.ravel(), 0
        for length in np.unique(lengths).tolist():
            place = np.array([place for place in places if len(place) == length])
            taken = length - share[place].sum(axis=1) > 0.5
            own = np.ones(place.shape)
            own[taken, 0] = 0.0
            runs.append(RunsOfLength(place, first + np.arange(place.size).reshape(place.shape)))
            cosine.append(np.tile(np.cos(np.pi * np.arange(length) / length), len(place)))
            free.append(own.ravel())
            first += place.size
        return cls(runs, space.free.size, np.concatenate(cosine), np.concatenate(free), lasting)

    @property
    def sizes(self) -> Floats:
        """Grid of the share that is left in the next reading."""
        return LINGERS

    def along(self, rows: Floats) -> Floats:
        """Return (k, d) the parts of whitened rows (k, r) along the directions."""
        from scipy.fft import dct

        rows, found = self._next_to_lasting(rows), np.empty((len(rows), len(self.cosine)))
        for one in self.runs:
            found[:, one.at] = dct(rows[:, one.place], norm="ortho")
        return found

    def taken_out(self, rows: Floats, weights: Floats, found: Floats | None = None) -> Floats:
        """Return rows (k, r) less their parts along the directions times weights (d,).

        Parameters
        ----------
        found : (k, r) in place of the rows themselves, from which the parts are taken, in place.
        """
        from scipy.fft import idct

        along, parts = self.along(rows) * weights, np.zeros_like(rows)
        for one in self.runs:
            parts[:, one.place] = idct(along[:, one.at], norm="ortho")
        found = rows.copy() if found is None else found
        found -= self._next_to_lasting(parts)
        return found

    def variance_of_noise(self, weights: Floats) -> Floats:
        """Return (r,) the variance of each row's noise next to all others of its run."""
        return np.asarray(1.0 / (1.0 - self._share(weights)))

    def leverage(self, weights: Floats) -> Floats:
        """Return (r,) the share of each row that lies along the directions, times weights (d,)."""
        found = self._share(weights)
        if self.lasting is None:
            return found
        # diag S M S, M of the noise alone, S = 1 − Y Yᵀ run by run: − 2 diag Y Yᵀ M + diag Y (Yᵀ M Y) Yᵀ
        number, half = self._lasting_by_row
        whitened = replace(self, lasting=None)
        moved = half - whitened.taken_out(half, weights)
        found -= 2.0 * np.sum(half * moved, axis=0)
        for first in half:
            for second, there in zip(half, moved, strict=True):
                found += first * second * np.bincount(number, first * there, minlength=1)[number]
        return found

    @cached_property
    def _lasting_by_row(self) -> tuple[Integers, Floats]:
        """Per row the number of its run (r,), and what is taken from it there: Y (q, r) of `leverage`."""
        assert self.lasting is not None
        roots = 1.0 - 1.0 / np.sqrt(1.0 + self.lasting.variance)
        of_run = replace(self.lasting, variance=roots).of_run
        number = np.zeros(self.n_rows, dtype=np.int64)
        half = np.zeros((max(len(root) for _, _, root in of_run), self.n_rows))
        for k, (place, basis, root) in enumerate(of_run, start=1):
            number[place] = k
            half[: len(root), place] = (basis * np.sqrt(root)).T
        return number, half

    def _share(self, weights: Floats) -> Floats:
        """Return (r,) the share of each row along the cosines, times weights (d,)."""
        found = np.zeros(self.n_rows)
        for one in self.runs:
            length = one.place.shape[1]
            wave = np.cos(np.pi * np.outer(np.arange(length), np.arange(length) + 0.5) / length)
            wave *= np.sqrt(np.where(np.arange(length) == 0, 1.0, 2.0) / length)[:, None]
            found[one.place] = weights[one.at] @ wave**2
        return found

    def _next_to_lasting(self, rows: Floats) -> Floats:
        """Return rows (k, r) from which half of what lasts in runs is taken: S times them."""
        if self.lasting is None:
            return rows
        return self.lasting.taken_out(rows, 1.0 - 1.0 / np.sqrt(1.0 + self.lasting.variance))

    def weights(self, size: float) -> Floats:
        """Return (d,) 1 − 1 / variance, where so much is left in the next reading."""
        return np.asarray(1.0 - np.exp(-self._log_variance(size)))

    def log_determinant(self, size: float) -> float:
        """Return log |V|."""
        return float(np.sum(self._log_variance(size)))

    def _log_variance(self, left: float) -> Floats:
        """Return (d,) the logarithm of the variance along each direction."""
        return np.asarray(self.free * np.log((1.0 - left**2) / (1.0 + left**2 - 2.0 * left * self.cosine)))

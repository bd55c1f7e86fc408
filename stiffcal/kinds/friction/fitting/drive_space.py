"""Noise of friction rows, and what their unknowns other than friction can make of them: weight, inertia, zeros."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows, UnknownKind

# Singular values below this share of a column's length: combinations of inertial numbers that no motion shows.
RANK = 1e-7


@dataclass(frozen=True)
class DriveSpace:
    """Noise of k rows (`stiffcal.estimation.rows.RowSpace`) with directions that other unknowns take."""

    sigma: Floats
    """(k,) N·m, standard uncertainty of each row."""
    constants: Floats
    """(k, c) orthonormal, whitened: the constant of the passes at one speed, which no other row feels."""
    shared: Floats
    """(k, r) orthonormal, whitened: what weight, inertia and zeros can make next to the constants."""

    @classmethod
    def of(cls, rows: FrictionRows, sigma: Floats) -> Self:
        """Return the space of rows with standard uncertainties (k,), N·m."""
        stretch = np.array([unknown.kind is UnknownKind.STRETCH for unknown in rows.unknown], dtype=np.bool_)
        unit = rows.nuisance / sigma[:, None]
        size = np.linalg.norm(unit, axis=0)
        unit = unit / np.where(size > 0.0, size, 1.0)
        constants, others = unit[:, stretch], unit[:, ~stretch]
        others = others - constants @ (constants.T @ others)
        u, s, _ = np.linalg.svd(others, full_matrices=False)
        return cls(sigma, constants, u[:, s > RANK * s.max(initial=1.0)])

    @property
    def n_constants(self) -> int:
        """How many directions are taken out."""
        return len(self.constants.T) + len(self.shared.T)

    def rows(self, stack: Floats) -> Floats:
        """Return (q, k) independent rows of unit variance of (q, 1, k), N·m, other unknowns taken out."""
        white = stack[:, 0] / self.sigma
        for basis in (self.constants, self.shared):
            white = white - (white @ basis) @ basis.T
        return np.asarray(white)

    def with_shared_free(self) -> Self:
        """Return the space that takes the constants out alone: `shared_columns` are then unknowns of the rows."""
        return replace(self, shared=self.shared[:, :0])

    @property
    def shared_columns(self) -> Floats:
        """(r, k) N·m that one unit of each shared direction makes."""
        return np.asarray(self.shared.T * self.sigma)

    @cached_property
    def leverage(self) -> Floats:
        """(k,) share of each row that other unknowns explain whatever it is."""
        return np.asarray(np.sum(self.constants**2, axis=1) + np.sum(self.shared**2, axis=1))

    def sums_as(self, other: DriveSpace) -> bool:
        """Return whether a sum of squares compares with that under others."""
        return np.array_equal(self.sigma, other.sigma)

    def reweighed(self, rows: FrictionRows, left: Floats, known: Booleans) -> DriveSpace:
        """Return the space with rows of unknown noise weighed by what is left of them.

        Parameters
        ----------
        rows : the rows. left : (k,) whitened rest, other unknowns taken out.
        known : (k,) True where the noise is known.
        """
        sigma = self.sigma.copy()
        for joint in np.unique(rows.joint[~known]):
            for steady in (True, False):
                chosen = (rows.joint == joint) & ~known & (rows.steady == steady)
                if chosen.any():
                    # what these rows pay for: other unknowns by their leverage, and a law's usual two sizes
                    paid = float(self.leverage[chosen].sum()) + 2.0
                    share = max(1.0 - paid / chosen.sum(), 0.2)
                    mean = float(np.mean((left[chosen] * self.sigma[chosen]) ** 2))
                    sigma[chosen] = max(float(np.sqrt(mean / share)), 1e-12)
        return DriveSpace.of(rows, sigma)


def first_sigma(rows: FrictionRows) -> Floats:
    """Return (k,) N·m: the noise, and where it is not known how much the joint's torque varies."""
    sigma = rows.sigma.copy()
    for joint in np.unique(rows.joint):
        of_joint = rows.joint == joint
        spread = float(rows.torque[of_joint].std()) or 1.0
        sigma[of_joint & ~np.isfinite(rows.sigma)] = spread
    return sigma

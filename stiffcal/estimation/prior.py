"""What is known of unknowns before the measurement: a normal distribution with mean and covariance.

An unknown x that is normal about μ with the standard deviation σ adds ((x − μ) / σ)² to the sum of squares (Gelman and
others, Bayesian Data Analysis, 2013, section 14.8).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers


@dataclass(frozen=True)
class Prior:
    """A normal distribution of q of p unknowns."""

    members: Integers
    """(q,) which of the unknowns."""
    mean: Floats
    """(q,)."""
    covariance: Floats
    """(q, q) positive definite."""

    @classmethod
    def independent(cls, deviation: Floats, mean: Floats | None = None) -> Prior:
        """Return the prior of unknowns (p,) that are independent of each other.

        Parameters
        ----------
        deviation : (p,) standard deviations, infinite or 0 where nothing is known. mean : (p,); None: zero.
        """
        members = np.flatnonzero(np.isfinite(deviation) & (deviation > 0.0))
        centre = np.zeros(len(members)) if mean is None else mean[members]
        return cls(members, centre, np.diag(deviation[members] ** 2))

    def rows(self, values: Floats) -> Floats:
        """Return (q, p + 1) rows of the problem ``rows[:, :p] step ≈ rows[:, p]`` about values (p,)."""
        rows = np.zeros((len(self.members), len(values) + 1))
        if len(self.members):
            rows[:, self.members] = np.linalg.inv(np.linalg.cholesky(self.covariance))
            rows[:, -1] = rows[:, self.members] @ (self.mean - values[self.members])
        return rows

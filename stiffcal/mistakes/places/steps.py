"""What a rigid motion of all places from each row on explains of what a fit leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.mistakes.places.mistake import LeftOfPlaces

# Columns of which others leave less than this share are sums of them, but for rounding.
SAME = 1e-9
# Rows on either side of a step: a motion of six numbers that fewer rows show is a mistake in these rows.
LEAST_ROWS = 6
# Courses of a drift: in proportion to the rows' number, or settling with time constants of these shares of all rows.
SETTLING = (1.0 / 3.0, 0.1)


def orthonormal(columns: Floats) -> Floats:
    """Return an orthonormal basis (rows, r) of columns (rows, p)."""
    size = np.linalg.norm(columns, axis=0)
    left, values, _ = np.linalg.svd(columns[:, size > 0.0] / size[size > 0.0], full_matrices=False)
    return np.asarray(left[:, values > SAME * values.max(initial=1.0)])


@dataclass(frozen=True)
class Steps:
    """What a rigid motion from each of N rows on makes in the whitened readings that the model's parameters do not."""

    own: Floats
    """(m, N, 6) the motion of each row."""
    basis: Floats
    """(m, N, r) orthonormal, of the model."""
    shared: Floats
    """(N, 6, r) what of the motion from a row on the model makes."""
    inverse: Floats
    """(N, 6, 6) covariance of the motion from a row on; zero for rows that are not looked at."""
    first: int
    """The first of the N rows that is of an absolute run."""
    looked_at: Integers
    """Rows with enough others on either side."""

    @classmethod
    def of(cls, left: LeftOfPlaces) -> Steps:
        """Sum up from each row on."""
        own, basis, first = left.motion, left.basis, left.first
        shared = _from_here(np.einsum("mna,mnr->nar", own, basis))
        square = _from_here(np.einsum("mna,mnb->nab", own, own)) - shared @ np.swapaxes(shared, 1, 2)
        looked_at = np.arange(first + LEAST_ROWS, own.shape[1] - LEAST_ROWS + 1)
        inverse = np.zeros_like(square)
        inverse[looked_at] = np.linalg.pinv(square[looked_at], rcond=1e-9, hermitian=True)
        return cls(own, basis, shared, inverse, first, looked_at)

    def gains(self, left: Floats) -> tuple[Floats, Floats]:
        """Return (N, d) the squares that a motion from each row on takes, and (N, 6, d) that motion.

        Parameters
        ----------
        left : (m, N, d) d whitened residuals.
        """
        model = np.tensordot(self.basis, left, axes=([0, 1], [0, 1]))
        target = _from_here(np.einsum("mna,mnd->nad", self.own, left)) - self.shared @ model
        solution = self.inverse @ target
        return np.sum(target * solution, axis=1), solution

    def step(self, k: int) -> Floats:
        """Return (m, N, 6) what motions from row k on make that the model does not."""
        step = np.where(np.arange(self.own.shape[1])[:, None] >= k, self.own, 0.0)
        return np.asarray(step - self.basis @ self.shared[k].T)

    def largest_share(self, left: Floats, k: int, motion: Floats) -> float:
        """Return the share of one row in what a motion from row k on takes, of the rows on the shorter side.

        Parameters
        ----------
        left : (m, N) a whitened residual. motion : (6,) of the rows from k on.
        """
        of_rows = np.sum((self.own @ motion) * left, axis=0)
        side = of_rows[k:] if len(of_rows) - k <= k - self.first else -of_rows[self.first : k]
        total = float(side.sum())
        return float(side.max()) / total if total > 0.0 else 1.0

    def drifts(self, left: Floats) -> tuple[Floats, Integers]:
        """Return the squares that drifts of several courses over the rows take, and by how many numbers.

        Parameters
        ----------
        left : (m, N) a whitened residual.
        """
        gains, numbers = [], []
        along = np.zeros(self.own.shape[1])
        along[self.first :] = np.linspace(0.0, 1.0, len(along) - self.first)
        for courses in ([along], *([1.0 - np.exp(-along / share)] for share in SETTLING), [along, along**2]):
            drift = np.concatenate([self.own * course[:, None] for course in courses], axis=2)
            columns, model = drift.reshape(-1, drift.shape[2]), self.basis.reshape(-1, self.basis.shape[2])
            unit = orthonormal(columns - model @ (model.T @ columns))
            gains.append(float(np.sum((left.ravel() @ unit) ** 2)))
            numbers.append(unit.shape[1])
        return np.array(gains), np.array(numbers)


def _from_here(values: Floats) -> Floats:
    """Return sums over all rows from each on, along the first axis."""
    return np.asarray(np.flip(np.cumsum(np.flip(values, axis=0), axis=0), axis=0))

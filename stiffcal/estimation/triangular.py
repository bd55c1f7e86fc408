"""Least squares brought to triangular form, also of more rows than fit into memory.

Why QR and not the normal equations: the observation matrices of wrist and tilt compliances have condition numbers of
1e4 and more, which the normal equations square. Why block by block: 36 columns of 200 000 full poses are a third of a
gigabyte, and one triangular factor of 37 × 37 is all that is kept of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats
from stiffcal.estimation.bounded_least_squares import column_scale, least_squares, least_squares_within

# Columns whose sine to those before is above this lose four of sixteen digits at most in the inverse of their factor.
WELL_CONDITIONED = 1e-4
# Columns with a sine below this are sums of the others to rounding.
EXACT_SUM = 1e-11
# Numbers that one factorisation takes: 16 MB.
NUMBERS_AT_ONCE = 1 << 21
# Rows whose mean square is beyond this, in units of the rows before, are not like them.
ALIKE = 1e4


@dataclass(frozen=True)
class Reduced:
    """A least-squares problem brought to triangular form: minimise |factor x − target|² + remainder."""

    factor: Floats
    """(p, p) upper triangular."""
    target: Floats
    """(p,)."""
    remainder: float
    """What no x can lower."""
    dof: int
    """Whitened rows minus the offsets' components; the parameters are not yet subtracted."""
    predicted: Floats | None = None
    """(m, n) the model's displacements that the problem was linearised about, where it was built from blocks."""

    def with_prior(self, rows: Floats) -> Reduced:
        """Return the problem with rows (r, p + 1) of what is known before: ``rows[:, :p] x ≈ rows[:, p]``.

        The degrees of freedom grow by the parameters that the measurement determines no better than what was known.
        """
        if not len(rows):
            return self
        p = len(self.target)
        own = np.zeros((p + 1, p + 1))
        own[:p, :p], own[:p, p], own[p, p] = self.factor, self.target, np.sqrt(max(self.remainder, 0.0))
        triangle = triangular(np.vstack([own, rows]))
        share = float(np.sum((rows[:, :p] @ scaled_inverse(triangle[:p, :p])) ** 2))
        remainder = float(triangle[p, p] ** 2)
        dof = self.dof + round(share)
        return replace(self, factor=triangle[:p, :p], target=triangle[:p, p], remainder=remainder, dof=dof)

    def solve(self) -> Floats:
        """Return the minimum of smallest norm (directions that the data do not determine stay at zero)."""
        return least_squares(self.factor, self.target)

    def solve_bounded(self, lower: Floats, upper: Floats, independent: bool = False) -> tuple[Floats, Booleans]:
        """Return the minimum within bounds, and which lie on one; ``independent`` as in `least_squares_within`."""
        return least_squares_within(self.factor, self.target, lower, upper, independent)

    def covariance(self, free: Booleans) -> Floats:
        """Return the (f, f) covariance of the f free parameters, of readings of unit variance, the others as they are.

        Parameters
        ----------
        free : (p,) True for those that are solved for.
        """
        inverse = scaled_inverse(self.factor[:, free])
        return np.asarray(inverse @ inverse.T)

    def cost(self, x: Floats) -> float:
        """Return the weighted sum of squares at x."""
        return float(np.sum((self.factor @ x - self.target) ** 2) + self.remainder)


def scaled_inverse(factor: Floats) -> Floats:
    """Return the pseudo-inverse (p, r) of a factor (r, p), its columns taken as equally long."""
    scale = column_scale(factor)
    return np.asarray(np.linalg.pinv(factor / scale, rcond=1e-13) / scale[:, None])


def triangular(stack: Floats) -> Floats:
    """Return R of the QR factorisation of a (rows, columns) stack, padded to a square."""
    factor: Floats = np.asarray(np.linalg.qr(stack, mode="r"), dtype=np.float64)
    if factor.shape[0] < factor.shape[1]:
        factor = np.vstack([factor, np.zeros((factor.shape[1] - factor.shape[0], factor.shape[1]))])
    return np.asarray(factor)


def triangular_of_rows(rows: Floats) -> Floats:
    """Return R of the QR factorisation of the transpose of (columns, rows), a piece of the rows at a time.

    Where there are few rows it is that of `triangular`; of many no second and third copy is made.
    """
    step = max(len(rows), NUMBERS_AT_ONCE // max(len(rows), 1))
    factor = triangular(rows[:, :step].T)
    for start in range(step, rows.shape[1], step):
        factor = triangular(np.vstack([factor, rows[:, start : start + step].T]))
    return factor


class TriangularFactor:
    """R of the QR factorisation of more rows than fit into memory.

    The first rows go through Householder reflections. With their R as preconditioner what follows is nearly
    orthonormal, Y = X R⁻¹, so that its Gram matrix squares nothing, and I + YᵀY = LLᵀ gives the new factor LᵀR
    (preconditioned Cholesky QR; Fukaya and others 2020). That is three times as fast. Columns that are sums of others
    to rounding, as those of springs about one axis are, follow them. Where columns are close to such a sum but not
    equal, or new rows are unlike the first, the reflections do it.
    """

    def __init__(self) -> None:
        self._factor: Floats | None = None
        self._kept: Floats | None = None
        self._basis: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._follow: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._inverse: Floats = np.zeros((0, 0))
        self._shares: Floats = np.zeros((0, 0))
        self._gram: Floats = np.zeros((0, 0))

    def add(self, rows: Floats) -> None:
        """Add (columns, rows): the transpose of what is factorised."""
        if self._kept is not None and self._followed(rows):
            alike = self._inverse.T @ rows[self._basis]
            gram = alike @ alike.T
            if np.trace(gram) <= ALIKE * len(gram):
                self._gram += gram
                if np.trace(self._gram) > ALIKE * len(gram):
                    self._fold()
                return
        self._fold()
        self._factor = triangular(rows.T if self._factor is None else np.vstack([self._factor, rows.T]))
        self._precondition()

    def whole(self) -> Floats:
        """Return R (columns, columns)."""
        self._fold()
        if self._factor is None:
            raise ValueError("no states to fit")
        return self._factor

    def _followed(self, rows: Floats) -> bool:
        """Return whether the columns that were sums of others are so in these rows too."""
        if not len(self._follow):
            return True
        away = rows[self._follow] - self._shares.T @ rows[self._basis]
        size = np.einsum("kn,kn->k", rows[self._follow], rows[self._follow])
        return bool(np.all(np.einsum("kn,kn->k", away, away) <= (EXACT_SUM**2) * size))

    def _fold(self) -> None:
        if self._kept is None or not self._gram.any():
            return
        lower = np.linalg.cholesky(np.eye(len(self._gram)) + self._gram)
        kept = lower.T @ self._kept
        factor = np.zeros((len(kept), len(self._basis) + len(self._follow)))
        factor[:, self._basis], factor[:, self._follow] = kept, kept @ self._shares
        self._factor = triangular(factor)
        self._precondition()

    def _precondition(self) -> None:
        """Choose the columns that the others are sums of, and invert their factor."""
        self._kept = None
        if self._factor is None:
            return
        scale = column_scale(self._factor)
        sine = _sines(self._factor)
        self._basis, self._follow = np.flatnonzero(sine > EXACT_SUM), np.flatnonzero(sine <= EXACT_SUM)
        if sine[self._basis].min(initial=1.0) < WELL_CONDITIONED:
            return
        combined = triangular(np.concatenate([self._factor[:, self._basis], self._factor[:, self._follow]], axis=1))
        count = len(self._basis)
        self._kept = combined[:count, :count]
        self._inverse = np.linalg.inv(self._kept / scale[self._basis]) / scale[self._basis][:, None]
        self._shares = self._inverse @ combined[:count, count:]
        self._gram = np.zeros((count, count))


def _sines(factor: Floats) -> Floats:
    """Return each column's sine to the columns before it, those left out that are sums of others to rounding."""
    scale = column_scale(factor)
    unit = factor / scale
    sines, basis = np.zeros(len(scale)), np.zeros((len(factor), 0))
    for k in range(len(scale)):
        orthogonal = unit[:, k] - basis @ (basis.T @ unit[:, k])
        orthogonal = orthogonal - basis @ (basis.T @ orthogonal)
        sines[k] = np.sqrt(np.sum(orthogonal**2))
        if sines[k] > EXACT_SUM:
            basis = np.column_stack([basis, orthogonal / sines[k]])
    return sines

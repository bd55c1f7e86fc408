"""What fits find without some of their rows: poses, runs, regions, passes or single rows left out in turn.

About one set of values the problem is linear, and leaving a fold out is a change of low rank. With R the triangular
factor of all rows, A_f and b_f those of the fold and x the solution of all, W_f = A_f R⁻¹ gives

    x₋f = x + R⁻¹ W_fᵀ (1 − W_f W_fᵀ)⁻¹ (A_f x − b_f)

for whatever is not on a bound (the deletion formula of regression; Belsley, Kuh and Welsch 1980, section 2.1). What is
known before belongs to the problem as a whole and stays. Where a parameter meets or leaves a bound without the fold, or
the fold determines a direction nearly alone, the rows of all others are brought to triangular form and solved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.estimation.bounded_least_squares import column_scale
from stiffcal.estimation.rows import Rows
from stiffcal.estimation.triangular import Reduced, triangular

# A direction of which the other rows hold less than this share loses four of sixteen digits in the formula.
LEAST_LEFT = 1e-4
# Singular values of columns of unit length, of the largest, below which a direction is not determined.
UNDETERMINED = 1e-9
# A slope at a bound of less than this share of the rows' size is rounding.
SLACK = 1e-9


@dataclass(frozen=True)
class LeaveOut:
    """Rows about the values of p unknowns, in folds that are left out in turn."""

    white: Floats
    """(p + 1, N) independent rows of unit variance: columns and, last, what they are to explain."""
    folds: Sequence[Integers]
    """F positions in the rows; no row is in two."""
    prior: Floats
    """(r, p + 1) what is known before, in no fold; the last column is wanted."""
    lower: Floats
    """(p,) how far down each unknown can go from its value, −∞ where there is no bound."""
    upper: Floats
    """(p,) how far up."""

    @classmethod
    def of(cls, rows: Rows, folds: Sequence[Integers]) -> Self:
        """Return the rows of a model and its readings; ``folds`` are positions in (m · n) readings."""
        return cls(rows.white, folds, rows.prior, *rows.steps_within)

    def with_columns(self, columns: Floats, lower: Floats, upper: Floats, fixed: Floats | None = None) -> Self:
        """Return the problem with q unknowns more, of which nothing is known before.

        Parameters
        ----------
        columns : (q, N) their whitened rows. lower, upper : (q,) bounds.
        fixed : (N,) what comes with them whatever their values, whitened; None: nothing.
        """
        prior = np.insert(self.prior, [self.prior.shape[1] - 1] * len(columns), 0.0, axis=1)
        wanted = self.white[-1:] if fixed is None else self.white[-1:] - fixed
        white = np.concatenate([self.white[:-1], columns, wanted])
        low, high = np.append(self.lower, lower), np.append(self.upper, upper)
        return replace(self, white=white, prior=prior, lower=low, upper=high)

    def without_bounds(self, number: int) -> Self:
        """Return the problem with one unknown's bounds taken away."""
        lower, upper = self.lower.copy(), self.upper.copy()
        lower[number], upper[number] = -np.inf, np.inf
        return replace(self, lower=lower, upper=upper)

    @cached_property
    def steps(self) -> Floats:
        """(F, p) the solution without each fold; what only the fold determined stays where it is, a step of zero."""
        steps, sure = self._by_deletion()
        doubtful = np.flatnonzero(~sure)
        for fold, reduced in zip(doubtful.tolist(), self._without(doubtful), strict=True):
            steps[fold] = _solved(reduced, self.lower, self.upper, column_scale(self._whole[0].factor))
        return steps

    @property
    def solution(self) -> Floats:
        """(p,) the solution of all rows."""
        return self._whole[1]

    @property
    def sum_of_squares(self) -> float:
        """What it leaves of all rows, and of what is known before."""
        whole, x = self._whole
        return whole.cost(x)

    @property
    def residual(self) -> Floats:
        """(N,) what the fit without its fold leaves of each row; rows in no fold by the fit of all."""
        result = self.white[-1] - self._whole[1] @ self.white[:-1]
        for step, fold in zip(self.steps, self.folds, strict=True):
            result[fold] = self.white[-1, fold] - step @ self.white[:-1, fold]
        return np.asarray(result)

    @property
    def spread(self) -> Floats:
        """(N,) standard deviation of `residual` by the rows' own noise, whatever the bounds.

        Infinite where the other rows do not determine every unknown, NaN of rows in no fold.
        """
        result = np.full(self.white.shape[1], np.nan)
        for reduced, fold in zip(self._without(np.arange(len(self.folds))), self.folds, strict=True):
            if not _independent(reduced.factor):
                result[fold] = np.inf
                continue
            of_unknowns = np.linalg.solve(reduced.factor.T, self.white[:-1, fold])
            result[fold] = np.sqrt(1.0 + np.sum(of_unknowns**2, axis=0))
        return result

    def determined(self, number: int) -> Booleans:
        """Return (F,) whether an unknown is determined without each fold, whatever is left open of the others."""
        every = self._without(np.arange(len(self.folds)))
        return np.array([_determined(reduced.factor)[number] for reduced in every], dtype=np.bool_)

    @property
    def all_determined(self) -> Booleans:
        """(F, p) the same of all unknowns."""
        every = self._without(np.arange(len(self.folds)))
        return np.array([_determined(reduced.factor) for reduced in every], dtype=np.bool_)

    @cached_property
    def _whole(self) -> tuple[Reduced, Floats]:
        """The problem of all rows, and its solution."""
        reduced = _reduced(triangular(np.vstack([self._outside, *self._pieces])))
        return reduced, _solved(reduced, self.lower, self.upper, column_scale(reduced.factor))

    @cached_property
    def _pieces(self) -> Sequence[Floats]:
        """Of each fold rows (r, p + 1) with its inner products, p + 1 at most."""
        k = len(self.white)
        parts = [self.white[:, fold].T for fold in self.folds]
        return [triangular(part) if len(part) > k else part for part in parts]

    @cached_property
    def _outside(self) -> Floats:
        """(p + 1, p + 1) triangular factor of what is known before and of rows that are in no fold."""
        rest = np.ones(self.white.shape[1], dtype=np.bool_)
        for fold in self.folds:
            rest[fold] = False
        return triangular(np.vstack([self.prior, self.white[:, rest].T, np.zeros((1, len(self.white)))]))

    def _by_deletion(self) -> tuple[Floats, Booleans]:
        """Return (F, p) solutions with those on a bound staying there, and (F,) where that is sure."""
        whole, x = self._whole
        steps, sure = np.tile(x, (len(self.folds), 1)), np.zeros(len(self.folds), dtype=np.bool_)
        free = (x > self.lower) & (x < self.upper)
        factor = triangular(whole.factor[:, free]) if free.any() else np.zeros((0, 0))
        if not _independent(whole.factor):
            return steps, sure
        inverse = np.linalg.inv(factor)
        size = np.sqrt(np.sum(whole.factor**2, axis=0)) * np.sqrt(np.sum(self.white[-1] ** 2))
        pull = whole.factor.T @ (whole.target - whole.factor @ x)
        sizes = np.array([len(piece) for piece in self._pieces])
        for length in np.unique(sizes):
            number = np.flatnonzero(sizes == length)
            rows = np.stack([self._pieces[fold] for fold in number.tolist()])
            missed = rows[:, :, -1] - rows[:, :, :-1] @ x
            weight = rows[:, :, :-1][:, :, free] @ inverse
            left = np.eye(length) - weight @ np.swapaxes(weight, 1, 2)
            enough = np.linalg.eigvalsh(left)[:, 0] > LEAST_LEFT
            left[~enough] = np.eye(length)
            change = np.linalg.solve(left, missed[..., None])
            steps[np.ix_(number, free)] -= (np.swapaxes(weight, 1, 2) @ change)[..., 0] @ inverse.T
            found = steps[number]
            within = np.all((found >= self.lower) & (found <= self.upper), axis=1)
            # the slopes of the others' squares at what is on a bound
            moved = found - x
            of_fold = missed - (rows[:, :, :-1] @ moved[..., None])[..., 0]
            slope = pull - moved @ (whole.factor.T @ whole.factor) - np.einsum("frp,fr->fp", rows[:, :, :-1], of_fold)
            leaves = (~free & (self.lower < self.upper)) & (
                ((x <= self.lower) & (slope > SLACK * size)) | ((x >= self.upper) & (slope < -SLACK * size))
            )
            sure[number] = enough & within & ~leaves.any(axis=1)
        return steps, sure

    def _without(self, folds: Integers) -> Iterator[Reduced]:
        """Yield the problem of the other rows and of what is known before, for some of the folds in order."""
        square = [triangular(piece) for piece in self._pieces]
        for factor in _factors_without(square, set(folds.tolist()), 0, self._outside):
            yield _reduced(factor)


def _reduced(factor: Floats) -> Reduced:
    return Reduced(factor[:-1, :-1], factor[:-1, -1], float(factor[-1, -1] ** 2), 0)


def _factors_without(factors: Sequence[Floats], wanted: set[int], first: int, outside: Floats) -> Iterator[Floats]:
    """Yield, for every wanted factor, that of all the others together.

    Halving shares the work: what one half has in common is brought to triangular form once for all of the other half,
    so that the time grows with N log N.

    Parameters
    ----------
    factors : N factors (k, k). wanted : their numbers, of which ``first`` is that of the first. outside : (k, k) of
        rows that are in none of them.
    """
    if wanted.isdisjoint(range(first, first + len(factors))):
        return
    if len(factors) == 1:
        yield outside
        return
    middle = len(factors) // 2
    halves = (factors[:middle], first), (factors[middle:], first + middle)
    for (half, begin), (other, _) in (halves, halves[::-1]):
        if not wanted.isdisjoint(range(begin, begin + len(half))):
            yield from _factors_without(half, wanted, begin, triangular(np.vstack([outside, *other])))


def _independent(factor: Floats) -> bool:
    if not len(factor):
        return True
    singular = np.linalg.svd(factor / column_scale(factor), compute_uv=False)
    return bool(singular[-1] > UNDETERMINED * singular[0])


def _solved(reduced: Reduced, lower: Floats, upper: Floats, length: Floats) -> Floats:
    """Return the solution (p,) within bounds, of those in directions that are not determined the one nearest to zero.

    Parameters
    ----------
    length : (p,) of the columns of all rows, by which steps compare.
    """
    if not len(lower):
        return np.zeros(0)
    if not _independent(reduced.factor):
        p = len(lower)
        nearest = np.column_stack([UNDETERMINED * np.diag(length), np.zeros(p)])
        reduced = _reduced(triangular(np.vstack([np.column_stack([reduced.factor, reduced.target]), nearest])))
    return reduced.solve_bounded(lower, upper, independent=True)[0]


def _determined(factor: Floats) -> Booleans:
    """Return (p,) which parameters a triangular factor (p, p) determines, whatever it leaves open of the others."""
    _, singular, directions = np.linalg.svd(factor / column_scale(factor))
    left_open = directions[singular <= UNDETERMINED * singular[0]]
    return np.asarray(np.sum(left_open**2, axis=0) < UNDETERMINED)

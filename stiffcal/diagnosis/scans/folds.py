"""Poses (folds) left out of the fit in turn, from their inner products.

Leaving folds out is subtraction of their inner products, refitting is one small solve, and the error on what was left
out is a quadratic form. Folds of few rows each are cheaper still (`few_rows`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.scans.normal_equations import quadratic, solve_within, without_rows

# Numbers of the matrices that one batched solve works on: 4 MB, of which it makes a handful of copies.
NUMBERS_AT_ONCE = 1 << 19


@dataclass(frozen=True)
class LeftOutFolds:
    """What the fits without each fold leave."""

    residual: Floats
    """(N,) residual of each row, by the fit without its fold."""
    rest: Floats
    """(F,) squares of all other folds, by the same fit."""
    without: Floats | None = None
    """(F, k) the parameters of these fits; None where folds have few rows and all columns are the model's own."""


def fold_products(rows: Floats, folds: Sequence[Integers | slice]) -> Floats:
    """Return (F, k, k) inner products of rows (k, m · n), fold by fold."""
    return np.stack([rows[:, fold] @ rows[:, fold].T for fold in folds])


def inner_outside(outside: Floats, k: int) -> Floats | None:
    """Return (k + 1, k + 1) inner products of rows (r, p + 1) that are in no fold, None where there are none.

    Their p columns are the first of the k; their last column is the residual.
    """
    if not len(outside):
        return None
    rows = np.zeros((len(outside), k + 1))
    rows[:, : outside.shape[1] - 1], rows[:, -1] = outside[:, :-1], outside[:, -1]
    return np.asarray(rows.T @ rows)


@dataclass(frozen=True)
class FoldProducts:
    """Folds of many rows each, by their inner products."""

    each: Floats
    """(F, k + 1, k + 1) residual last."""
    rows: Floats
    """(k + 1, N) the rows behind them."""
    folds: Sequence[Integers | slice]
    """F positions in the rows."""
    outside: Floats | None = None
    """(k + 1, k + 1) inner products of what is known before and stays when a fold is left out; None: nothing is."""

    @classmethod
    def of(cls, rows: Floats, folds: Sequence[Integers | slice], outside: Floats | None = None) -> FoldProducts:
        """Prepare rows (k + 1, N), residual last."""
        return cls(fold_products(rows, folds), rows, folds, outside)

    @cached_property
    def total(self) -> Floats:
        """(k + 1, k + 1) of all folds, and of what is known before."""
        of_folds = self.each.sum(axis=0)
        return np.asarray(of_folds if self.outside is None else of_folds + self.outside)

    def left_out(self, lower: Floats, upper: Floats, near: Floats) -> tuple[LeftOutFolds, Floats]:
        """Leave each fold out in turn; return what is left and (F,) its squares in what was left out.

        Parameters
        ----------
        lower, upper : (k,) bounds. near : (k,) the solution with all folds.
        """
        without, rest = solve_folds(self.total, self.each, lower, upper, near)
        residual = np.zeros(self.rows.shape[1])
        for x, fold in zip(without, self.folds, strict=True):
            residual[fold] = self.rows[-1, fold] - x @ self.rows[:-1, fold]
        return LeftOutFolds(residual, rest, without), quadratic(self.each, without)

    def moved(self, left: LeftOutFolds, base: LeftOutFolds) -> Floats:
        """Return (F,) squares by which the prediction of each fold left out differs from that of the base model."""
        squares = (base.residual - left.residual) ** 2
        return np.array([squares[fold].sum() for fold in self.folds])

    def grouped(self, groups: Integers) -> Floats:
        """Return (G, k + 1, k + 1) of groups of folds."""
        member = (groups[None, :] == np.arange(int(groups.max()) + 1)[:, None]).astype(np.float64)
        return np.asarray((member @ self.each.reshape(len(self.each), -1)).reshape(-1, *self.each.shape[1:]))


def solve_folds(total: Floats, folds: Floats, lower: Floats, upper: Floats, near: Floats) -> tuple[Floats, Floats]:
    """Return (F, k) parameters with each fold left out, and (F,) the squares that they leave of the rest.

    Parameters
    ----------
    total : (k + 1, k + 1) inner products of all folds, residual last. folds : (F, k + 1, k + 1) of each.
    lower, upper : (k,) bounds. near : (k,) the solution with all folds.
    """
    solutions, training = np.empty((len(folds), len(near))), np.empty(len(folds))
    step = max(1, NUMBERS_AT_ONCE // total.size)
    for start in range(0, len(folds), step):
        batch = slice(start, start + step)
        rest = without_rows(total, folds[batch])
        solutions[batch] = solve_within(rest[:, :-1, :-1], rest[:, :-1, -1], lower, upper, near)
        training[batch] = quadratic(rest, solutions[batch])
    return solutions, training

"""The present model's whitened rows, fold after fold, to which candidates are added."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.scans.few_rows import AddedColumns, FewRows
from stiffcal.diagnosis.scans.folds import FoldProducts, fold_products, inner_outside
from stiffcal.diagnosis.scans.normal_equations import quadratic, solve_within
from stiffcal.diagnosis.scans.scoring import Score, score_variants
from stiffcal.diagnosis.thresholds import CHOICE_FOLDS
from stiffcal.estimation.rows import RowSpace
from stiffcal.estimation.unknowns import signs_of
from stiffcal.identification.fitting.regressors import Regressor, RegressorMaker, StoredRegressor


def choice_groups(n_folds: int) -> Integers:
    """Deal folds into groups for the repeated choice, every n-th to the same."""
    return np.arange(n_folds, dtype=np.int64) % min(n_folds, CHOICE_FOLDS)


def sorted_by_fold(folds: Sequence[Integers]) -> tuple[Integers, list[slice]]:
    """Return (m · n,) indices that sort whitened rows by fold, and the rows of each fold after sorting."""
    ends = np.cumsum([len(fold) for fold in folds])
    return np.concatenate(folds), [slice(int(e) - len(fold), int(e)) for e, fold in zip(ends, folds, strict=True)]


def in_order(score: Score, order: Integers) -> Score:
    """Return the score of rows that were sorted, its own rows in the order before."""
    residual = np.empty_like(score.left.residual)
    residual[order] = score.left.residual
    return replace(score, left=replace(score.left, residual=residual))


def bounds_of_candidate(regressor: Regressor | StoredRegressor) -> tuple[Floats, Floats]:
    """Return the bounds of a candidate's amplitudes: what cannot be negative is not."""
    return signs_of([regressor.effect.spec(symbol) for symbol in regressor.symbols])


@dataclass(frozen=True)
class BaseRows:
    """The present model's rows, sorted by fold, to which candidates are added."""

    state: RegressorMaker
    """Makes candidates' regressors about the model."""
    space: RowSpace
    """Whitening and free constants."""
    rows: Floats
    """(p, m · n) base columns, sorted by fold."""
    residual: Floats
    """(1, m · n) whitened residual, sorted by fold."""
    order: Integers
    """(m · n,) indices that sort whitened rows by fold."""
    cuts: list[slice]
    """The rows of each fold after sorting."""
    inner_sum: Floats
    """(p, p) inner products of the base columns over all folds."""
    groups: Integers
    """(F,) groups of folds for the repeated choice."""
    low: Floats
    """(p,) lower bounds of the base model's parameters."""
    high: Floats
    """(p,) their upper bounds."""
    base: Score
    """Its score, of the sorted rows."""
    outside: Floats
    """(r, p + 1) rows of what is known of the base model's parameters before, in no fold; the residual last."""
    few: FewRows | None = None
    """The base columns, where folds have few rows."""

    @cached_property
    def inner(self) -> Floats:
        """(F, p, p) inner products of the base columns, by fold."""
        return fold_products(self.rows, self.cuts)

    @classmethod
    def of(
        cls, state: RegressorMaker, space: RowSpace, stack: Floats, folds: Sequence[Integers], low: Floats,
        high: Floats, outside: Floats,
    ) -> BaseRows:  # fmt: skip
        """Prepare; ``stack`` (p + 1, m, n) holds the base columns and the residual."""
        order, cuts = sorted_by_fold(folds)
        rows = space.rows(stack)[:, order]
        few, groups = FewRows.of(rows[:-1], cuts, outside), choice_groups(len(folds))
        whole: FoldProducts | AddedColumns
        if few is None:
            whole = FoldProducts.of(rows, cuts, inner_outside(outside, len(low)))
        else:
            whole = AddedColumns.of(few, rows[-1:])
        base, inner = score_variants([whole], low, high, groups), whole.total[:-1, :-1]
        return cls(
            state, space, rows[:-1], rows[-1:], order, cuts, inner, groups, low, high, base, outside, few
        )  # fmt: skip

    def rows_of(self, regressor: Regressor) -> Floats:
        """Return (q + 1, m · n): the candidate's columns and what is left of the residual, sorted by fold."""
        rows = self.space.rows(np.concatenate([regressor.columns, regressor.fixed[None]]))[:, self.order]
        rows[-1] = self.residual[0] - rows[-1]
        return np.asarray(rows)

    def products(self, mine: Floats) -> FoldProducts:
        """Return the inner products of base columns, the candidate's and the residual."""
        p, q = len(self.rows), len(mine)
        whole = np.concatenate([self.rows, mine])
        result = np.empty((len(self.cuts), p + q, p + q))
        result[:, :p, :p] = self.inner
        for k, cut in enumerate(self.cuts):
            result[k, :, p:] = whole[:, cut] @ mine[:, cut].T
        result[:, p:, :p] = np.swapaxes(result[:, :p, p:], 1, 2)
        return FoldProducts(result, whole, self.cuts, inner_outside(self.outside, p + q - 1))

    def of_folds(self, mine: Floats) -> FoldProducts | AddedColumns:
        """Return what `score_variants` takes of base columns, the candidate's and the residual."""
        if self.few is not None:
            return AddedColumns.of(self.few, mine)
        return self.products(mine)

    def bounds(self, regressor: Regressor) -> tuple[Floats, Floats]:
        """Return the bounds of base and candidate."""
        low, high = bounds_of_candidate(regressor)
        return np.concatenate([self.low, low]), np.concatenate([self.high, high])

    def sum_of_squares(self, regressor: Regressor) -> float:
        """Return the residual's whitened sum of squares with a candidate added, fitted with all poses."""
        candidate_rows, p = self.rows_of(regressor), len(self.rows)
        total = np.empty((p + len(candidate_rows), p + len(candidate_rows)))
        total[:p, :p] = self.inner_sum
        total[:p, p:], total[p:, p:] = self.rows @ candidate_rows.T, candidate_rows @ candidate_rows.T
        total[p:, :p] = total[:p, p:].T
        if len(self.outside):
            # of the base columns with each other it is in there
            target = self.outside[:, -1]
            total[:p, -1] += self.outside[:, :-1].T @ target
            total[-1, :p], total[-1, -1] = total[:p, -1], total[-1, -1] + target @ target
        solution = solve_within(total[:-1, :-1], total[:-1, -1], *self.bounds(regressor))
        return float(quadratic(total, solution))

    def score(self, regressors: Sequence[Regressor]) -> tuple[Score, Regressor]:
        """Score a candidate, the choice among its foremost shapes repeated in every fold; and the best of them."""
        rows = (self.rows_of(regressor) for regressor in regressors)
        score = score_variants(map(self.of_folds, rows), *self.bounds(regressors[0]), self.groups, self.base)
        return in_order(score, self.order), regressors[score.variant]

"""Folds of few rows each: every candidate next to a base model that is solved once.

A fold of r rows changes the equations of all by rank r only, and a candidate of q columns adds q unknowns to those of
the base model. With P the inner products of the base's columns B, K = P⁻¹, and B_f, c_f, m_f the rows of a fold in the
base's columns, the candidate's and the residual, eliminating the base leaves (block elimination; Sherman, Morrison and
Woodbury)

    z = c − B Γ, Γ = K Bᵀ c,    e = m − B β, β = K Bᵀ m,    M_f = (1 − B_f K B_fᵀ)⁻¹
    a_f = (zᵀ c − z_fᵀ M_f z_f)⁻¹ (zᵀ m − z_fᵀ M_f e_f)

for the candidate's amplitudes without the fold, and M_f (e_f − z_f a_f) for what the fit without it leaves of it. K and
M_f are the base's and made once for each set of its parameters that lie on bounds. Folds without which a parameter
meets or leaves a bound, or is not determined, are solved by themselves. What is known of the base's parameters before
is rows that belong to no fold, after those of all folds; candidates are 0 there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.scans.folds import LeftOutFolds, solve_folds
from stiffcal.diagnosis.scans.normal_equations import RIDGE, ROUNDING, SLACK, quadratic
from stiffcal.diagnosis.thresholds import FEW_ROWS

# Determinant of what a fold's rows leave open when the others are fitted; below it the fold alone determines a
# parameter.
LEAST_OPEN = 1e-8
# Sets of the base's parameters on bounds that are kept: candidates share a few of them.
MOST_SETS = 4


@dataclass(frozen=True)
class FewRows:
    """The base model's rows, fold after fold, and what is solved of them."""

    columns: Floats
    """(N + o, p) base columns, fold after fold, then those of o rows that are in no fold."""
    starts: Integers
    """(F,) the first row of each fold."""
    wanted: Floats
    """(o,) what the rows in no fold are to explain."""
    _sets: dict[bytes, _HeldSet] = field(default_factory=dict)
    _groups: dict[bytes, list[tuple[Integers, Floats, Floats]]] = field(default_factory=dict)

    @classmethod
    def of(cls, columns: Floats, cuts: Sequence[slice], outside: Floats | None = None) -> FewRows | None:
        """Prepare base columns (p, N) sorted by fold; None where folds have many rows.

        Parameters
        ----------
        cuts : the rows of each fold.
        outside : (o, p + 1) rows that are in no fold, what they are to explain last; None: there are none.
        """
        if FEW_ROWS * columns.shape[1] > len(cuts) * (len(columns) + 1):
            return None
        outside = np.zeros((0, len(columns) + 1)) if outside is None else outside
        starts = np.array([cut.start for cut in cuts], dtype=np.int64)
        return cls(np.concatenate([columns.T, outside[:, :-1]]), starts, outside[:, -1])

    @property
    def n_rows(self) -> int:
        """How many rows are in folds."""
        return len(self.columns) - len(self.wanted)

    @cached_property
    def sizes(self) -> Integers:
        """(F,) how many rows each fold has."""
        return np.diff(np.append(self.starts, self.n_rows))

    @cached_property
    def inner(self) -> Floats:
        """(p, p) inner products of the columns."""
        return np.asarray(self.columns.T @ self.columns)

    @cached_property
    def scale(self) -> Floats:
        """(p,) lengths of the columns, 1 where there is none."""
        squares = np.diagonal(self.inner)
        return np.sqrt(np.where(squares > 0.0, squares, 1.0))

    def held(self, on_bound: Booleans) -> _HeldSet:
        """Return what is solved with some parameters (p,) held on their bounds."""
        key = on_bound.tobytes()
        if key not in self._sets:
            if len(self._sets) >= MOST_SETS:
                self._sets.pop(next(iter(self._sets)))
            self._sets[key] = _HeldSet.of(self, ~on_bound)
        return self._sets[key]

    def grouped(self, groups: Integers) -> list[tuple[Integers, Floats, Floats]]:
        """Return of each group of folds its rows' positions, base columns (n, p) and their inner products (p, p)."""
        key = groups.tobytes()
        if key not in self._groups:
            group = np.repeat(groups, self.sizes)
            positions = [np.flatnonzero(group == g) for g in range(int(groups.max()) + 1)]
            parts = [(chosen, self.columns[chosen]) for chosen in positions]
            self._groups.clear()
            self._groups[key] = [(chosen, part, part.T @ part) for chosen, part in parts]
        return self._groups[key]


@dataclass(frozen=True)
class _Alike:
    """Folds of one size, with some of the base's parameters held."""

    number: Integers
    """(F',) which folds."""
    rows: Integers
    """(F', r) their rows."""
    gain: Floats
    """(F', r, p') B_f K of the free parameters, columns scaled."""
    leverage: Floats
    """(F', r, r) M_f."""
    open_part: Floats
    """(F',) determinant of 1 − B_f K B_fᵀ."""
    undetermined: Booleans
    """(F',) True where a column of the base's has no rows in other folds."""


@dataclass(frozen=True)
class _HeldSet:
    """The base's equations with some of its parameters held on their bounds."""

    free: Booleans
    """(p,) True where a parameter is not held."""
    normal: Floats
    """(p', p') inner products of the free columns, scaled, with the ridge."""
    alike: tuple[_Alike, ...]
    """Folds by their number of rows; those of many rows are in none."""

    @classmethod
    def of(cls, base: FewRows, free: Booleans) -> _HeldSet:
        columns = base.columns[:, free] / base.scale[free]
        normal = columns.T @ columns + RIDGE * np.eye(columns.shape[1])
        gain = np.linalg.solve(normal, columns.T).T
        alike = []
        for size in np.unique(base.sizes[2 * base.sizes <= base.columns.shape[1]]):
            number = np.flatnonzero(base.sizes == size)
            rows = base.starts[number, None] + np.arange(size)
            open_part = np.eye(size) - gain[rows] @ np.swapaxes(columns[rows], 1, 2)
            determinant = np.asarray(np.linalg.det(open_part), dtype=np.float64)
            open_part[~(determinant > LEAST_OPEN)] = np.eye(size)
            alone = np.sum((base.columns[rows] / base.scale) ** 2, axis=1) >= 1.0 - ROUNDING
            leverage = np.asarray(np.linalg.inv(open_part))
            alike.append(_Alike(number, rows, np.asarray(gain[rows]), leverage, determinant, alone.any(axis=1)))
        return cls(free, normal, tuple(alike))


@dataclass(frozen=True)
class AddedColumns:
    """Base columns, a candidate's and the residual, in folds of few rows each."""

    base: FewRows
    """The base model's."""
    mine: Floats
    """(N + o, q + 1) the candidate's columns and the residual, of the same rows."""

    @classmethod
    def of(cls, base: FewRows, rows: Floats) -> AddedColumns:
        """Return a candidate's columns and the residual (q + 1, N) next to those of the base model."""
        outside = np.zeros((len(base.wanted), len(rows)))
        outside[:, -1] = base.wanted
        return cls(base, np.concatenate([rows.T, outside]))

    @cached_property
    def total(self) -> Floats:
        """(k + 1, k + 1) inner products of all folds, residual last."""
        return _bordered(self.base.inner, self.base.columns, self.mine)

    def left_out(self, lower: Floats, upper: Floats, near: Floats) -> tuple[LeftOutFolds, Floats]:
        """Leave each fold out in turn; return what is left and (F,) its squares in what was left out.

        Parameters
        ----------
        lower, upper : (k,) bounds. near : (k,) the solution with all folds.
        """
        solutions, residual, doubtful = self._by_small_rank(lower, upper, near)
        alone = np.flatnonzero(doubtful)
        if alone.size:
            rows = [self._rows(fold) for fold in alone.tolist()]
            products = np.stack([whole.T @ whole for _, whole in rows])
            solutions[alone], _ = solve_folds(self.total, products, lower, upper, near)
            for (part, whole), solution in zip(rows, solutions[alone], strict=True):
                residual[part] = whole[:, -1] - whole[:, :-1] @ solution
        squares = self._sums(residual**2)
        # of readings alone, as many as folds, what was left says all; of nuisance errors it does not
        without = solutions if len(self.base.wanted) else None
        return LeftOutFolds(residual, quadratic(self.total, solutions) - squares, without), squares

    def moved(self, left: LeftOutFolds, base: LeftOutFolds) -> Floats:
        """Return (F,) squares by which the prediction of each fold left out differs from that of the base model."""
        return self._sums((base.residual - left.residual) ** 2)

    def _sums(self, values: Floats) -> Floats:
        return np.asarray(np.add.reduceat(values, self.base.starts))

    def grouped(self, groups: Integers) -> Floats:
        """Return (G, k + 1, k + 1) of groups of folds."""
        return np.stack([_bordered(inner, part, self.mine[rows]) for rows, part, inner in self.base.grouped(groups)])

    def _rows(self, fold: int) -> tuple[slice, Floats]:
        """Return where a fold's rows are, and the rows (r, k + 1)."""
        start = int(self.base.starts[fold])
        rows = slice(start, start + int(self.base.sizes[fold]))
        return rows, np.concatenate([self.base.columns[rows], self.mine[rows]], axis=1)

    def _by_small_rank(self, lower: Floats, upper: Floats, near: Floats) -> tuple[Floats, Floats, Booleans]:
        """Return (F, k) parameters with those on a bound staying there, and (N,) what they leave of their folds.

        The third (F,) is True where both are in doubt.
        """
        base, k = self.base, len(near)
        p, n_folds = base.columns.shape[1], len(base.starts)
        squares = np.diagonal(self.total)[:-1]
        scale = np.append(base.scale, np.sqrt(np.where(squares[p:] > 0.0, squares[p:], 1.0)))
        low, high = lower * scale, upper * scale
        on_lower, on_upper = near <= lower, near >= upper
        held = on_lower | on_upper
        known = base.held(held[:p])
        fixed = np.where(on_lower, low, np.where(on_upper, high, 0.0))
        free_mine = ~held[p:]
        # a parameter on its bound is known: its part of the readings counts as measured
        columns = base.columns[:, known.free] / base.scale[known.free]
        added = self.mine[:, :-1][:, free_mine] / scale[p:][free_mine]
        rest = self.mine[:, -1] - base.columns @ (fixed[:p] / base.scale)
        rest -= self.mine[:, :-1] @ (fixed[p:] / scale[p:])
        both = np.linalg.solve(known.normal, columns.T @ np.column_stack([added, rest]))
        shares, start = both[:, :-1], both[:, -1]
        own, left = added - columns @ shares, rest - columns @ start
        normal, right = own.T @ added + RIDGE * np.eye(added.shape[1]), own.T @ rest
        value, doubtful = np.zeros((n_folds, k)), np.ones(n_folds, dtype=np.bool_)
        value[:, held] = fixed[held]
        whole = self.total[:-1, :-1] / scale[:, None] / scale + RIDGE * np.eye(k)
        aim = self.total[:-1, -1] / scale
        margin = SLACK * np.abs(aim).max(initial=0.0)
        of_held = np.column_stack([base.columns[:, held[:p]], self.mine[:, :-1][:, held[p:]]]) / scale[held]
        alone = (self.mine[:, :-1] / scale[p:]) ** 2
        residual = np.zeros(base.n_rows)
        size = max(float(np.linalg.det(normal)), 0.0)
        free = np.flatnonzero(~held)
        n_free = int(np.count_nonzero(known.free))
        for alike in known.alike:
            z, lever = own[alike.rows], alike.leverage
            weighed = lever @ z
            matrix = normal - np.swapaxes(weighed, 1, 2) @ z
            sure = (alike.open_part > LEAST_OPEN) & (alike.open_part * np.linalg.det(matrix) > LEAST_OPEN * size)
            matrix[~sure] = np.eye(len(right))
            e = left[alike.rows][..., None]
            amplitude = np.linalg.solve(matrix, right[:, None] - np.swapaxes(weighed, 1, 2) @ e)
            missed = lever @ (e - z @ amplitude)
            found = np.empty((len(alike.number), len(free)))
            found[:, n_free:] = amplitude[..., 0]
            found[:, :n_free] = (
                start - amplitude[..., 0] @ shares.T - np.einsum("fr,frp->fp", missed[..., 0], alike.gain)
            )
            solution = value[alike.number]
            solution[:, free] = found
            outside = ((found < low[free]) | (found > high[free])).any(axis=1)
            slope = solution @ whole[:, held] - aim[held]
            slope += np.einsum("fr,frh->fh", missed[..., 0], of_held[alike.rows])
            leaving = ((on_lower[held] & (slope < -margin)) | (on_upper[held] & (slope > margin))).any(axis=1)
            undetermined = alike.undetermined | (alone[alike.rows].sum(axis=1) >= 1.0 - ROUNDING).any(axis=1)
            value[alike.number], residual[alike.rows] = solution, missed[..., 0]
            doubtful[alike.number] = ~sure | outside | leaving | undetermined
        return value / scale, residual, doubtful


def _bordered(inner: Floats, columns: Floats, mine: Floats) -> Floats:
    """Return the inner products of columns (n, p) and mine (n, q) together, those of the first (p, p) at hand."""
    p, q = columns.shape[1], mine.shape[1]
    result = np.empty((p + q, p + q))
    result[:p, :p], result[:p, p:], result[p:, p:] = inner, columns.T @ mine, mine.T @ mine
    result[p:, :p] = result[:p, p:].T
    return result

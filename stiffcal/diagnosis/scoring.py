"""How a candidate does in poses left out of its fit, from small matrices of inner products.

For every pose (fold) f the inner products G_f of all whitened rows — base model, candidate, residual — are taken once.
Leaving poses out is then subtraction, refitting everything else with the candidate is one small solve, and the error on
a pose left out is a quadratic form. All folds, and all pairs of folds for the choice repeated inside each fold, go
through one batched solve.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.bounded_least_squares import least_squares_within

# Numbers of the matrices that one batched solve works on: 32 MB, of which it makes a handful of copies.
NUMBERS_AT_ONCE = 1 << 22
# Rounds of exchanging all at once without getting better before one is exchanged at a time, and rounds per parameter.
PATIENCE = 3
PIVOTS = 6
# Sums of squares that are less than this share of what they were taken from are rounding.
ROUNDING = 1e-12
# Of scaled inner products: columns that agree to seven digits share what they explain instead of blowing up.
RIDGE = 1e-10
# Slopes at a bound that are less than this share of the largest inner product are rounding.
SLACK = 1e-9
# Determinant of what a fold's rows leave open when the others are fitted; below it the fold alone determines a
# parameter.
LEAST_OPEN = 1e-8


def solve_within(normal: Floats, right: Floats, lower: Floats, upper: Floats, near: Floats | None = None) -> Floats:
    """Solve batches of normal equations within bounds.

    Parameters
    ----------
    normal : (…, k, k) inner products of the columns.
    right : (…, k) inner products with the residual.
    lower, upper : (k,) bounds of each parameter.
    near : (k,) a solution of much the same equations: its parameters on bounds are tried there first.

    Returns
    -------
    (…, k). Block principal pivoting (Portugal, Júdice and Vicente 1994; Kim and Park 2011): all parameters that leave
    their bounds are put on them and all that should leave a bound are let go, until none is left; where that does not
    get better, one at a time (Murty's rule). What rounding keeps from ending within `PIVOTS` rounds per parameter goes
    to the active set of `least_squares_within`.

    Raises
    ------
    InputError : neither ends.
    """
    k = normal.shape[-1]
    if k == 0:  # a model of effects whose values are all fixed
        return np.zeros_like(right)
    diagonal = np.einsum("...kk->...k", normal)
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    scaled = (normal / scale[..., :, None] / scale[..., None, :] + RIDGE * np.eye(k)).reshape(-1, k, k)
    target = (right / scale).reshape(-1, k)
    low, high = ((bound * scale).reshape(-1, k) for bound in (lower, upper))
    side = np.zeros(target.shape, dtype=np.int8)  # −1 on the lower bound, 1 on the upper, 0 free
    if near is not None:
        side[:] = np.where(near <= lower, -1, np.where(near >= upper, 1, 0))
    result = np.zeros_like(target)
    active = np.arange(len(target))
    fewest, patience = np.full(len(target), k + 1), np.full(len(target), PATIENCE)
    slack = SLACK * np.abs(target).max(axis=-1, keepdims=True, initial=0.0)
    for _ in range(PIVOTS * k + 1):
        whole = len(active) == len(target)
        matrix, aim, on = (scaled, target, side) if whole else (scaled[active], target[active], side[active])
        least, most = low if len(low) == 1 else low[active], high if len(high) == 1 else high[active]
        free = on == 0
        if free.all():
            value = np.linalg.solve(matrix, aim[..., None])[..., 0]
            wrong = (value < least) | (value > most)
        else:
            bound_values = np.where(on < 0, least, np.where(on > 0, most, 0.0))
            masked = matrix * (free[:, :, None] & free[:, None, :])
            masked[:, range(k), range(k)] += ~free
            right_side = aim - (matrix @ bound_values[..., None])[..., 0]
            value = np.linalg.solve(masked, np.where(free, right_side, bound_values)[..., None])[..., 0]
            slope, margin = (matrix @ value[..., None])[..., 0] - aim, slack[active]
            outside = (value < least) | (value > most)
            wrong = np.where(free, outside, np.where(on < 0, slope < -margin, slope > margin))
        result[active] = value
        count = wrong.sum(axis=-1)
        going = count > 0
        if not going.any():
            break
        active, wrong, count, below, on = active[going], wrong[going], count[going], (value < least)[going], on[going]
        better = count < fewest[active]
        patience[active] = np.where(better, PATIENCE, patience[active] - 1)
        fewest[active] = np.minimum(fewest[active], count)
        single = patience[active] < 0
        last = k - 1 - np.argmax(wrong[:, ::-1], axis=-1)
        moving = wrong & (~single[:, None] | (np.arange(k) == last[:, None]))
        side[active] = np.where(moving, np.where(on == 0, np.where(below, -1, 1), 0), on)
    else:
        # Columns alike to rounding are exchanged for each other without end.
        for problem in active:
            least, most = (bound[0] if len(bound) == 1 else bound[problem] for bound in (low, high))
            squares, axes = np.linalg.eigh(scaled[problem])
            size = np.sqrt(np.maximum(squares, 1e-10))
            aim = axes.T @ target[problem] / size
            result[problem], _ = least_squares_within(size[:, None] * axes.T, aim, least, most)
    return np.clip(result.reshape(right.shape) / scale, lower, upper)


@dataclass(frozen=True)
class Score:
    """A candidate's errors, whitened sums of squares."""

    sum_of_squares: float
    """Of the residual, fitted with all poses."""
    heldout: Floats
    """(F,) on each pose left out."""
    nested: Floats
    """(F, F) on pose g with poses f and g left out (row f, column g; the diagonal is ``heldout``)."""
    solution: Floats
    """(k,) parameters with all poses, base model first."""
    without: Floats
    """(F, k) parameters with each pose left out, at the shape that is best with all."""
    variant: int
    """Which shape was best with all poses."""
    prediction_change: Floats
    """(F,) by how much the candidate moves the prediction of each pose left out, whitened squares; zero for the base
    model itself.
    """
    normal: Floats
    """(k, k) whitened inner products of the columns, all poses together: the information of ``solution``."""
    in_run: tuple[tuple[Integers, Floats], ...] = ()
    """Of a slip, for each load cycle of the slipped pose: the positions (s,) of its rows, and by how much the
    parameters (k,) fitted without it differ from the base model's.
    """


def quadratic(products: Floats, solution: Floats) -> Floats:
    """Return |residual − columns x|² from (…, k + 1, k + 1) inner products, residual last."""
    half = (products[..., :-1, :-1] @ solution[..., None])[..., 0] - 2.0 * products[..., :-1, -1]
    return np.asarray(np.einsum("...k,...k->...", solution, half) + products[..., -1, -1])


def without_rows(total: Floats, taken: Floats) -> Floats:
    """Return inner products (k, k) less those of rows that are left out, (…, k, k).

    A column whose rows are all left out is then zero; what rounding leaves of it would count like any other column.
    """
    remaining = total - taken
    in_rounding = np.einsum("...kk->...k", remaining) <= ROUNDING * np.diagonal(total)
    return np.asarray(np.where(in_rounding[..., :, None] | in_rounding[..., None, :], 0.0, remaining))


def fold_products(rows: Floats, folds: Sequence[Integers | slice], prior: Floats | None = None) -> Floats:
    """Return (F, k, k) inner products of rows (k, m · n), fold by fold.

    ``prior`` (p,) is the precision of the first p columns' parameters before the data, about zero: each fold holds an
    equal part of it, as if every pose brought a reading of them.
    """
    products = np.stack([rows[:, fold] @ rows[:, fold].T for fold in folds])
    if prior is not None:
        first = np.arange(len(prior))
        products[:, first, first] += prior / len(folds)
    return products


@dataclass(frozen=True)
class FoldProducts:
    """Folds of many rows each, by their inner products."""

    each: Floats
    """(F, k + 1, k + 1) residual last."""

    @cached_property
    def total(self) -> Floats:
        """(k + 1, k + 1) of all folds."""
        return np.asarray(self.each.sum(axis=0))

    def without_each(self, lower: Floats, upper: Floats, near: Floats) -> tuple[Floats, Floats]:
        """Return (F, k) parameters with each fold left out, and (F,) the squares that they leave of the rest."""
        return _solve_folds(self.total, self.each, lower, upper, near)

    def squares(self, solution: Floats) -> Floats:
        """Return (F,) the squares that parameters (F, k) leave of each fold."""
        return quadratic(self.each, solution)

    def moved(self, change: Floats) -> Floats:
        """Return (F,) the squares by which changes (F, k) of the parameters move each fold's prediction."""
        moved = (self.each[:, :-1, :-1] @ change[..., None])[..., 0]
        return np.asarray(np.einsum("fk,fk->f", change, moved))

    def grouped(self, groups: Integers) -> Floats:
        """Return (G, k + 1, k + 1) of groups of folds."""
        member = (groups[None, :] == np.arange(int(groups.max()) + 1)[:, None]).astype(np.float64)
        return np.asarray((member @ self.each.reshape(len(self.each), -1)).reshape(-1, *self.each.shape[1:]))


@dataclass(frozen=True)
class FoldRows:
    """Folds of few rows each, by the rows themselves: one fold changes the equations of all by that small rank.

    With A and b of all folds, C and m of one, x = A⁻¹ b,
    (A − Cᵀ C)⁻¹ (b − Cᵀ m) = x − A⁻¹ Cᵀ (1 − C A⁻¹ Cᵀ)⁻¹ (m − C x) (Sherman, Morrison and Woodbury).
    Folds without which a parameter meets or leaves a bound, or is not determined, are solved by themselves.
    """

    rows: Floats
    """(m · n, k + 1) residual last, fold after fold."""
    starts: Integers
    """(F,) the first row of each fold."""

    @cached_property
    def total(self) -> Floats:
        """(k + 1, k + 1) of all folds."""
        return np.asarray(self.rows.T @ self.rows)

    @cached_property
    def _sizes(self) -> Integers:
        """(F,) how many rows each fold has."""
        return np.diff(np.append(self.starts, len(self.rows)))

    def without_each(self, lower: Floats, upper: Floats, near: Floats) -> tuple[Floats, Floats]:
        """Return (F, k) parameters with each fold left out, and (F,) the squares that they leave of the rest."""
        solutions, doubtful = np.empty((len(self.starts), len(near))), np.ones(len(self.starts), dtype=np.bool_)
        for size in np.unique(self._sizes[2 * self._sizes <= len(near)]):
            alike = np.flatnonzero(self._sizes == size)
            rows = self.rows[self.starts[alike, None] + np.arange(size)]
            solutions[alike], doubtful[alike] = _by_small_rank(self.total, rows, (lower, upper), near)
        each = [self.rows[start : start + size] for start, size in zip(self.starts, self._sizes, strict=True)]
        alone = np.flatnonzero(doubtful)
        if alone.size:
            products = np.stack([each[fold].T @ each[fold] for fold in alone])
            solutions[alone], _ = _solve_folds(self.total, products, lower, upper, near)
        return solutions, quadratic(self.total, solutions) - self.squares(solutions)

    def squares(self, solution: Floats) -> Floats:
        """Return (F,) the squares that parameters (F, k) leave of each fold."""
        solution = np.repeat(solution, self._sizes, axis=0)
        left = self.rows[:, -1] - np.einsum("nk,nk->n", self.rows[:, :-1], solution)
        return np.asarray(np.add.reduceat(left**2, self.starts))

    def moved(self, change: Floats) -> Floats:
        """Return (F,) the squares by which changes (F, k) of the parameters move each fold's prediction."""
        moved = np.einsum("nk,nk->n", self.rows[:, :-1], np.repeat(change, self._sizes, axis=0))
        return np.asarray(np.add.reduceat(moved**2, self.starts))

    def grouped(self, groups: Integers) -> Floats:
        """Return (G, k + 1, k + 1) of groups of folds."""
        group = np.repeat(groups, self._sizes)
        return np.stack([rows.T @ rows for rows in (self.rows[group == g] for g in range(int(groups.max()) + 1))])


def _by_small_rank(total: Floats, rows: Floats, bounds: tuple[Floats, Floats], near: Floats) -> tuple[Floats, Booleans]:
    """Return (F, k) parameters with those on a bound staying there, and (F,) True where that is in doubt.

    Parameters
    ----------
    total : (k + 1, k + 1) inner products of all folds. rows : (F, r, k + 1) of the folds, each left out alone.
    bounds, near : as in `_solve_folds`.
    """
    normal, right = total[:-1, :-1], total[:-1, -1]
    diagonal = np.diagonal(normal)
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    low, high = bounds[0] * scale, bounds[1] * scale
    columns = rows[..., :-1] / scale
    matrix, aim = normal / scale[:, None] / scale + RIDGE * np.eye(len(scale)), right / scale
    on_lower, on_upper = near <= bounds[0], near >= bounds[1]
    held = on_lower | on_upper
    value = np.zeros((len(rows), len(scale)))
    value[:, held] = np.where(on_lower, low, high)[held]
    # a parameter on its bound is known: its part of the readings counts as measured
    rest = rows[..., -1] - columns[..., held] @ value[0, held]
    factor = np.linalg.inv(matrix[np.ix_(~held, ~held)])
    free = columns[..., ~held]
    solution = factor @ (aim[~held] - matrix[np.ix_(~held, held)] @ value[0, held])
    gain = free @ factor
    open_part = np.eye(free.shape[1]) - gain @ np.swapaxes(free, 1, 2)
    sure = np.linalg.det(open_part) > LEAST_OPEN
    open_part[~sure] = np.eye(free.shape[1])
    step = np.linalg.solve(open_part, (rest - free @ solution)[..., None])
    value[:, ~held] = solution - (np.swapaxes(gain, 1, 2) @ step)[..., 0]
    outside = ((value < low) | (value > high))[:, ~held].any(axis=1)
    left = (columns @ value[..., None])[..., 0] - rows[..., -1]
    slope = value @ matrix - aim - (np.swapaxes(columns, 1, 2) @ left[..., None])[..., 0]
    margin = SLACK * np.abs(aim).max(initial=0.0)
    leaving = ((on_lower & (slope < -margin)) | (on_upper & (slope > margin))).any(axis=1)
    undetermined = (1.0 - np.sum(columns**2, axis=1) <= ROUNDING)[:, diagonal > 0.0].any(axis=1)
    return value / scale, np.asarray(~sure | outside | leaving | undetermined)


def rows_by_fold(rows: Floats, cuts: Sequence[slice]) -> FoldRows | None:
    """Return rows (k + 1, m · n), sorted by fold, for `score_variants`; None where folds have many rows.

    Parameters
    ----------
    cuts : the rows of each fold.
    """
    if 3 * rows.shape[1] > len(cuts) * len(rows):
        return None
    return FoldRows(np.ascontiguousarray(rows.T), np.array([cut.start for cut in cuts], dtype=np.int64))


def _solve_folds(total: Floats, folds: Floats, lower: Floats, upper: Floats, near: Floats) -> tuple[Floats, Floats]:
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


def score_variants(
    products: Iterable[Floats | FoldProducts | FoldRows],
    lower: Floats,
    upper: Floats,
    groups: Integers,
    base: Score | None = None,
) -> Score:
    """Score a candidate whose shape is chosen, in every fold anew, among variants.

    Parameters
    ----------
    products : per variant (F, k + 1, k + 1) inner products, residual last, or the rows of folds that have few; taken
        one after the other.
    lower, upper : (k,) bounds.
    groups : (F,) group of each fold for the repeated choice.
    base : the base model's score, whose parameters come first.
    """
    fitted, solutions, normals, heldout, training, without, squared_change = [], [], [], [], [], [], []
    nested, nested_training = [], []
    for product in products:
        variant = FoldProducts(product) if isinstance(product, np.ndarray) else product
        total = variant.total
        solution = solve_within(total[:-1, :-1], total[:-1, -1], lower, upper)
        solutions.append(solution)
        normals.append(total[:-1, :-1])
        fitted.append(float(quadratic(total, solution)))
        x, left = variant.without_each(lower, upper, solution)
        without.append(x)
        training.append(left)
        heldout.append(variant.squares(x))
        change = x.copy()
        before = x if base is None else base.without
        change[:, : before.shape[1]] -= before
        squared_change.append(variant.moved(change))
        twice_left, twice_training = _without_pairs(variant.grouped(groups), total, (lower, upper), solution)
        nested.append(twice_left)
        nested_training.append(twice_training)
    best = int(np.argmin(fitted))
    chosen = np.argmin(training, axis=0)
    picked = np.argmin(nested_training, axis=0)
    folds = np.arange(len(groups))
    return Score(
        fitted[best],
        np.stack(heldout)[chosen, folds],
        np.take_along_axis(np.stack(nested), picked[None], axis=0)[0],
        solutions[best],
        without[best],
        best,
        np.stack(squared_change)[chosen, folds],
        normals[best],
    )


def _without_pairs(
    grouped: Floats, total: Floats, bounds: tuple[Floats, Floats], near: Floats
) -> tuple[Floats, Floats]:
    """Return (G, G) squares on group h with groups g and h left out, and those that the same fits leave of the rest.

    Parameters
    ----------
    grouped : (G, k + 1, k + 1) inner products of each group. total : of all together.
    bounds, near : as in `_solve_folds`.
    """
    first, second = np.triu_indices(len(grouped))
    apart = (first != second)[:, None, None]
    rest = without_rows(total, grouped[first] + np.where(apart, grouped[second], 0.0))
    solution = solve_within(rest[:, :-1, :-1], rest[:, :-1, -1], *bounds, near)
    left, training = np.empty((2, len(grouped), len(grouped)))
    left[first, second], left[second, first] = (quadratic(grouped[of], solution) for of in (second, first))
    training[first, second] = training[second, first] = quadratic(rest, solution)
    return left, training

"""How a candidate does in poses left out of its fit, from small matrices of inner products.

For every pose (fold) f the inner products G_f of all whitened rows — base model, candidate, residual — are taken once.
Leaving poses out is then subtraction, refitting everything else with the candidate is one small solve, and the error on
a pose left out is a quadratic form. All folds, and all pairs of folds for the choice repeated inside each fold, go
through one batched solve.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.bounded_least_squares import least_squares_within

# Numbers of the matrices that one batched solve works on: 32 MB, of which it makes a handful of copies.
NUMBERS_AT_ONCE = 1 << 22
# Rounds of exchanging all at once without getting better before one is exchanged at a time, and rounds per parameter.
PATIENCE = 3
PIVOTS = 6
# Sums of squares that are less than this share of what they were taken from are rounding.
ROUNDING = 1e-12


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
    # Columns that agree to seven digits share what they explain instead of blowing up.
    scaled = (normal / scale[..., :, None] / scale[..., None, :] + 1e-10 * np.eye(k)).reshape(-1, k, k)
    target = (right / scale).reshape(-1, k)
    low, high = ((bound * scale).reshape(-1, k) for bound in (lower, upper))
    side = np.zeros(target.shape, dtype=np.int8)  # −1 on the lower bound, 1 on the upper, 0 free
    if near is not None:
        side[:] = np.where(near <= lower, -1, np.where(near >= upper, 1, 0))
    result = np.zeros_like(target)
    active = np.arange(len(target))
    fewest, patience = np.full(len(target), k + 1), np.full(len(target), PATIENCE)
    slack = 1e-9 * np.abs(target).max(axis=-1, keepdims=True, initial=0.0)
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
    inner = np.einsum("...k,...kl,...l->...", solution, products[..., :-1, :-1], solution)
    return np.asarray(
        inner - 2.0 * np.einsum("...k,...k->...", solution, products[..., :-1, -1]) + products[..., -1, -1]
    )


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
    products: Iterable[Floats], lower: Floats, upper: Floats, groups: Integers, base: Score | None = None
) -> Score:
    """Score a candidate whose shape is chosen, in every fold anew, among variants.

    Parameters
    ----------
    products : per variant (F, k + 1, k + 1) inner products, residual last; taken one after the other.
    lower, upper : (k,) bounds.
    groups : (F,) group of each fold for the repeated choice.
    base : the base model's score, whose parameters come first.
    """
    n_groups = int(groups.max()) + 1
    member = groups[None, :] == np.arange(n_groups)[:, None]
    fitted, solutions, normals, heldout, training, without, squared_change = [], [], [], [], [], [], []
    nested, nested_training = [], []
    for product in products:
        total = product.sum(axis=0)
        solution = solve_within(total[:-1, :-1], total[:-1, -1], lower, upper)
        solutions.append(solution)
        normals.append(total[:-1, :-1])
        fitted.append(float(quadratic(total, solution)))
        x, left = _solve_folds(total, product, lower, upper, solution)
        without.append(x)
        training.append(left)
        heldout.append(quadratic(product, x))
        change = x.copy()
        before = x if base is None else base.without
        change[:, : before.shape[1]] -= before
        squared_change.append(np.einsum("fk,fkl,fl->f", change, product[:, :-1, :-1], change))
        grouped = np.einsum("gf,fkl->gkl", member.astype(np.float64), product)
        either_group = grouped[:, None] + grouped[None, :] - np.einsum("gh,gkl->ghkl", np.eye(n_groups), grouped)
        twice = without_rows(total, either_group)
        y = solve_within(twice[..., :-1, :-1], twice[..., :-1, -1], lower, upper, solution)
        nested_training.append(quadratic(twice, y))
        nested.append(quadratic(np.broadcast_to(grouped[None, :], twice.shape), y))
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

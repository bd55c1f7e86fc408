"""Small normal equations: their solution within bounds, what it leaves, and inner products without some rows."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.bounded_least_squares import least_squares_within

# Rounds of exchanging all at once without getting better before one is exchanged at a time, and rounds per parameter.
PATIENCE = 3
PIVOTS = 6
# Sums of squares that are less than this share of what they were taken from are rounding.
ROUNDING = 1e-12
# Of scaled inner products: columns that agree to seven digits share what they explain instead of blowing up.
RIDGE = 1e-10
# Slopes at a bound that are less than this share of the largest inner product are rounding.
SLACK = 1e-9


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

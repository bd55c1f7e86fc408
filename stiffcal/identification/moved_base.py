"""Whether the base, or the tracker, was moved between two rows of absolute places.

From the row on, all places are off by one rigid motion: three shifts and three turns in base axes. For every row the
squares that such a motion takes from the residual, next to all of the model's parameters, follow from sums over the
rows; the largest of N has the probability N times that of χ² with six degrees of freedom (Bonferroni). A drift over the
rows, which steps by a little everywhere, has to explain less.

Where the model leaves more than noise, what it leaves is an error of the model, and rows in like poses share it. Rows
that follow each other are then no independent readings, and sums over them scatter more widely: by 1 + 2 Σ ρ, with the
correlations ρ of what is left, weighed down linearly over the distance in rows (Newey and West 1987).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, ndtri

from stiffcal.arrays import Booleans, Floats
from stiffcal.identification.fit import Fit
from stiffcal.identification.observation import evaluate, free_columns
from stiffcal.identification.rows import ROTATION, TRANSLATION
from stiffcal.measurements.load_states import LoadStates

# Moves whose probability by chance, of all rows, is larger are none: of eighty rows some five standard errors.
MOST_P = 0.01
# Where the model leaves more than noise, what it leaves may look like a move: five standard errors after all rows, and
# what neighbouring rows share, are allowed for.
MISFIT, MOST_P_WITH_MISFIT = 1.5, 6e-7
# Rows on either side of a move: a motion of six numbers that fewer rows show is a mistake in these rows.
LEAST_ROWS = 4
# Columns of which others leave less than this share are sums of them, but for rounding.
SAME = 1e-9


@dataclass(frozen=True)
class MovedBase:
    """A rigid motion of all places from one row on."""

    state: int
    """Index of the first row after it, among the campaign's states."""
    shift: Floats
    """(3,) m, of the places at their centre, base axes."""
    turn: Floats
    """(3,) rad, base axes."""
    standard_errors: float
    """The probability of a larger one by chance, as standard errors of a normal distribution, all rows allowed for."""
    leave_out: Booleans
    """(n,) True for the campaign's absolute states on the shorter side."""


def moved_base(fit: Fit, states: LoadStates) -> MovedBase | None:
    """Return the move of the base that the rows of absolute runs show; None where they show none.

    Parameters
    ----------
    fit : of the present model to these states.
    states : the campaign's states, rows in the order in which they were measured.
    """
    data, whitening = fit.data, fit.whitening
    rows = np.flatnonzero(data.absolute & data.measured_mask.any(axis=0))
    fixed = fit.left_at_neutral | {parameter.name for parameter in fit.parameters if parameter.fixed}
    columns = free_columns(fit.robot, fixed)
    if whitening is None or len(rows) < 2 * LEAST_ROWS or fit.dof < 7:
        return None
    time = data.order.time[rows]
    rows = rows[np.argsort(time, kind="stable")] if np.isfinite(time).all() else rows
    model = np.concatenate([block.columns for block in evaluate(fit.robot, data, columns)], axis=2)
    motion = _rigid_motions(states, fit)
    white = whitening.apply(np.where(data.measured_mask, np.concatenate([model, motion]), 0.0))
    # load runs show nothing of the tracker's place, and keep the model's parameters where they are
    basis = _basis(white[: len(model)].reshape(len(model), -1).T).reshape(len(data.measured), data.n_states, -1)
    own, left = np.moveaxis(white[len(model) :][:, :, rows], 0, -1), whitening.apply(fit.residual)[:, rows]
    basis = basis[:, rows]
    gain, solution = _gains(own, basis, left)
    allowed = np.arange(len(rows))
    gain = np.where((allowed >= LEAST_ROWS) & (allowed <= len(rows) - LEAST_ROWS), gain, 0.0)
    k = int(np.argmax(gain))
    total = float(np.sum(whitening.apply(fit.residual) ** 2))
    unit, most_p = max(1.0, (total - float(gain[k])) / max(fit.dof - 6, 1)), MOST_P
    if unit >= MISFIT:
        unit, most_p = unit * _shared_by_rows(left - _step(own, basis, k) @ solution[k]), MOST_P_WITH_MISFIT
    probability = len(rows) * float(chdtrc(6, gain[k] / unit))
    if probability > most_p or gain[k] <= _gain_of_drift(own, basis, left):
        return None
    after = np.zeros(len(states), dtype=np.bool_)
    after[data.index[rows[k:]]] = True
    before = np.zeros_like(after)
    before[data.index[rows[:k]]] = True
    return MovedBase(
        state=int(data.index[rows[k]]),
        shift=solution[k, :3],
        turn=solution[k, 3:],
        standard_errors=float(-ndtri(max(probability, 1e-300) / 2.0)),
        leave_out=after if after.sum() <= before.sum() else before,
    )


def _rigid_motions(states: LoadStates, fit: Fit) -> Floats:
    """Return (6, m, n) what a shift and a turn about the places' centre make in the rows: m per m and per rad."""
    data = fit.data
    position = np.moveaxis(states.position[data.index], 0, -1)
    centre = np.nanmean(position, axis=(0, 2))
    result = np.zeros((6, len(data.measured), data.n_states))
    for row, (kind, body, component) in enumerate(zip(data.kind, data.body, data.component, strict=True)):
        axis = int(component) % 3
        if kind == TRANSLATION:
            lever = np.nan_to_num(position[body] - centre[:, None])
            result[axis, row] = 1.0
            result[3 + (axis + 1) % 3, row] = lever[(axis + 2) % 3]
            result[3 + (axis + 2) % 3, row] = -lever[(axis + 1) % 3]
        elif kind == ROTATION:
            result[3 + axis, row] = 1.0
    return np.where(data.absolute, result, 0.0)


def _basis(columns: Floats) -> Floats:
    """Return an orthonormal basis (rows, r) of columns (rows, p)."""
    size = np.linalg.norm(columns, axis=0)
    left, values, _ = np.linalg.svd(columns[:, size > 0.0] / size[size > 0.0], full_matrices=False)
    return np.asarray(left[:, values > SAME * values.max(initial=1.0)])


def _gains(own: Floats, basis: Floats, left: Floats) -> tuple[Floats, Floats]:
    """Return (N,) the squares that a motion from each row on takes, and (N, 6) that motion.

    Parameters
    ----------
    own : (m, N, 6) whitened motions. basis : (m, N, r) of the model. left : (m, N) the whitened residual.
    """

    def from_here(sums: Floats) -> Floats:
        return np.asarray(np.flip(np.cumsum(np.flip(sums, axis=0), axis=0), axis=0))

    square = from_here(np.einsum("mna,mnb->nab", own, own))
    shared = from_here(np.einsum("mnr,mna->nra", basis, own))
    target = from_here(np.einsum("mna,mn->na", own, left))
    target = target - np.einsum("nra,r->na", shared, np.einsum("mnr,mn->r", basis, left))
    square = square - np.einsum("nra,nrb->nab", shared, shared)
    solution = np.einsum("nab,nb->na", np.linalg.pinv(square, rcond=1e-9, hermitian=True), target)
    return np.einsum("na,na->n", target, solution), solution


def _step(own: Floats, basis: Floats, k: int) -> Floats:
    """Return (m, N, 6) what motions from row k on make that the model does not."""
    step = np.where(np.arange(own.shape[1])[:, None] >= k, own, 0.0)
    return np.asarray(step - basis @ np.einsum("mnr,mna->ra", basis, step))


def _shared_by_rows(left: Floats) -> float:
    """Return by what factor sums over rows scatter more than those of independent rows, 1 at least.

    Parameters
    ----------
    left : (m, N) the whitened residual, rows in the order in which they were measured; no move in it.
    """
    most = int(np.sqrt(left.shape[1]))
    products = np.array([np.sum(left[:, lag:] * left[:, : left.shape[1] - lag]) for lag in range(most + 1)])
    weight = 1.0 - np.arange(1, most + 1) / (most + 1.0)
    return max(1.0, 1.0 + 2.0 * float(weight @ products[1:]) / float(products[0]))


def _gain_of_drift(own: Floats, basis: Floats, left: Floats) -> float:
    """Return the squares that a motion in proportion to the rows' number, and to its square, takes."""
    along = np.linspace(-1.0, 1.0, own.shape[1])
    drift = np.concatenate([own * along[:, None], own * (along**2)[:, None]], axis=2)
    columns, flat = drift.reshape(-1, drift.shape[2]), basis.reshape(-1, basis.shape[2])
    free = columns - flat @ (flat.T @ columns)
    scale = np.linalg.norm(free, axis=0)
    solution = np.linalg.lstsq(free / scale, left.ravel(), rcond=1e-9)[0]
    return float(np.sum((free / scale @ solution) ** 2))

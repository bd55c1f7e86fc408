"""Weighted least squares over blocks of states, each run's constant offset eliminated exactly.

Why QR and not the normal equations: the observation matrices of wrist and tilt compliances have condition numbers of
1e4 and more, which the normal equations square. Why block by block: 36 columns of 200 000 full poses are a third of a
gigabyte, and one triangular factor of 37 × 37 is all that is kept of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats
from stiffcal.bounded_least_squares import column_scale, least_squares, least_squares_within
from stiffcal.identification.noise import Whitening, times
from stiffcal.identification.observation import Evaluation, Observations

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

    def solve(self) -> Floats:
        """Return the minimum of smallest norm (directions that the data do not determine stay at zero)."""
        return least_squares(self.factor, self.target)

    def solve_bounded(self, lower: Floats, upper: Floats) -> tuple[Floats, Booleans]:
        """Return the minimum within bounds, and which parameters lie on a bound."""
        return least_squares_within(self.factor, self.target, lower, upper)

    def cost(self, x: Floats) -> float:
        """Return the weighted sum of squares at x."""
        return float(np.sum((self.factor @ x - self.target) ** 2) + self.remainder)


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


def run_edges(run: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the first index of each stretch of equal run numbers."""
    return np.concatenate([[0], np.flatnonzero(np.diff(run)) + 1]).astype(np.int64)


def take_out_offsets(
    stack: Floats, run: NDArray[np.int64], whitening: Whitening, carries: Booleans
) -> tuple[Floats, int]:
    """Take each run's weighted mean out of every row of a stack: the generalised least-squares offset.

    Parameters
    ----------
    stack : (k, m, n) columns and residual, not yet whitened.
    run : (n,) run numbers, contiguous.
    whitening : of these states.
    carries : (n,) True for the states of runs that carry an offset; the others stay as they are.

    Returns
    -------
    The stack without offsets, and how many offset components were estimated.
    """
    edges = run_edges(run)
    counts = np.diff(np.append(edges, len(run)))
    if whitening.diagonal:
        weight = whitening.scale**2
        total = np.add.reduceat(weight, edges, axis=1)
        mean = np.add.reduceat(stack * weight, edges, axis=2) / np.where(total > 0.0, total, 1.0)
        estimated = total > 0.0
    else:
        precision = whitening.precision()
        sums = np.moveaxis(np.add.reduceat(times(precision, stack), edges, axis=2), -1, 0)
        total = np.moveaxis(np.add.reduceat(precision, edges, axis=2), -1, 0)
        empty = np.diagonal(total, axis1=1, axis2=2) <= 0.0
        total = total + empty[:, :, None] * np.eye(total.shape[1])
        mean = np.moveaxis(np.linalg.solve(total, np.swapaxes(sums, 1, 2)), 0, -1).swapaxes(0, 1)
        estimated = ~empty.T
    with_offset = carries[edges]
    return stack - np.repeat(np.where(with_offset, mean, 0.0), counts, axis=2), int(
        np.count_nonzero(estimated & with_offset)
    )


def _whitened_without_offsets(
    stack: Floats, run: NDArray[np.int64], whitening: Whitening, carries: Booleans
) -> tuple[Floats, int]:
    """Return whitened rows (k, m · n), in any order, each run's offset taken out, and how many offsets there were.

    The same as `take_out_offsets` and then whitening, in a few products per run.
    """
    if whitening.lower is None:
        stack, n_offsets = take_out_offsets(stack, run, whitening, carries)
        return whitening.apply(stack).reshape(len(stack), -1), n_offsets
    m = stack.shape[1]
    white = whitening.apply(stack)
    rows, n_offsets = np.empty((len(stack), white[0].size)), 0
    edges = run_edges(run)
    if not carries.all():
        rows[:] = white.transpose(0, 2, 1).reshape(len(stack), -1)
    for start, end in zip(edges, np.append(edges[1:], len(run)), strict=True):
        if not carries[start]:
            continue
        # what a unit offset of each component becomes when whitened
        unit = np.swapaxes(whitening.lower[:, :, start:end], 0, 1).reshape(m, -1)
        total = unit @ unit.T
        empty = np.diagonal(total) <= 0.0
        n_offsets += m - int(np.count_nonzero(empty))
        block = white[:, :, start:end].reshape(len(stack), -1)
        mean = np.linalg.solve(total + np.diag(empty.astype(np.float64)), unit @ block.T)
        np.subtract(block, mean.T @ unit, out=rows[:, m * start : m * end])
    return rows, n_offsets


def reduce_blocks(evaluations: Iterable[Evaluation], data: Observations, whitening: Whitening) -> Reduced:
    """Bring the linearised problem ``measured − predicted ≈ columns @ x`` to triangular form.

    Parameters
    ----------
    evaluations : predictions and columns, block by block.
    data : the observations.
    whitening : their noise.
    """
    factor, dof = TriangularFactor(), 0
    predicted = np.zeros_like(data.measured)
    for block in evaluations:
        columns = block.rows
        predicted[:, columns] = block.predicted
        stack = np.empty((len(block.columns) + 1, *block.predicted.shape))
        stack[:-1] = block.columns
        stack[-1] = np.where(data.measured_mask[:, columns], data.measured[:, columns] - block.predicted, 0.0)
        local = whitening.subset(columns)
        dof += int(np.count_nonzero(data.measured_mask[:, columns]))
        if data.free_offset:
            carries = data.carries_offset[columns]
            rows, n_offsets = _whitened_without_offsets(stack, data.run[columns], local, carries)
            dof -= n_offsets
        else:
            rows = local.apply(stack).reshape(len(stack), -1)
        factor.add(rows)
    triangle = factor.whole()
    p = len(triangle) - 1
    return Reduced(triangle[:p, :p], triangle[:p, p], float(triangle[p, p] ** 2), dof, predicted)

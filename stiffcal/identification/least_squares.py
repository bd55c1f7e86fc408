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

from stiffcal.identification.noise import Whitening
from stiffcal.identification.observation import Evaluation, Observations

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]


@dataclass(frozen=True)
class Reduced:
    """A least-squares problem brought to triangular form: minimise |factor x − target|² + remainder.

    Attributes
    ----------
    factor : (p, p) upper triangular.
    target : (p,).
    remainder : what no x can lower.
    dof : whitened rows minus the offsets' components; the parameters are not yet subtracted.
    predicted : (m, n) the model's displacements that the problem was linearised about, where it was built from blocks.
    """

    factor: Floats
    target: Floats
    remainder: float
    dof: int
    predicted: Floats | None = None

    def solve(self) -> Floats:
        """Return the minimum of smallest norm (directions that the data do not see stay at zero)."""
        scale = column_scale(self.factor)
        solution, *_ = np.linalg.lstsq(self.factor / scale, self.target, rcond=1e-12)
        return np.asarray(solution / scale)

    def solve_bounded(self, lower: Floats, upper: Floats) -> tuple[Floats, Booleans]:
        """Return the minimum within bounds, and which parameters lie on a bound."""
        free = self.solve()
        if np.all(free >= lower) and np.all(free <= upper):
            return free, np.zeros(len(free), dtype=np.bool_)
        from scipy.optimize import lsq_linear

        scale = column_scale(self.factor)
        found = lsq_linear(self.factor / scale, self.target, bounds=(lower * scale, upper * scale), method="bvls")
        solution = np.clip(found.x / scale, lower, upper)
        return solution, np.asarray(found.active_mask != 0, dtype=np.bool_)

    def cost(self, x: Floats) -> float:
        """Return the weighted sum of squares at x."""
        return float(np.sum((self.factor @ x - self.target) ** 2) + self.remainder)


def column_scale(factor: Floats) -> Floats:
    """Return the columns' lengths (1 for columns of zeros)."""
    length = np.sqrt(np.sum(factor * factor, axis=0))
    return np.where(length > 0.0, length, 1.0)


def triangular(stack: Floats) -> Floats:
    """Return R of the QR factorisation of a (rows, columns) stack, padded to a square."""
    factor: Floats = np.asarray(np.linalg.qr(stack, mode="r"), dtype=np.float64)
    if factor.shape[0] < factor.shape[1]:
        factor = np.vstack([factor, np.zeros((factor.shape[1] - factor.shape[0], factor.shape[1]))])
    return np.asarray(factor)


def run_edges(run: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return where each stretch of equal run numbers begins."""
    return np.concatenate([[0], np.flatnonzero(np.diff(run)) + 1]).astype(np.int64)


def take_out_offsets(stack: Floats, run: NDArray[np.int64], whitening: Whitening) -> tuple[Floats, int]:
    """Take each run's weighted mean out of every row of a stack: the generalised least-squares offset.

    Parameters
    ----------
    stack : (k, m, n) columns and residual, not yet whitened.
    run : (n,) run numbers, contiguous.
    whitening : of these states.

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
        n_offsets = int(np.count_nonzero(total > 0.0))
    else:
        precision = whitening.precision()
        weighted = np.einsum("abn,kbn->kan", precision, stack)
        total = np.moveaxis(np.add.reduceat(precision, edges, axis=2), -1, 0)
        sums = np.moveaxis(np.add.reduceat(weighted, edges, axis=2), -1, 0)
        empty = np.diagonal(total, axis1=1, axis2=2) <= 0.0
        total = total + np.einsum("ra,ab->rab", empty.astype(np.float64), np.eye(total.shape[1]))
        mean = np.moveaxis(np.linalg.solve(total, np.swapaxes(sums, 1, 2)), 0, -1).swapaxes(0, 1)
        n_offsets = int(np.count_nonzero(~empty))
    return stack - np.repeat(mean, counts, axis=2), n_offsets


def reduce_blocks(evaluations: Iterable[Evaluation], data: Observations, whitening: Whitening) -> Reduced:
    """Bring the linearised problem ``measured − predicted ≈ columns @ x`` to triangular form.

    Parameters
    ----------
    evaluations : predictions and columns, block by block.
    data : the observations.
    whitening : their noise.
    """
    factor: Floats | None = None
    dof = 0
    predicted = np.zeros_like(data.measured)
    for block in evaluations:
        part = block.part
        predicted[:, part] = block.predicted
        residual = np.where(data.seen[:, part], data.measured[:, part] - block.predicted, 0.0)
        stack = np.concatenate([block.columns, residual[None]])
        local = whitening.part(part)
        dof += int(np.count_nonzero(data.seen[:, part]))
        if data.free_offset:
            stack, n_offsets = take_out_offsets(stack, data.run[part], local)
            dof -= n_offsets
        white = local.apply(stack)
        rows = white.reshape(len(white), -1).T
        factor = triangular(rows if factor is None else np.vstack([factor, rows]))
    if factor is None:
        raise ValueError("no states to fit")
    p = factor.shape[1] - 1
    return Reduced(factor[:p, :p], factor[:p, p], float(factor[p, p] ** 2), dof, predicted)

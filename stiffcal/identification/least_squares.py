"""Load states' rows brought to triangular form, each run's constant offset eliminated exactly."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats
from stiffcal.estimation.triangular import Reduced, TriangularFactor
from stiffcal.identification.noise import Whitening, times
from stiffcal.identification.observation import Evaluation, Observations


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

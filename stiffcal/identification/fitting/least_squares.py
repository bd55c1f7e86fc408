"""Load states' rows brought to triangular form, each run's constant offset eliminated exactly."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from stiffcal.estimation.triangular import Reduced, TriangularFactor
from stiffcal.identification.derivatives.observation import Evaluation, Observations
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.noise.run_offsets import run_offsets


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
        states = block.states
        predicted[:, states] = block.predicted
        stack = np.empty((len(block.columns) + 1, *block.predicted.shape))
        stack[:-1] = block.columns
        stack[-1] = np.where(data.measured_mask[:, states], data.measured[:, states] - block.predicted, 0.0)
        local = whitening.subset(states)
        offsets = run_offsets(data, local, states)
        dof += int(np.count_nonzero(data.measured_mask[:, states])) - offsets.n_free
        factor.add(offsets.rows(local.apply(stack)).reshape(len(stack), -1))
    triangle = factor.whole()
    p = len(triangle) - 1
    return Reduced(triangle[:p, :p], triangle[:p, p], float(triangle[p, p] ** 2), dof, predicted)

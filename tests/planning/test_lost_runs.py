"""Designs that bear the loss of a run."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats, Integers
from stiffcal.planning.criterion import Criterion
from stiffcal.planning.design import VAGUE, best_design
from stiffcal.planning.lost_runs import MUCH_WIDER


def worst_without_one(factors: Floats, chosen: Integers) -> float:
    """Return the largest standard uncertainty where the run is lost that hurts most."""
    worst = 0.0
    for place in range(len(chosen)):
        rows = factors[np.delete(chosen, place)].reshape(-1, factors.shape[2])
        covariance = np.linalg.inv(np.eye(factors.shape[2]) / VAGUE**2 + rows.T @ rows)
        worst = max(worst, float(np.sqrt(np.diagonal(covariance).max())))
    return worst


# drawn candidates of which the plain design relies on one run for a parameter
@pytest.mark.parametrize("seed", [0, 2])
def test_no_wanted_parameter_hangs_on_one_run(seed: int) -> None:
    factors = 10.0 * np.random.default_rng(seed).normal(size=(60, 2, 3))
    factors[:, :, 2] *= 1.0 if seed == 0 else 0.15
    plain = best_design(factors, 6, Criterion.WORST, limit=2)
    bearing = best_design(factors, 6, Criterion.WORST, limit=2, bears_losses=True)
    assert worst_without_one(factors, plain.chosen) > 1.45 * plain.loss
    assert worst_without_one(factors, bearing.chosen) < MUCH_WIDER * 1.02 * plain.loss
    # 5 % in variance is the most that it costs
    assert bearing.loss < 1.026 * plain.loss

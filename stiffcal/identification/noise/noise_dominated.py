"""Parameters that only the force sensor's noise turns.

A load that leaves a joint alone still reads a little torque about it: noise times the lever. A fit takes that reading
for a load, finds no displacement follow it, and calls the joint stiff, with a small error bar: the classical bias of a
regressor with errors of its own. Where noise makes half of what seems to turn a parameter or more, nothing is known of
it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import ParameterColumn, free_columns
from stiffcal.identification.derivatives.observation import Observations, derivatives
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.identification.noise.weights import raw_whitening
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import ParameterRole

# The noise's share of a column's sum of squares at which the estimate is drawn half-way to zero.
NOISE_SHARE = 0.5


def noise_dominated_parameters(
    data: Observations, robot: CompliantRobot, fixed: frozenset[str], noise: Noise
) -> frozenset[str]:
    """Return the full names of parameters whose column is made of the wrench's noise.

    Parameters
    ----------
    data : the observations.
    robot : chain and effects.
    fixed : full names of parameters that are not free.
    noise : of the readings; without any of the wrench nothing is hidden in noise.
    """
    columns = [column for column in free_columns(robot, fixed) if column.role is ParameterRole.AMPLITUDE]
    if not columns or not noise.of_wrench:
        return frozenset()
    # One draw for all states: some hundred readings determine the mean square to a few per cent.
    wrench_noise = noise.of_wrenches(data)[: len(data.wrench)] * np.random.default_rng(0).standard_normal(
        data.wrench.shape
    )
    if not data.setup.moments_measured:
        wrench_noise[3:] = 0.0
    columns_as_read = _first_order(data, robot, columns)
    columns_of_noise = _first_order(replace(data, wrench=data.wrench + wrench_noise), robot, columns) - columns_as_read
    space = Projection.of(data, raw_whitening(data, noise))
    squares = [np.sum(space.rows(reading) ** 2, axis=1) for reading in (columns_as_read, columns_of_noise)]
    return frozenset(
        robot.placed[column.placed].parameter_name(column.symbol)
        for column, squared, noisy in zip(columns, squares[0], squares[1], strict=True)
        if noisy > NOISE_SHARE * squared > 0.0
    )


def _first_order(data: Observations, robot: CompliantRobot, columns: Sequence[ParameterColumn]) -> Floats:
    """Return the (p, m, n) columns on the chain as drawn."""
    return derivatives(replace(robot, deformed=False), data, columns)

"""What is known of parameters before the measurement, as rows next to those of the measurement.

A parameter x that is normal about 0 with the standard deviation σ adds (x / σ)² to the sum of squares (Gelman and
others, Bayesian Data Analysis, 2013, section 14.8). Such are the position of a payload, and the direction of gravity in
the base. What motors' torques show of the links' moments stands next to the places in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.bounded_least_squares import column_scale
from stiffcal.identification.holding_torques import moment_rows
from stiffcal.identification.least_squares import Reduced, triangular
from stiffcal.identification.observation import Observations, ParameterColumn
from stiffcal.model.composite import CompliantRobot


def prior_rows(robot: CompliantRobot, columns: Sequence[ParameterColumn], data: Observations) -> Floats:
    """Return (r, p + 1) rows of the problem ``rows[:, :p] step = rows[:, p]`` about the robot's present values.

    Parameters
    ----------
    robot : with values.
    columns : the p free parameters.
    data : its set-up states how well the place of the load is known; torques at rest weigh the links.
    """
    setup = data.setup
    present = np.array([robot.placed[column.placed].amplitude(column.symbol) for column in columns])
    rows = list(moment_rows(robot, columns, data))
    for number, column in enumerate(columns):
        placed = robot.placed[column.placed]
        sigma = setup.load_point_sigma if placed.effect.moves_load_point else placed.effect.spec(column.symbol).prior
        if sigma:
            row = np.zeros(len(columns) + 1)
            row[number] = 1.0 / sigma
            row[-1] = -present[number] / sigma
            rows.append(row)
    return np.array(rows).reshape(len(rows), len(columns) + 1)


def with_prior(
    reduced: Reduced, robot: CompliantRobot, columns: Sequence[ParameterColumn], data: Observations
) -> Reduced:
    """Return the problem with the rows of what is known before.

    The degrees of freedom grow by the parameters that the measurement determines no better than what was known.
    """
    rows = prior_rows(robot, columns, data)
    if not len(rows):
        return reduced
    p = len(columns)
    own = np.zeros((p + 1, p + 1))
    own[:p, :p], own[:p, p], own[p, p] = reduced.factor, reduced.target, np.sqrt(max(reduced.remainder, 0.0))
    triangle = triangular(np.vstack([own, rows]))
    scale = column_scale(triangle[:p, :p])
    inverse = np.linalg.pinv(triangle[:p, :p] / scale, rcond=1e-13) / scale[:, None]
    share = float(np.sum((rows[:, :p] @ inverse) ** 2))
    return replace(
        reduced,
        factor=triangle[:p, :p],
        target=triangle[:p, p],
        remainder=float(triangle[p, p] ** 2),
        dof=reduced.dof + round(share),
    )

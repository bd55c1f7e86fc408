"""What is known of a robot's parameters before the measurement, as rows next to those of the measurement.

Such are the position of a payload, and the direction of gravity in the base. What motors' torques show of the links'
moments stands next to the places in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.prior import Prior
from stiffcal.estimation.unknowns import ParameterColumn, Unknowns, amplitudes
from stiffcal.identification.derivatives.holding_torques import moment_rows
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.assembled.measured_frames import LoadPoint


def prior_rows(
    robot: CompliantRobot, columns: Sequence[ParameterColumn], unknowns: Unknowns, data: Observations
) -> Floats:
    """Return (r, p + 1) rows of the problem ``rows[:, :p] step = rows[:, p]`` about the robot's present values.

    Parameters
    ----------
    robot : with values.
    columns, unknowns : the p free parameters.
    data : its set-up states how well the place of the load is known; torques at rest weigh the links.
    """
    effects = [robot.placed[column.placed].effect for column in columns]
    of_load = np.array([isinstance(effect, LoadPoint) for effect in effects], dtype=np.bool_)
    stated = data.setup.load_point_sigma or np.inf
    prior = Prior.independent(np.where(of_load, stated, unknowns.prior))
    rows = [*moment_rows(robot, columns, data), *prior.rows(amplitudes(robot, columns))]
    return np.array(rows).reshape(len(rows), len(columns) + 1)

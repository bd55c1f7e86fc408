"""Clamped runs on the page for a browser: the angle of the moved motor, measured and left, state by state."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.identify import predict_observations
from stiffcal.identification.readings.observations import observe
from stiffcal.identification.readings.row_layout import MOTOR
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.model.assembled.composite import CompliantRobot


def motor_states(robot: CompliantRobot, states: LoadStates) -> tuple[Floats, Floats]:
    """Return what the moved motor had to turn, and what the model leaves of it: (n, 3) rad each.

    The first column is the angle at the joint's side, the others are zero, so that lengths and rms are those of the
    angle; NaN where none was read. Each run carries a free offset, as in the fit.

    Parameters
    ----------
    robot : with the values of a fit. states : n load states.
    """
    data = observe(states, robot.chain)
    motors = data.kind == MOTOR
    read = data.measured_mask[motors]
    predicted = predict_observations(robot, data)[motors]
    measured = np.where(read, data.measured[motors], 0.0).sum(axis=0)
    left = measured - np.where(read, predicted, 0.0).sum(axis=0)
    known = read.any(axis=0)
    for members in members_of(data.run):
        chosen = members[known[members]]
        if len(chosen):
            left[chosen] -= left[chosen].mean()
    result = np.full((2, len(states), 3), np.nan)
    result[:, data.index[known]] = 0.0
    result[0, data.index[known], 0] = measured[known]
    result[1, data.index[known], 0] = left[known]
    return result[0], result[1]


def moved_torque(robot: CompliantRobot, states: LoadStates, torque: Floats) -> Floats:
    """Return the torque on the joint whose motor moved, (n,) N·m; NaN where no motor was read.

    Parameters
    ----------
    robot : the robot. states : n load states.
    torque : (n, J) N·m, of the loads about the joints.
    """
    data = observe(states, robot.chain)
    read = data.measured_mask[data.kind == MOTOR]
    result = np.full(len(states), np.nan)
    if len(read):
        known = read.any(axis=0)
        at = data.index[known]
        result[at] = torque[at, read.argmax(axis=0)[known]]
    return result

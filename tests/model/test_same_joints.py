"""Balances at the same joint angles, one sought from the other, are those found from the start."""

from __future__ import annotations

import numpy as np

from stiffcal.model.balance.equilibrium import RobotAtJoints, solve_balance
from stiffcal.model.balance.rest import TOLERANCE
from tests.laboratory.robots import force_sensor_setup, six_axes, six_axis_joints
from tests.laboratory.simulated_states import medium_robot


def test_each_is_the_balance_under_its_own_load() -> None:
    chain, rng = six_axes(), np.random.default_rng(2)
    robot, setup = medium_robot(), force_sensor_setup(chain, 12.0, (0.01, -0.02, 0.09))
    angles = chain.model_angles(six_axis_joints(rng, 20))
    standing = RobotAtJoints(robot, angles, setup, keep=True)
    for _ in range(3):
        load = rng.normal(size=(20, 6)) * np.repeat([300.0, 40.0], 3)
        found, alone = standing.under(load), solve_balance(robot, angles, load, setup)
        # both iterations end within the tolerance
        for own, other in ((found.nodes, alone.nodes), (found.displacement, alone.displacement)):
            np.testing.assert_allclose(own, other, rtol=0.0, atol=20 * TOLERANCE)
        np.testing.assert_array_equal(found.unloaded_position, alone.unloaded_position)

"""joint-eccentricity: θ = q + a cos mq + b sin mq."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.joint_eccentricity import JointEccentricity
from stiffcal.model.effect import RZ, Inputs, Place
from tests.laboratory.absolute_places import absolute_states, place_setup
from tests.laboratory.effect_bench import loads, robot_chain

EFFECT = JointEccentricity()
PLACE = Place("joints", (4,))


def test_law() -> None:
    angles = np.random.default_rng(3).uniform(-3.0, 3.0, (6, 7))
    inputs = Inputs(angles, np.zeros((6, 7)), place_setup(robot_chain()))
    moved = EFFECT.adjusted(PLACE, inputs, {"a": 2e-4, "b": -1e-4, "order": 2.0}).angles
    expected = angles.copy()
    expected[3] += 2e-4 * np.cos(2.0 * angles[3]) - 1e-4 * np.sin(2.0 * angles[3])
    np.testing.assert_allclose(moved, expected, atol=1e-16)


def test_encoders_orders_and_the_gears_own_where_three_poses_fall_into_a_period() -> None:
    chain = robot_chain()
    few = loads({(0, 0): np.zeros(20)}, angles=np.tile(np.linspace(-1.0, 1.0, 20), (6, 1)))
    assert EFFECT.nonlinear_grid(PLACE, chain, few)["order"].tolist() == [1, 2]
    dense = loads({(0, 0): np.zeros(2000)}, angles=np.tile(np.linspace(-3.1, 3.1, 2000), (6, 1)))
    assert EFFECT.nonlinear_grid(PLACE, chain, dense)["order"].tolist() == [1, 2, 80]


def test_a_sine_needs_four_poses() -> None:
    chain = robot_chain()
    assert EFFECT.lacking(chain, absolute_states(chain, 3, 1)) is not None
    assert EFFECT.lacking(chain, absolute_states(chain, 4, 1)) is None


def test_the_covariate_is_the_joints_angle() -> None:
    carried = loads({(0, RZ): [0.0]}, angles=np.full((6, 1), 0.3))
    assert EFFECT.covariate(PLACE, robot_chain(), carried).value.tolist() == [0.3]

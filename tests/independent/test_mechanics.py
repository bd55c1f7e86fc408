"""Frames, Jacobians and weights of the undeformed chain against pinocchio."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, body_poses, jacobians
from stiffcal.model.balance.deformed_chain import deformed_chain, node_wrenches
from stiffcal.model.effect import RZ, Inputs
from tests.laboratory.pinocchio_robot import gravity_torques, pinocchio_model, place_and_jacobian
from tests.laboratory.robots import force_sensor_setup, seven_axes, shifted, six_axes, turned

EXACT = 1e-12
OFF = turned(turned(shifted(0.3, -0.2, 0.5), 0, 0.8), 2, -1.1)


@pytest.fixture(params=["six", "seven"])
def chain(request: pytest.FixtureRequest) -> Chain:
    return six_axes() if request.param == "six" else seven_axes()


def angles_of(chain: Chain, n: int = 20) -> Floats:
    return np.random.default_rng(11).uniform(-np.pi, np.pi, (n, chain.n_joints))


def test_every_body(chain: Chain) -> None:
    model, angles = pinocchio_model(chain), angles_of(chain)
    positions, rotations = body_poses(chain, angles)
    for i, q in enumerate(angles):
        for body in range(chain.n_joints + 2):
            position, rotation, _ = place_and_jacobian(model, chain, q, Attachment(body, np.eye(4)))
            np.testing.assert_allclose(positions[i, body], position, atol=EXACT)
            np.testing.assert_allclose(rotations[i, body], rotation, atol=EXACT)


def test_jacobians_to_a_point_on_every_body(chain: Chain) -> None:
    model, angles = pinocchio_model(chain), angles_of(chain)
    for body in range(1, chain.n_joints + 2):
        ours = jacobians(chain, angles, Attachment(body, OFF))
        at, turn = attached_poses(chain, angles, Attachment(body, OFF))
        for i, q in enumerate(angles):
            position, rotation, jacobian = place_and_jacobian(model, chain, q, Attachment(body, OFF))
            np.testing.assert_allclose(ours[i], jacobian, atol=EXACT)
            np.testing.assert_allclose(at[i], position, atol=EXACT)
            np.testing.assert_allclose(turn[i], rotation, atol=EXACT)


def test_weights_and_loads_turn_the_joints(chain: Chain) -> None:
    """Moments about the joint axes: pinocchio's gravity terms (negative), and Jᵀ times the wrench at the sensor."""
    model, angles = pinocchio_model(chain, 12.0, np.array([0.1, -0.2, 0.3])), angles_of(chain)
    setup = force_sensor_setup(chain, 12.0, (0.1, -0.2, 0.3))
    wrench = np.random.default_rng(12).normal(size=(6, len(angles))) * 100.0
    stack = np.ascontiguousarray(angles.T)
    carried = node_wrenches(chain, deformed_chain(chain, stack, None), Inputs(stack, wrench, setup))
    about_axes = carried[1 : 2 * chain.n_joints : 2, RZ].T
    for i, q in enumerate(angles):
        _, rotation, jacobian = place_and_jacobian(model, chain, q, setup.wrench_point)
        load = jacobian.T @ np.concatenate([rotation @ wrench[:3, i], rotation @ wrench[3:, i]])
        np.testing.assert_allclose(about_axes[i], load - gravity_torques(model, q), atol=1e-9)


def test_the_engine_is_the_one_meant() -> None:
    """A known place: the medium robot's flange at zero angles, by hand from its Denavit-Hartenberg rows."""
    chain = six_axes()
    model: Any = pinocchio_model(chain)
    position, _, _ = place_and_jacobian(model, chain, chain.offset, Attachment(7, np.eye(4)))
    np.testing.assert_allclose(position, [0.2 + 0.89 + 0.88 + 0.14, 0.0, 0.68 + 0.15], atol=EXACT)

"""Cartesian stiffness with and without complementary stiffness, against the papers (003, eq. 29; 002, eq. 2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.compensation.prediction import predict_states
from stiffcal.compensation.targets import PoseGoal, correct_joints, pose_error
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.dual_balance import complementary_stiffness, reading_as_load, weights_of
from stiffcal.mechanics.dual_quaternions import dual_chain
from stiffcal.mechanics.kinematics import jacobians
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.balance.equilibrium import solve_balance
from tests.compensation.test_targets import six
from tests.laboratory.robots import SIX_STIFFNESS


def test_with_complementary_stiffness_it_is_j_over_k_less_k_c() -> None:
    robot, setup, joints, wrench = six(6)
    chain = robot.chain
    in_base = replace(setup, wrench_axes=Attachment(0, np.eye(4)), wrench_point=setup.targets[0])
    found = predict_states(robot, joints, wrench, in_base)
    angles = chain.model_angles(joints)
    balance = solve_balance(robot, angles, wrench, in_base)
    rest = angles + balance.joint_torque / SIX_STIFFNESS
    loads = [reading_as_load(in_base, wrench), *weights_of(chain, in_base, len(rest))]
    stiffness = np.diag(SIX_STIFFNESS) - complementary_stiffness(dual_chain(chain, rest), loads)
    jacobian = jacobians(chain, rest, setup.targets[0])
    expected = jacobian @ np.linalg.inv(stiffness) @ np.swapaxes(jacobian, 1, 2)
    size = np.sqrt(np.einsum("nii->ni", expected))
    share = np.abs(found.cartesian_compliance - expected) / (size[:, :, None] * size[:, None, :])
    # A deflection's rotation vector grows by a step's turn but for half the product of the two: milliradians of it.
    assert share.max() < 1e-2
    assert share[:, :3, :3].max() < 1e-4
    # the papers' difference is there and is seen
    linear = np.abs(found.linear_compliance - expected) / (size[:, :, None] * size[:, None, :])
    assert linear[:, :3, :3].max() > 5e-3


def test_without_it_is_that_of_the_rigid_chain() -> None:
    robot, setup, joints, wrench = six(6)
    chain = robot.chain
    found = predict_states(robot, joints, wrench, setup)
    jacobian = jacobians(chain, chain.model_angles(joints), setup.targets[0])
    expected = jacobian @ np.diag(1.0 / SIX_STIFFNESS) @ np.swapaxes(jacobian, 1, 2)
    assert np.allclose(found.linear_compliance, expected, atol=1e-9 * np.abs(expected).max())
    for stiffness, compliance in zip(found.linear_stiffness, expected, strict=True):
        assert stiffness is not None
        assert np.allclose(stiffness @ compliance, np.eye(6), atol=1e-6)


def test_pose_errors_do_not_mind_half_turns() -> None:
    """A goal turned by nearly half a turn about any axis: no singular orientation, no jump."""
    turn = rotation_from_vector(np.array([[0.0, 0.0, np.pi - 1e-9], [np.pi - 1e-9, 0.0, 0.0], [0.0, np.pi / 2, 0.0]]))
    small = rotation_from_vector(np.array([[1e-3, -2e-3, 5e-4]] * 3))
    place = np.array([[1.0, 2.0, 3.0]] * 3)
    error = pose_error(place + 1e-3, small @ turn, PoseGoal(place, turn))
    assert np.allclose(error, [[1e-3, 1e-3, 1e-3, 1e-3, -2e-3, 5e-4]] * 3, atol=1e-12)


def test_corrected_joints_take_the_papers_error_to_nothing() -> None:
    robot, setup, joints, wrench = six(3)
    found = correct_joints(robot, joints, wrench, setup)
    assert np.abs(found.after).max() < 1e-9

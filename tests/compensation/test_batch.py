"""The batch form: the papers' sum, against the linear balance and the solved correction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.compensation.batch import LinearCompensation
from stiffcal.compensation.targets import correct_joints
from stiffcal.measurements.load_states import Attachment
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance
from tests.compensation.test_step import everything_linear, placed, samples, springs_36
from tests.laboratory.robots import force_sensor_setup


@pytest.mark.parametrize("make", [springs_36, everything_linear])
@pytest.mark.parametrize("moments", [True, False])
def test_the_sum_is_the_linear_balance(make: object, moments: bool) -> None:
    robot: CompliantRobot = make()  # type: ignore[operator]
    setup = replace(force_sensor_setup(robot.chain, 10.0), moments_measured=moments)
    joints, wrench = samples(robot, setup)
    linear = replace(robot, deformed=False)
    exact = solve_balance(linear, robot.chain.model_angles(joints), wrench, setup).displacement[:, 0]
    assert np.allclose(LinearCompensation(robot, setup).deflection(joints, wrench), exact, atol=1e-14)


def test_a_target_and_a_load_on_inner_bodies() -> None:
    robot = springs_36()
    inner = Attachment(4, np.eye(4))
    setup = replace(force_sensor_setup(robot.chain), wrench_axes=inner, wrench_point=inner, targets=(inner,))
    joints, wrench = samples(robot, setup, 3)
    linear = replace(robot, deformed=False)
    exact = solve_balance(linear, robot.chain.model_angles(joints), wrench, setup).displacement[:, 0]
    assert np.allclose(LinearCompensation(robot, setup).deflection(joints, wrench), exact, atol=1e-14)


@pytest.mark.parametrize("make", [springs_36, everything_linear])
def test_offsets_take_most_of_the_deflection_back(make: object) -> None:
    robot: CompliantRobot = make()  # type: ignore[operator]
    setup = force_sensor_setup(robot.chain, 10.0)
    joints, wrench = samples(robot, setup)
    offsets = LinearCompensation(robot, setup).correction(joints, wrench)
    exact = correct_joints(robot, joints, wrench, setup)
    at = solve_balance(robot, robot.chain.model_angles(joints + offsets), wrench, setup)
    unloaded = solve_balance(robot, robot.chain.model_angles(joints), wrench, setup).unloaded_position
    left = np.linalg.norm(at.target_position - unloaded, axis=2)[:, 0]
    assert np.all(left < 0.05 * np.linalg.norm(exact.deflection[:, :3], axis=1))


def test_what_is_not_linear_is_refused() -> None:
    from stiffcal.model.effect import Place

    robot = springs_36()
    curve = placed("cubic-stiffness", Place("joints", (2,)), {"c2": 0.0, "c3": 1e-15})
    robot = replace(robot, placed=(*robot.placed, curve))
    with pytest.raises(ValueError, match="cubic-stiffness at j2"):
        LinearCompensation(robot, force_sensor_setup(robot.chain))

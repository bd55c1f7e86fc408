"""The outside judge is judged first: MuJoCo's balance against closed forms and against minimal energy."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment
from tests.laboratory.mujoco_robot import MujocoRobot, Settled, Spring
from tests.laboratory.robots import (
    SIX_STIFFNESS,
    chain_from_rows,
    force_sensor_setup,
    shifted,
    six_axes,
    six_axis_joints,
)

# One joint with a horizontal axis, a 20 kg link of 0.8 m whose weight acts half-way, load and target at its end.
PENDULUM = chain_from_rows("pendulum", ((0.0, 90.0, 0.0, 0.0, 20.0, (0.4, 0.0, 0.0)),), shifted(0.8, 0.0, 0.0))
SPRING = 9000.0


def test_force_that_turns_with_the_robot_has_a_constant_lever() -> None:
    tip = Attachment(2, np.eye(4))
    setup = replace(force_sensor_setup(PENDULUM), wrench_axes=tip, wrench_point=tip, targets=(tip,))
    robot = MujocoRobot(PENDULUM, np.array([SPRING]), setup, weights=False)
    settled = robot.settle(np.array([[0.3]]), np.array([[50.0, 400.0, 30.0, 1.0, 2.0, 3.0]]))
    assert settled.turned[0, 0] == pytest.approx((400.0 * 0.8 + 3.0) / SPRING, rel=1e-12)


def test_pendulum_under_weight_and_a_force_in_base_axes() -> None:
    tip, ground = Attachment(2, np.eye(4)), Attachment(0, np.eye(4))
    setup = replace(force_sensor_setup(PENDULUM), wrench_axes=ground, wrench_point=tip, targets=(tip,))
    robot = MujocoRobot(PENDULUM, np.array([SPRING]), setup)
    settled = robot.settle(np.array([[0.3]]), np.array([[150.0, 10.0, -300.0, 0.0, 0.0, 0.0]]))

    def torque(turn: float) -> float:  # about the axis (0, -1, 0), which lifts the link
        c, s = np.cos(0.3 + turn), np.sin(0.3 + turn)
        return float(-20.0 * 9.81 * 0.4 * c + 0.8 * (-300.0 * c - 150.0 * s) - SPRING * turn)

    turn = brentq(torque, -0.5, 0.5, xtol=1e-15, rtol=1e-14)
    assert settled.turned[0, 0] == pytest.approx(turn, abs=1e-13)
    expected = [0.8 * np.cos(0.3 + turn), 0.0, 0.8 * np.sin(0.3 + turn)]
    np.testing.assert_allclose(settled.position[0, 0], expected, atol=1e-13)


def test_six_joints_rest_where_their_energy_is_least() -> None:
    """The potential from MuJoCo's own energy, less the work of a dead force: its gradient vanishes at the balance."""
    chain = six_axes()
    setup = force_sensor_setup(chain, 12.0, (0.02, -0.01, 0.09))
    setup = replace(setup, wrench_axes=Attachment(0, np.eye(4)))
    robot = MujocoRobot(chain, SIX_STIFFNESS, setup)
    joints = chain.model_angles(six_axis_joints(np.random.default_rng(3), 4))
    force = np.array([300.0, -500.0, 400.0])
    for angles in joints:
        settled = robot.settle(angles[None], np.concatenate([force, np.zeros(3)])[None])
        step = 1e-4
        above = np.array([_energy(robot, angles, settled, force, k, step) for k in range(6)])
        below = np.array([_energy(robot, angles, settled, force, k, -step) for k in range(6)])
        slope = (above - below) / (2 * step)
        np.testing.assert_allclose(slope / SIX_STIFFNESS, 0.0, atol=1e-10)


def _energy(robot: MujocoRobot, angles: Floats, settled: Settled, force: Floats, joint: int, step: float) -> float:
    """Potential with one joint moved away from the balance: springs by hand, heights and load point from sites."""
    import mujoco

    data: Any = robot.data
    turned = settled.turned[0].copy()
    turned[joint] += step
    data.qpos[:] = angles + turned
    mujoco.mj_kinematics(robot.model, data)
    weight = 9.81 * float(robot.model.body_mass @ data.xipos[:, 2])
    load = -float(force @ data.site_xpos[robot.model.site("wrench_point").id])
    return 0.5 * float(SIX_STIFFNESS @ turned**2) + weight + load


def test_ball_spring_turns_about_the_moment() -> None:
    """A foundation alike in all directions turns by moment / stiffness about the moment's own axis."""
    tip, ground = Attachment(2, np.eye(4)), Attachment(0, np.eye(4))
    setup = replace(force_sensor_setup(PENDULUM), wrench_axes=ground, wrench_point=tip, targets=(tip,))
    robot = MujocoRobot(PENDULUM, np.array([1e14]), setup, (Spring(0, "ball", 2000.0),), weights=False)
    moment = np.array([3.0, -4.0, 12.0])
    settled = robot.settle(np.zeros((1, 1)), np.concatenate([np.zeros(3), moment])[None])
    start = MujocoRobot(PENDULUM, np.array([1e14]), setup, weights=False).settle(np.zeros((1, 1)), np.zeros((1, 6)))
    turn = settled.rotation[0, 0] @ start.rotation[0, 0].T
    angle, axis = 13.0 / 2000.0, moment / 13.0
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    expected = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    np.testing.assert_allclose(turn, expected, atol=1e-12)


def test_springs_along_and_across() -> None:
    """A slide gives force / stiffness along its axis; a tilt hinge about its own, at its own place."""
    tip = Attachment(2, np.eye(4))
    setup = replace(force_sensor_setup(PENDULUM), wrench_axes=tip, wrench_point=tip, targets=(tip,))
    springs = (
        Spring(2, "slide", 1e6, axis=(0.0, 0.0, 1.0)),
        Spring(1, "turn", 5000.0, axis=(0.0, 1.0, 0.0), origin=(0.2, 0.0, 0.0)),
    )
    robot = MujocoRobot(PENDULUM, np.array([1e14]), setup, springs, weights=False)
    settled = robot.settle(np.zeros((1, 1)), np.array([[0.0, 0.0, -200.0, 0.0, 0.0, 0.0]]))
    turn = 0.6 * 200.0 / 5000.0  # a force of -z at lever 0.6 m along x turns about +y
    lowered = 200.0 / 1e6
    expected_x = 0.2 + 0.6 * np.cos(turn) - lowered * np.sin(turn)
    expected_y = 0.6 * np.sin(turn) + lowered * np.cos(turn)  # the link's z axis is -y of the base
    np.testing.assert_allclose(settled.position[0, 0], [expected_x, expected_y, 0.0], atol=1e-12)

"""MuJoCo along a path against closed forms: friction, stops, dampers, curved springs, cables; then whole robots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place, StateOrder
from tests.independent.test_mujoco_robot import PENDULUM
from tests.laboratory.mujoco_path import STOP_SOFTNESS, MujocoPath
from tests.laboratory.mujoco_robot import Cable, MujocoRobot, Spring
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axes, six_axis_joints
from tests.laboratory.simulated_states import cycles_of, joint_springs

DRIVE = 9000.0
TIP = Attachment(2, np.eye(4))
SETUP = replace(force_sensor_setup(PENDULUM), wrench_axes=TIP, wrench_point=TIP, targets=(TIP,))


def about_the_joint(torque: Floats) -> Floats:
    """Return wrenches (n, 6) that put a torque on the pendulum's joint, whatever its angle."""
    wrench = np.zeros((len(torque), 6))
    wrench[:, 5] = torque
    return wrench


def path_of(torque: Floats, *springs: Spring, time: Floats | None = None, ramp: int = 4) -> Floats:
    """Return (n,) how far the weightless pendulum's end has turned about its joint."""
    robot = MujocoRobot(PENDULUM, np.array([DRIVE]), SETUP, springs, weights=False)
    n = len(torque)
    settled = MujocoPath(robot, ramp).walk(np.zeros((n, 1)), about_the_joint(torque), np.zeros(n, dtype=np.int64), time)
    place = settled.position[:, 0]
    return np.asarray(np.arctan2(place[:, 2], place[:, 0]))


def test_friction_next_to_a_spring_is_a_play() -> None:
    """The slider stays until the torque is its friction ahead: loading and unloading by hand, for any step size."""
    slider = Spring(1, "turn", 5000.0, friction=40.0)
    torque = np.array([0.0, 30.0, 100.0, 60.0, 20.0, 0.0, -100.0, -30.0, 0.0, 100.0, 0.0])
    behind = np.array([0.0, 0.0, 60.0, 60.0, 60.0, 40.0, -60.0, -60.0, -40.0, 60.0, 40.0])
    for ramp in (1, 7):
        turned = path_of(torque, slider, ramp=ramp)
        np.testing.assert_allclose(turned, torque / DRIVE + behind / 5000.0, atol=1e-12)


def test_stops_end_a_soft_spring() -> None:
    """Between its stops the soft spring gives, beyond them next to nothing."""
    stopped = Spring(1, "turn", 3000.0, reach=0.01)
    torque = np.array([0.0, 12.0, 100.0, 20.0, -200.0, 0.0])
    turned = path_of(torque, stopped)
    free = np.clip(torque, -30.0, 30.0)
    soft = free + STOP_SOFTNESS * (torque - free)
    np.testing.assert_allclose(turned, torque / DRIVE + soft / 3000.0, atol=1e-10)


def test_a_damper_lets_its_spring_come_slowly() -> None:
    """A load that rises evenly through 10 s and is then held: the exact answer of a spring and damper side by side."""
    slow = Spring(1, "turn", 6000.0, time=20.0)
    time = np.array([0.0, 10.0, 20.0, 60.0, 200.0])
    torque = np.array([0.0, 90.0, 90.0, 90.0, 90.0])
    turned = path_of(torque, slow, time=time)
    risen = 90.0 / 10.0 * (10.0 - 20.0 * (1.0 - np.exp(-10.0 / 20.0)))
    held = np.concatenate([[0.0], 90.0 - (90.0 - risen) * np.exp(-(time[1:] - 10.0) / 20.0)])
    np.testing.assert_allclose(turned, torque / DRIVE + held / 6000.0, atol=0.005 * 90.0 / 6000.0)


def test_a_curved_spring() -> None:
    robot = MujocoRobot(PENDULUM, np.array([DRIVE]), SETUP, (Spring(1, "turn", 4000.0, cubic=3e6),), weights=False)
    settled = robot.settle(np.zeros((1, 1)), about_the_joint(np.array([150.0])))
    curved = brentq(lambda angle: 4000.0 * angle + 3e6 * angle**3 - 150.0, 0.0, 0.1, xtol=1e-15)
    place = settled.position[0, 0]
    assert np.arctan2(place[2], place[0]) == pytest.approx(150.0 / DRIVE + curved, abs=1e-12)


def test_a_cable_pulls_only_when_taut() -> None:
    """A cable from the ground to the pendulum's end: slack while the end lowers towards the anchor, a spring beyond."""
    ground = Attachment(0, np.eye(4))
    setup = replace(SETUP, wrench_axes=ground)
    cable = Cable(2e4, ends=((0, (0.8, 0.0, -0.5)), (2, (0.0, 0.0, 0.0))), slack=0.5)
    robot = MujocoRobot(PENDULUM, np.array([DRIVE]), setup, weights=False, cables=(cable,))
    load = np.zeros((2, 6))
    load[:, 2] = -300.0, 300.0
    down, up = robot.settle(np.zeros((2, 1)), load).turned[:, 0]

    def torque(turn: float) -> float:
        c, s = np.cos(turn), np.sin(turn)
        away = np.array([0.8 * c - 0.8, 0.8 * s + 0.5])
        length = np.hypot(*away)
        pull = -2e4 * max(length - 0.5, 0.0) * away / length
        return float(0.8 * (c * (np.sign(turn) * 300.0 + pull[1]) - s * pull[0]) - DRIVE * turn)

    assert down == pytest.approx(brentq(torque, -0.3, -1e-6, xtol=1e-15), abs=1e-12)
    assert up == pytest.approx(brentq(torque, 1e-6, 0.3, xtol=1e-15), abs=1e-12)
    assert abs(up) < 0.5 * abs(down)


def test_what_depends_on_the_path_is_not_settled_without_one() -> None:
    robot = MujocoRobot(PENDULUM, np.array([DRIVE]), SETUP, (Spring(1, "turn", 5000.0, friction=40.0),))
    with pytest.raises(ValueError, match="walk it"):
        robot.settle(np.zeros((1, 1)), np.zeros((1, 6)))


@pytest.mark.parametrize("joint", [1, 2, 3, 5])
def test_six_joints_with_friction_are_the_balance(joint: int) -> None:
    """Weight first, then three load cycles: MuJoCo's frictional loss is the law of friction-hysteresis to 0.1 µm."""
    chain, setup = six_axes(), force_sensor_setup(six_axes(), 12.0, (0.01, -0.02, 0.09))
    rng = np.random.default_rng(joint)
    wrench = np.concatenate([cycles_of(np.linalg.qr(rng.normal(size=(3, 3)))[0], cycles=1) for _ in range(2)])
    run = np.repeat([0, 1], len(wrench) // 2)
    joints = chain.model_angles(six_axis_joints(rng, 2)[run])
    softness = 0.4 / SIX_STIFFNESS[joint - 1]
    slider = Spring(joint, "turn", 1.0 / softness, friction=70.0)
    outside = MujocoPath(MujocoRobot(chain, SIX_STIFFNESS, setup, (slider,))).walk(joints, wrench, run)
    law = PlacedEffect(find_effects()["friction-hysteresis"], Place("joints", (joint,)), {"c": softness, "slip": 70.0})
    robot = CompliantRobot(chain, (*joint_springs(chain, SIX_STIFFNESS).placed, law))
    n = len(run)
    time, unknown = np.arange(n, dtype=np.float64), np.full(n, np.nan)
    order = StateOrder(run, time, unknown, np.zeros((6, n)), unknown, time, np.arange(1, n + 1))
    balance = solve_balance(robot, joints, wrench, setup, order)
    np.testing.assert_allclose(outside.position, balance.target_position, atol=1e-7)
    assert np.abs(balance.displacement[:, 0, :3]).max() > 3e-4

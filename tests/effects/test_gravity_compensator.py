"""gravity-compensator: torque from the spring's geometry, its slope as added stiffness."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.effects.gravity_compensator import GravityCompensator
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import body_poses
from stiffcal.model.effect import Effect, Place
from tests.laboratory.effect_bench import bare_states, robot_chain, settled

EFFECT = GravityCompensator()
PLACE = Place("joints", (2,))
ANCHOR, ARM = [0.05, 0.1, 0.15], [0.12, -0.35, 0.08]
CHAIN = replace(
    robot_chain(),
    compensator={"joint": 2, "anchor_m": ANCHOR, "arm_m": ARM, "rate_N_m": 1e5, "preload_N": 2000.0},
)


def torque(angles: Floats, rate: float = 1e5) -> Floats:
    spring = EFFECT.balancing_spring(PLACE, CHAIN, {"rate": rate})
    assert spring is not None
    assert spring.joint == PLACE.joints[0]
    return spring.torque(angles)


def length(angle: float) -> float:
    """The spring's length by forward kinematics."""
    joints = np.zeros((1, 6))
    joints[0, 1] = angle
    position, rotation = body_poses(CHAIN, joints)
    anchor = position[0, 1] + rotation[0, 1] @ ANCHOR
    return float(np.linalg.norm(position[0, 2] + rotation[0, 2] @ ARM - anchor))


def test_torque_is_minus_the_slope_of_the_springs_energy() -> None:
    natural = length(0.0) - 2000.0 / 1e5
    for angle in (-1.2, -0.3, 0.0, 0.8):
        step = 1e-5
        energy = [0.5 * 1e5 * (length(angle + s) - natural) ** 2 for s in (-step, step)]
        np.testing.assert_allclose(torque(np.array([angle]))[0], -(energy[1] - energy[0]) / (2 * step), rtol=1e-7)


def test_preload_at_the_joints_zero() -> None:
    slope = (length(1e-6) - length(-1e-6)) / 2e-6
    np.testing.assert_allclose(torque(np.zeros(1))[0], -2000.0 * slope, rtol=1e-6)


def test_proportional_to_the_rate_and_nothing_without() -> None:
    angles = np.array([0.3, -0.7])
    np.testing.assert_allclose(torque(angles, 3e5), 3.0 * torque(angles), rtol=1e-12)
    assert EFFECT.balancing_spring(PLACE, CHAIN, {}) is None


def test_slope_adds_to_the_joints_stiffness() -> None:
    """Under a small load the joint gives by Δτ / (k − ∂τ_s/∂q − what weight does), the last seen without spring."""
    joints = CHAIN.model_angles(np.array([[0.0, -0.9, 0.3, 0.0, 0.2, 0.0]]))
    wrench = np.array([[0.0, 0.0, 0.0, 30.0, 20.0, 10.0]])
    spring = (JointCompliance(), PLACE, {"c": 1e-6})
    without = replace(CHAIN, compensator=None)
    alone = settled([spring], joints, wrench, chain=without).displacement[0, 0, 3:]
    both = settled([spring, (EFFECT, PLACE, {"rate": 1e6})], joints, wrench, chain=CHAIN).displacement[0, 0, 3:]
    around = joints[0, 1] + np.array([-1e-4, 1e-4])
    added = -float(np.diff(torque(around, 1e6))[0]) / 2e-4
    assert abs(added) > 1e4  # a few per cent of the drive's 1e6 N·m/rad
    np.testing.assert_allclose(np.linalg.norm(alone) / np.linalg.norm(both), 1.0 + added * 1e-6, rtol=5e-3)


def test_only_where_the_geometry_is_known() -> None:
    assert EFFECT.places(CHAIN) == [PLACE]
    assert EFFECT.places(robot_chain()) == []
    assert "geometry" in str(EFFECT.lacking(robot_chain(), bare_states([0])))
    assert EFFECT.lacking(CHAIN, bare_states([0])) is None


def test_a_stated_rate_counts_without_the_effect() -> None:
    """With a value the effect takes its place: the same rate is the same robot, and 0 is none."""
    joints = CHAIN.model_angles(np.array([[0.0, -0.9, 0.3, 0.0, 0.2, 0.0]]))
    give = (JointCompliance(), PLACE, {"c": 2e-6})
    none = np.zeros((1, 6))

    def place_of(chain: Chain, *more: tuple[Effect, Place, dict[str, float]]) -> Floats:
        return np.asarray(settled([give, *more], joints, none, chain=chain).target_position)

    bare = place_of(replace(CHAIN, compensator=None))
    stated = place_of(CHAIN)
    assert np.linalg.norm(stated - bare) > 1e-3  # 2 kN at a third of a metre on 5e5 N·m/rad
    np.testing.assert_array_equal(place_of(CHAIN, (EFFECT, PLACE, {})), stated)
    np.testing.assert_allclose(place_of(CHAIN, (EFFECT, PLACE, {"rate": 1e5})), stated, atol=1e-12)
    np.testing.assert_allclose(place_of(CHAIN, (EFFECT, PLACE, {"rate": 0.0})), bare, atol=1e-12)
    # of links whose masses are not known the weight that it balances is not there either
    unknown = replace(CHAIN, masses_known=False)
    np.testing.assert_allclose(place_of(unknown), bare, atol=1e-12)
    assert EFFECT.at(PLACE, unknown).spec("rate").neutral == 0.0


def test_the_rate_is_counted_from_the_stated_one() -> None:
    spec = EFFECT.at(PLACE, CHAIN).spec("rate")
    assert spec.amplitude_of(1e5) == 0.0
    assert spec.value_of(-2e4) == 8e4
    assert EFFECT.spec("rate").neutral == 0.0  # that of all other robots

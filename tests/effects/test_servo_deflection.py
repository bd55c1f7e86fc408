"""servo-deflection: the joints turn by what the motors' encoders show, with no free parameter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.servo_deflection import ServoDeflection
from stiffcal.model.effect import RZ, Place, joint_node
from tests.laboratory.effect_bench import bare_states, displacement, loads, nonzero, order_of, robot_chain, settled

EFFECT = ServoDeflection()


def test_the_joint_turns_as_the_motor_did() -> None:
    motor = np.zeros((6, 3))
    motor[2] = [0.0, 1e-4, -2e-4]
    node = joint_node(3)
    carried = loads({(node, RZ): [0.0, 100.0, 50.0]}, order_of([0, 0, 0], motor=motor))
    moved = displacement(EFFECT, Place("joints", (3,)), {}, carried)
    np.testing.assert_array_equal(moved[node, RZ], motor[2])
    assert nonzero(moved) == {(node, RZ)}


def test_nothing_in_the_weight_only_state() -> None:
    assert EFFECT.terms(Place("joints", (3,)), robot_chain(), loads({(0, 0): [1.0]}), {}) == ()


def test_moves_the_target_as_turned_joints_do() -> None:
    rng = np.random.default_rng(9)
    chain = robot_chain()
    joints = chain.model_angles(rng.uniform(-1, 1, (1, 6)).repeat(3, axis=0))
    motor = np.zeros((6, 3))
    motor[:, 1:] = rng.normal(0.0, 3e-4, (6, 2))
    none: dict[str, float] = {}
    places = [(EFFECT, Place("joints", (k,)), none) for k in range(1, 7)]
    order = order_of([0, 0, 0], motor=motor)
    found = settled(places, joints, np.zeros((3, 6)), order=order)
    turned = settled([], joints + motor.T, np.zeros((3, 6)))
    np.testing.assert_allclose(found.target_position, turned.target_position, atol=1e-12)


def test_a_log_that_stands_still_shows_nothing() -> None:
    chain = robot_chain()
    states = bare_states([0, 0, 0, 1, 1, 1])
    assert "is constant" in str(EFFECT.lacking(chain, states))
    joints = states.joints.copy()
    joints[3:] += 0.5  # another pose is not a motor pushed off
    assert EFFECT.lacking(chain, replace(states, joints=joints)) is not None
    joints[4, 2] += 1e-4
    assert EFFECT.lacking(chain, replace(states, joints=joints)) is None

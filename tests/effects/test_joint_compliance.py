"""joint-compliance: δ_Rz = c τ, on the joint's own axis or on the drive's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.model.effect import RZ, Place, joint_node
from tests.laboratory.effect_bench import displacement, loads, nonzero, robot_chain, settled
from tests.laboratory.robots import force_sensor_setup

EFFECT = JointCompliance()


def test_turn_in_proportion_to_torque() -> None:
    moved = displacement(EFFECT, Place("joints", (3,)), {"c": 2e-6}, loads({(joint_node(3), RZ): [100.0, -50.0]}))
    np.testing.assert_allclose(moved[joint_node(3), RZ], [2e-4, -1e-4], rtol=1e-15)
    assert nonzero(moved) == {(joint_node(3), RZ)}


def test_a_parallel_rod_turns_two_joints() -> None:
    chain = robot_chain()
    coupling = np.eye(6)
    coupling[2, 1] = -1.0  # model angle 3 is logged 3 minus logged 2
    mechanical = np.zeros(6, dtype=np.bool_)
    mechanical[2] = True
    chain = replace(chain, coupling=coupling, mechanical=mechanical)
    carried = loads({(joint_node(2), RZ): [10.0], (joint_node(3), RZ): [4.0]})
    moved = displacement(EFFECT, Place("joints", (2,)), {"c": 1e-3}, carried, chain)
    # the drive of joint 2 carries τ2 − τ3 and turns joint 3 back by what it turns joint 2
    np.testing.assert_allclose(moved[joint_node(2), RZ], [6e-3])
    np.testing.assert_allclose(moved[joint_node(3), RZ], [-6e-3])


def test_base_joint_and_force_across() -> None:
    """A force of 100 N along y at the target: the turn is c F x, the target moves by the turn times its distance."""
    chain = robot_chain()
    joints = chain.model_angles(np.zeros((1, 6)))
    still = settled([], joints, np.zeros((1, 6)))
    setup = force_sensor_setup(chain)
    place = still.target_position[0, 0]
    axes = replace(setup.wrench_axes, body=0, transform=np.eye(4))
    setup = replace(setup, wrench_axes=axes, wrench_point=setup.targets[0])
    found = settled([(EFFECT, Place("joints", (1,)), {"c": 1e-6})], joints, np.array([[0, 100.0, 0, 0, 0, 0]]), setup)
    lever = np.hypot(place[0], place[1])
    turn = 1e-6 * 100.0 * place[0]
    np.testing.assert_allclose(found.displacement[0, 0, 5], turn, rtol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(found.displacement[0, 0, :3]), turn * lever, rtol=1e-5)

"""periodic-stiffness: (a cos mq + b sin mq) τ, orders from a short list."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.periodic_stiffness import PeriodicStiffness
from stiffcal.model.effect import RZ, Place, joint_node
from tests.laboratory.effect_bench import bare_states, displacement, loads, robot_chain

EFFECT = PeriodicStiffness()


def test_law() -> None:
    node, angle = joint_node(2), np.radians([0.0, 30.0, 45.0, 90.0])
    angles = np.zeros((6, 4))
    angles[1] = angle
    carried = loads({(node, RZ): np.full(4, 100.0)}, angles=angles)
    moved = displacement(EFFECT, Place("joints", (2,)), {"a": 2e-7, "b": -1e-7, "order": 2.0}, carried)[node, RZ]
    np.testing.assert_allclose(moved, 100.0 * (2e-7 * np.cos(2 * angle) - 1e-7 * np.sin(2 * angle)), atol=1e-18)


def test_the_angle_counts_from_the_joints_zero_as_shown() -> None:
    """Joint 3's model angle stands at −90° when the controller shows zero."""
    chain = robot_chain()
    node = joint_node(3)
    carried = loads({(node, RZ): [100.0]}, angles=chain.model_angles(np.zeros((1, 6))).T)
    moved = displacement(EFFECT, Place("joints", (3,)), {"a": 1e-7, "b": 1e-7, "order": 1.0}, carried, chain)
    np.testing.assert_allclose(moved[node, RZ], [1e-5])


def test_orders_one_to_four_and_the_gears_own() -> None:
    chain, carried = robot_chain(), loads({(0, 0): [1.0]})
    assert EFFECT.nonlinear_grid(Place("joints", (1,)), chain, carried)["order"].tolist() == [1, 2, 3, 4]
    assert EFFECT.nonlinear_grid(Place("joints", (4,)), chain, carried)["order"].tolist() == [1, 2, 3, 4, 80, 160]
    assert EFFECT.spec("order").discrete


def test_too_few_poses() -> None:
    chain = replace(robot_chain())
    joints = np.zeros((5, 6))
    joints[:, 1] = [0.0, 0.0, 0.3, 0.3, 0.6]
    assert "four poses" in str(EFFECT.lacking(chain, bare_states([0, 1, 2, 3, 4], joints)))
    joints[:, 1] = np.arange(5) * 0.3
    assert EFFECT.lacking(chain, bare_states([0, 1, 2, 3, 4], joints)) is None

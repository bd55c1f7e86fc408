"""axis-coupling: δ_a += c τ_b, δ_b += c τ_a."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.axis_coupling import AxisCoupling
from stiffcal.model.effect import RZ, Place, joint_node
from tests.laboratory.effect_bench import displacement, loads, nonzero

EFFECT = AxisCoupling()


def test_each_turns_by_the_torque_on_the_other() -> None:
    carried = loads({(joint_node(2), RZ): [100.0, 0.0], (joint_node(5), RZ): [0.0, -20.0]})
    moved = displacement(EFFECT, Place("pairs", (2, 5)), {"c": -1e-6}, carried)
    np.testing.assert_allclose(moved[joint_node(2), RZ], [0.0, 2e-5])
    np.testing.assert_allclose(moved[joint_node(5), RZ], [-1e-4, 0.0])
    assert nonzero(moved) == {(joint_node(2), RZ), (joint_node(5), RZ)}


def test_reciprocity() -> None:
    """Maxwell and Betti: the work of load 1 on the displacement by load 2 equals the other way round."""
    rng = np.random.default_rng(5)
    place = Place("pairs", (3, 4))
    one, two = (
        loads({(joint_node(3), RZ): rng.normal(size=1), (joint_node(4), RZ): rng.normal(size=1)}) for _ in range(2)
    )
    work_12 = np.sum(one.wrench * displacement(EFFECT, place, {"c": 1.0}, two))
    work_21 = np.sum(two.wrench * displacement(EFFECT, place, {"c": 1.0}, one))
    np.testing.assert_allclose(work_12, work_21)

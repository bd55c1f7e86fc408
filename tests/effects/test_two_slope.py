"""two-slope: c · clip(τ, ±knee)."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.two_slope import TwoSlope
from stiffcal.model.effect import RZ, Place, joint_node
from tests.laboratory.effect_bench import displacement, loads, robot_chain

EFFECT = TwoSlope()
PLACE = Place("joints", (1,))
NODE = joint_node(1)


def test_softer_inside_the_knee_and_flat_outside() -> None:
    torque = [-100.0, -30.0, -10.0, 0.0, 20.0, 31.0, 500.0]
    moved = displacement(EFFECT, PLACE, {"c": 1e-6, "knee": 30.0}, loads({(NODE, RZ): torque}))[NODE, RZ]
    np.testing.assert_allclose(moved, np.array([-30.0, -30.0, -10.0, 0.0, 20.0, 30.0, 30.0]) * 1e-6)


def test_knees_within_the_torques_seen() -> None:
    carried = loads({(NODE, RZ): np.linspace(-200.0, 100.0, 31)})
    knees = EFFECT.nonlinear_grid(PLACE, robot_chain(), carried)["knee"]
    assert len(knees) > 3
    assert (np.diff(knees) > 0).all()
    assert 0.0 < knees[0] < knees[-1] < 200.0


def test_knees_among_the_few_small_torques() -> None:
    """A knee of a few N·m under loads of hundreds shows where the torque passes zero alone."""
    torque = np.concatenate([[-5.0, 9.0, 40.0], np.linspace(200.0, 2000.0, 60)])
    knees = EFFECT.nonlinear_grid(PLACE, robot_chain(), loads({(NODE, RZ): torque}))["knee"]
    assert knees[0] > 5.0
    assert np.sum(knees < 40.0) >= 2


def test_no_knee_where_the_torque_stays_where_it_is() -> None:
    carried = loads({(NODE, RZ): np.linspace(990.0, 1000.0, 11)})
    assert EFFECT.nonlinear_grid(PLACE, robot_chain(), carried)["knee"].size == 0


def test_a_torque_of_one_sign_may_show_a_knee() -> None:
    carried = loads({(NODE, RZ): np.linspace(20.0, 100.0, 11)})
    assert EFFECT.nonlinear_grid(PLACE, robot_chain(), carried)["knee"].size > 3

"""backlash: (b/2) tanh(τ/w) on the whole torque."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.backlash import Backlash
from stiffcal.model.effect import RZ, Place, joint_node
from tests.laboratory.effect_bench import displacement, loads, robot_chain, settled

EFFECT = Backlash()
PLACE = Place("joints", (4,))
NODE = joint_node(4)


def test_from_flank_to_flank_is_the_width() -> None:
    carried = loads({(NODE, RZ): [-100.0, 0.0, 2.0, 100.0]})
    moved = displacement(EFFECT, PLACE, {"width": 2e-3, "band": 2.0}, carried)[NODE, RZ]
    np.testing.assert_allclose(moved, [-1e-3, 0.0, 1e-3 * np.tanh(1.0), 1e-3], rtol=1e-12)
    np.testing.assert_allclose(moved[3] - moved[0], 2e-3)


def test_slope_at_zero_is_width_over_twice_the_band() -> None:
    carried = loads({(NODE, RZ): [-1e-4, 1e-4]})
    low, high = displacement(EFFECT, PLACE, {"width": 2e-3, "band": 2.0}, carried)[NODE, RZ]
    np.testing.assert_allclose((high - low) / 2e-4, 2e-3 / (2 * 2.0), rtol=1e-6)


def test_weight_keeps_a_joint_on_its_flank() -> None:
    """Joint 2 carries the arm: a load that does not lift it moves nothing but what springs give."""
    chain = robot_chain()
    joints = chain.model_angles(np.radians([[0.0, -30.0, 10.0, 0.0, 0.0, 0.0]]))
    values = {"width": 1e-3, "band": 5.0}
    found = settled([(EFFECT, Place("joints", (2,)), values)], joints, np.array([[5.0, 5.0, 5.0, 0, 0, 0]]))
    assert abs(found.joint_torque[0, 1]) > 500.0
    assert np.abs(found.displacement).max() < 1e-9


def test_bands_only_where_the_torque_changes_sign() -> None:
    chain = robot_chain()
    crossing, kept = (loads({(NODE, RZ): np.linspace(low, 100.0, 21)}) for low in (-50.0, 1.0))
    bands = EFFECT.nonlinear_grid(PLACE, chain, crossing)["band"]
    assert 0.0 < bands[0] < 1.0
    assert bands[-1] < 50.0
    assert EFFECT.nonlinear_grid(PLACE, chain, kept)["band"].size == 0

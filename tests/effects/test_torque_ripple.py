"""torque-ripple: a swing of the torque with the angle, alike in both directions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.torque_ripple import MOST_INTEGERS, TorqueRipple
from tests.laboratory.drive_motions import strokes
from tests.laboratory.effect_bench import robot_chain

EFFECT = TorqueRipple()
CHAIN = replace(robot_chain(), gear_orders=((), (171,), (), (), (), ()))
FIRST, SECOND = EFFECT.places(CHAIN)[:2]


def test_the_law() -> None:
    motion = strokes((0.1, 0.5), 1.0)
    columns = EFFECT.motion_columns(FIRST, CHAIN, motion, {"order": 18.0})
    swing = 3.0 * columns["a"] - 4.0 * columns["b"]
    np.testing.assert_allclose(swing, 5.0 * np.cos(18.0 * motion.angle + np.arctan2(4.0, 3.0)), atol=1e-9)


def test_it_repeats_after_a_wave_and_does_not_know_the_direction() -> None:
    there = strokes((0.1,), 1.0)
    back = replace(there, velocity=-there.velocity, angle=there.angle + 2.0 * np.pi / 7.0)
    for symbol, column in EFFECT.motion_columns(FIRST, CHAIN, there, {"order": 7.0}).items():
        again = EFFECT.motion_columns(FIRST, CHAIN, back, {"order": 7.0})[symbol]
        np.testing.assert_allclose(again, column, atol=1e-9)


def test_orders_are_those_of_which_the_travel_holds_a_wave() -> None:
    """Over 60° at 0.4 rad/s and 50 Hz: from the 6th (60° a wave) to what four samples of 8 mrad resolve."""
    orders = EFFECT.motion_grid(FIRST, CHAIN, strokes((0.4,), np.radians(60.0) + 0.01))["order"]
    np.testing.assert_array_equal(orders, np.arange(6, 197))
    whole = EFFECT.motion_grid(FIRST, CHAIN, strokes((0.01,), 6.3))["order"]
    np.testing.assert_array_equal(whole, np.arange(1, MOST_INTEGERS + 1))


def test_gear_orders_are_tried_beyond_the_integers_that_are_resolved() -> None:
    motion = strokes((1.0,), 1.1)
    first, second = (EFFECT.motion_grid(place, CHAIN, motion)["order"] for place in (FIRST, SECOND))
    assert first.max() < 171.0
    np.testing.assert_array_equal(second, [*first, 171.0])


def test_what_is_missing_is_named() -> None:
    assert EFFECT.lacking_motion(CHAIN, strokes((0.4,), 1.0)) is None
    assert "shorter than one wave" in str(EFFECT.lacking_motion(CHAIN, strokes((0.01,), 0.02)))
    assert not len(EFFECT.motion_grid(FIRST, CHAIN, strokes((0.01,), 0.02))["order"])

"""stribeck: paper 004, eq. 1, its second term."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.stribeck import Stribeck
from stiffcal.model.drive_motion import DriveMotion
from tests.laboratory.drive_motions import strokes
from tests.laboratory.effect_bench import robot_chain

EFFECT, CHAIN = Stribeck(), robot_chain()
PLACE = EFFECT.places(CHAIN)[1]
SHAPE = {"velocity": 0.1, "exponent": 1.5}


def test_the_law() -> None:
    velocity = np.array([-0.3, -0.1, 0.0, 0.1, 1.0])
    column = EFFECT.torque_columns(velocity, SHAPE)["stribeck"]
    np.testing.assert_allclose(column[:2], [-np.exp(-(3.0**1.5)), -np.exp(-1.0)])
    np.testing.assert_array_equal(column[2], 0.0)
    np.testing.assert_allclose(column[3:], [np.exp(-1.0), np.exp(-(10.0**1.5))])


def test_limits() -> None:
    """All of it at a crawl, none far beyond ω_S, odd in ω."""
    column = EFFECT.torque_columns(np.array([1e-9, 9.0, -1e-9]), SHAPE)["stribeck"]
    np.testing.assert_allclose(column, [1.0, 0.0, -1.0], atol=1e-8)


def test_speeds_of_fading_lie_about_the_measured_speeds() -> None:
    grid = EFFECT.motion_grid(PLACE, CHAIN, strokes((0.02, 0.1, 0.4, 0.8), 1.0))
    np.testing.assert_allclose(grid["velocity"][[0, -1]], [0.01, 0.4])
    assert {1.0, 2.0} <= set(grid["exponent"])


def test_what_is_missing_is_named() -> None:
    assert "both directions" in str(EFFECT.lacking_motion(CHAIN, DriveMotion.at_velocity(np.linspace(0.1, 1.0, 9))))
    assert "4 different speeds" in str(EFFECT.lacking_motion(CHAIN, strokes((0.1, 0.2, 0.4), 1.0)))
    assert EFFECT.lacking_motion(CHAIN, strokes((0.1, 0.2, 0.4, 0.8), 1.0)) is None

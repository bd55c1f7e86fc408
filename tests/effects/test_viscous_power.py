"""viscous-power: friction with a power of the speed."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.effects.viscous_power import ViscousPower
from stiffcal.model.drive_motion import DriveMotion
from tests.laboratory.drive_motions import strokes
from tests.laboratory.effect_bench import robot_chain

EFFECT, CHAIN = ViscousPower(), robot_chain()
PLACE = EFFECT.places(CHAIN)[1]


def test_the_law() -> None:
    velocity = np.array([-4.0, 0.0, 0.25, 1.0])
    np.testing.assert_allclose(EFFECT.torque_columns(velocity, {"power": 0.5})["factor"], [-2.0, 0.0, 0.5, 1.0])
    np.testing.assert_allclose(EFFECT.torque_columns(velocity, {"power": 2.0})["factor"], [-16.0, 0.0, 0.0625, 1.0])


@pytest.mark.parametrize(("power", "possible"), [(0.1, True), (0.8, True), (0.9, False), (1.1, False), (1.2, True)])
def test_powers_about_one_are_viscous_friction(power: float, possible: bool) -> None:
    assert (EFFECT.impossible({"factor": 1.0, "power": power}) is None) is possible


def test_no_impossible_power_is_tried() -> None:
    powers = EFFECT.motion_grid(PLACE, CHAIN, strokes((0.1, 0.2), 1.0))["power"]
    assert all(EFFECT.impossible({"power": float(power)}) is None for power in powers)
    assert (powers.min(), powers.max()) == (0.1, 2.0)


def test_what_is_missing_is_named() -> None:
    assert "both directions" in str(EFFECT.lacking_motion(CHAIN, DriveMotion.at_velocity(-np.linspace(0.1, 1.0, 9))))
    assert "4 different speeds" in str(EFFECT.lacking_motion(CHAIN, strokes((0.1, 0.2, 0.4), 1.0)))
    assert EFFECT.lacking_motion(CHAIN, strokes((0.1, 0.2, 0.4, 0.8), 1.0)) is None

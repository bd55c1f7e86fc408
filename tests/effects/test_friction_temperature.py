"""friction-temperature: the linear part of Bittencourt and Gunnarsson 2012."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.friction_temperature import FrictionTemperature
from tests.laboratory.drive_motions import strokes
from tests.laboratory.effect_bench import robot_chain

EFFECT, CHAIN = FrictionTemperature(), robot_chain()
PLACE = EFFECT.places(CHAIN)[0]
MOTION = strokes((0.2, 0.5), 1.5)


def test_the_law() -> None:
    """Nothing at the first temperature; Coulomb and viscous parts change with the sign of the motion."""
    motion = replace(MOTION.block(slice(3)), velocity=np.array([0.5, 0.5, -0.5]), temperature=np.array([0.0, 4.0, 4.0]))
    columns = EFFECT.motion_columns(PLACE, CHAIN, motion, {})
    np.testing.assert_array_equal(columns["coulomb_K"], [0.0, 4.0, -4.0])
    np.testing.assert_array_equal(columns["viscous_K"], [0.0, 2.0, -2.0])


def test_readings_without_a_temperature_add_nothing() -> None:
    motion = replace(MOTION, temperature=np.where(MOTION.time < 1.0, 3.0, np.nan))
    column = EFFECT.motion_columns(PLACE, CHAIN, motion, {})["coulomb_K"]
    np.testing.assert_array_equal(column[MOTION.time >= 1.0], 0.0)
    np.testing.assert_array_equal(np.abs(column[MOTION.time < 1.0]), 3.0)


def test_what_is_missing_is_named() -> None:
    warming = replace(MOTION, temperature=MOTION.time / 10.0)
    assert EFFECT.lacking_motion(CHAIN, warming) is None
    assert "a temperature in the logs" in str(EFFECT.lacking_motion(CHAIN, MOTION))
    assert "changes" in str(EFFECT.lacking_motion(CHAIN, replace(MOTION, temperature=np.zeros(len(MOTION)))))
    assert "both directions" in str(EFFECT.lacking_motion(CHAIN, warming.block(warming.velocity > 0.0)))

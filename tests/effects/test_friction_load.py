"""friction-load: Bittencourt and Gunnarsson 2012."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.friction_load import FrictionLoad
from tests.laboratory.drive_motions import strokes
from tests.laboratory.effect_bench import robot_chain

EFFECT, CHAIN = FrictionLoad(), robot_chain()
PLACE = EFFECT.places(CHAIN)[1]
MOTION = strokes((0.2, 0.5), 1.5)


def test_the_law() -> None:
    """Always against the motion, whichever way the weight pulls."""
    motion = replace(
        MOTION.block(slice(4)), velocity=np.array([0.2, -0.2, 0.2, 0.0]), load=np.array([30.0, 30.0, -30.0, 30.0])
    )
    column = EFFECT.motion_columns(PLACE, CHAIN, motion, {})["per_Nm"]
    np.testing.assert_array_equal(column, [30.0, -30.0, 30.0, 0.0])


def test_what_is_missing_is_named() -> None:
    weight = replace(MOTION, load=100.0 * np.cos(MOTION.angle))
    assert EFFECT.lacking_motion(CHAIN, weight) is None
    assert "masses" in str(EFFECT.lacking_motion(CHAIN, MOTION))
    constant = replace(MOTION, load=np.full(len(MOTION), -40.0))
    assert "differs in size" in str(EFFECT.lacking_motion(CHAIN, constant))
    assert "both directions" in str(EFFECT.lacking_motion(CHAIN, weight.block(weight.velocity > 0.0)))

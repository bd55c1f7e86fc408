"""friction-asymmetry: a constant torque."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.friction_asymmetry import FrictionAsymmetry
from stiffcal.effects.joint_friction import JointFriction
from stiffcal.model.motion import is_constant_torque
from tests.laboratory.drive_motions import strokes
from tests.laboratory.effect_bench import robot_chain

EFFECT, CHAIN = FrictionAsymmetry(), robot_chain()
PLACE = EFFECT.places(CHAIN)[2]


def test_friction_forwards_and_backwards_differ_by_twice_the_offset() -> None:
    motion = strokes((0.2, 0.5), 1.0)
    dry = 50.0 * JointFriction().torque_columns(motion.velocity, {})["coulomb"]
    torque = dry + 3.0 * EFFECT.motion_columns(PLACE, CHAIN, motion, {})["offset"]
    np.testing.assert_array_equal(torque, np.where(motion.velocity > 0.0, 53.0, -47.0))


def test_it_is_a_constant() -> None:
    assert is_constant_torque(EFFECT, PLACE, CHAIN)
    assert not is_constant_torque(JointFriction(), PLACE, CHAIN)


def test_what_is_missing_is_named() -> None:
    motion = strokes((0.2, 0.5), 1.0)
    assert EFFECT.lacking_motion(CHAIN, motion) is None
    assert "both directions" in str(EFFECT.lacking_motion(CHAIN, motion.block(motion.velocity > 0.0)))

"""joint-friction: the Coulomb and viscous terms of paper 004, eq. 1."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.joint_friction import JointFriction
from stiffcal.effects.stribeck import Stribeck
from stiffcal.model.drive_motion import DriveMotion
from tests.laboratory.effect_bench import robot_chain
from tests.laboratory.friction_law import friction_torque

EFFECT = JointFriction()


def test_with_stribeck_it_is_equation_1() -> None:
    velocity = np.array([-0.3, -0.1, 0.0, 0.1, 1.0])
    values = {"coulomb": 50.0, "stribeck": 20.0, "velocity": 0.1, "exponent": 1.5, "viscous": 80.0}
    columns = EFFECT.torque_columns(velocity, {}) | Stribeck().torque_columns(velocity, values)
    total = sum(values[symbol] * column for symbol, column in columns.items())
    np.testing.assert_allclose(total, friction_torque(velocity, values))


def test_limits() -> None:
    """At rest none, creeping F_C, odd in ω."""
    columns = EFFECT.torque_columns(np.array([0.0, 1e-9, -0.4, 0.4]), {})
    np.testing.assert_allclose(
        50.0 * columns["coulomb"] + 80.0 * columns["viscous"], [0.0, 50.0, -82.0, 82.0], rtol=1e-6
    )


def test_what_is_missing_is_named() -> None:
    one_way = DriveMotion.at_velocity(np.array([0.1, 0.3]))
    assert "both directions" in str(EFFECT.lacking_motion(robot_chain(), one_way))
    assert EFFECT.lacking_motion(robot_chain(), DriveMotion.at_velocity(np.array([0.1, -0.3]))) is None

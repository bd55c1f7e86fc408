"""joint-friction: paper 004, eq. 1."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.joint_friction import JointFriction
from tests.laboratory.effect_bench import bare_states, robot_chain

EFFECT = JointFriction()
VALUES = {"coulomb": 50.0, "stribeck": 20.0, "velocity": 0.1, "exponent": 1.5, "viscous": 80.0}


def test_equation_1() -> None:
    velocity = np.array([-0.3, -0.1, 0.1, 1.0])
    wanted = (50.0 + 20.0 * np.exp(-((np.abs(velocity) / 0.1) ** 1.5))) * np.sign(velocity) + 80.0 * velocity
    np.testing.assert_allclose(EFFECT.friction_torque(velocity, VALUES), wanted)


def test_limits() -> None:
    """At rest none; creeping F_C + F_S; far beyond ω_S dry and viscous alone; odd in ω."""
    np.testing.assert_array_equal(EFFECT.friction_torque(np.zeros(1), VALUES), [0.0])
    np.testing.assert_allclose(EFFECT.friction_torque(np.array([1e-9, 5.0]), VALUES), [70.0, 450.0], rtol=1e-6)
    velocity = np.linspace(0.01, 1.0, 7)
    np.testing.assert_allclose(EFFECT.friction_torque(-velocity, VALUES), -EFFECT.friction_torque(velocity, VALUES))


def test_load_states_are_taken_at_rest() -> None:
    assert "friction runs" in str(EFFECT.lacking(robot_chain(), bare_states([0, 0, 0])))

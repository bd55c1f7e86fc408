"""wrench-frame: the true sensor axes are the manifest's turned by exp(r), sensor axes."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.wrench_frame import WrenchFrame
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.effect import Inputs, Place
from tests.laboratory.effect_bench import robot_chain, settled
from tests.laboratory.robots import force_sensor_setup

EFFECT = WrenchFrame()
PLACE = Place("setup")
TURN = {"rx": 0.02, "ry": -0.03, "rz": 0.05}


def test_equals_turning_the_readings() -> None:
    """What is read in turned axes as w is exp(r) w in the manifest's axes, forces and moments alike."""
    rng = np.random.default_rng(12)
    chain = robot_chain()
    joints = chain.model_angles(rng.uniform(-1, 1, (4, 6)))
    wrench = rng.normal(0.0, 100.0, (4, 6))
    springs = [(JointCompliance(), Place("joints", (k,)), {"c": 1e-6 * k}) for k in range(1, 7)]
    found = settled([*springs, (EFFECT, PLACE, TURN)], joints, wrench).displacement
    turn = rotation_from_vector(np.array(list(TURN.values())))
    turned = np.concatenate([wrench[:, :3] @ turn.T, wrench[:, 3:] @ turn.T], axis=1)
    np.testing.assert_allclose(found, settled(springs, joints, turned).displacement, atol=1e-13)


def test_nothing_at_zero() -> None:
    chain = robot_chain()
    inputs = Inputs(np.zeros((6, 1)), np.ones((6, 1)), force_sensor_setup(chain))
    assert EFFECT.adjusted(PLACE, inputs, {"rx": 0.0}) is inputs

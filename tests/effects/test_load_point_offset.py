"""load-point-offset: a force that acts elsewhere makes the moment of the offset."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.load_point_offset import LoadPointOffset
from stiffcal.model.effect import Inputs, Place
from tests.laboratory.effect_bench import bare_states, robot_chain, settled
from tests.laboratory.robots import force_sensor_setup, shifted

EFFECT = LoadPointOffset()
PLACE = Place("setup")
OFFSET = {"x": 0.01, "y": -0.02, "z": 0.03}
CHAIN = robot_chain()
SENSOR = force_sensor_setup(CHAIN)
# axes of the flange itself, so that offset and force can be crossed without turning
AXES = replace(SENSOR.wrench_axes, transform=shifted(0.0, 0.0, 0.06))
FORCE_ONLY = replace(SENSOR, moments_measured=False, wrench_axes=AXES, wrench_point=AXES)


def test_equals_the_moment_of_the_offset() -> None:
    rng = np.random.default_rng(14)
    joints = CHAIN.model_angles(rng.uniform(-1, 1, (4, 6)))
    wrench = np.concatenate([rng.normal(0.0, 100.0, (4, 3)), np.zeros((4, 3))], axis=1)
    springs = [(JointCompliance(), Place("joints", (k,)), {"c": 1e-6}) for k in range(1, 7)]
    found = settled([*springs, (EFFECT, PLACE, OFFSET)], joints, wrench, FORCE_ONLY).displacement
    with_moment = wrench.copy()
    with_moment[:, 3:] = np.cross(list(OFFSET.values()), wrench[:, :3])
    measured = replace(FORCE_ONLY, moments_measured=True)
    np.testing.assert_allclose(found, settled(springs, joints, with_moment, measured).displacement, atol=1e-12)


def test_not_where_moments_are_measured() -> None:
    inputs = Inputs(np.zeros((6, 1)), np.ones((6, 1)), SENSOR)
    assert EFFECT.adjusted(PLACE, inputs, OFFSET) is inputs
    assert "moments are measured" in str(EFFECT.lacking(CHAIN, bare_states([0], setup=SENSOR)))
    assert EFFECT.lacking(CHAIN, bare_states([0], setup=FORCE_ONLY)) is None
    on_link = replace(FORCE_ONLY, wrench_point=replace(AXES, body=3))
    assert "flange" in str(EFFECT.lacking(CHAIN, bare_states([0], setup=on_link)))

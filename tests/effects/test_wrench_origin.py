"""wrench-origin: the sensor's true origin is the manifest's plus the offset, sensor axes; moment += d × F."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.wrench_origin import WrenchOrigin
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.effect import Inputs, Place
from tests.laboratory.effect_bench import bare_states, robot_chain, settled
from tests.laboratory.robots import force_sensor_setup

EFFECT = WrenchOrigin()
PLACE = Place("setup")
OFFSET = {"x": 0.01, "y": -0.02, "z": 0.03}
SPRINGS = [(JointCompliance(), Place("joints", (k,)), {"c": 1e-6 * k}) for k in range(1, 7)]
CHAIN = robot_chain()


def drawn(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (4, 6) joint angles and wrenches."""
    rng = np.random.default_rng(seed)
    return CHAIN.model_angles(rng.uniform(-1, 1, (4, 6))), rng.normal(0.0, 100.0, (4, 6))


def test_the_moment_grows_by_offset_times_force() -> None:
    joints, wrench = drawn(17)
    found = settled([*SPRINGS, (EFFECT, PLACE, OFFSET)], joints, wrench).displacement
    shifted = wrench.copy()
    shifted[:, 3:] += np.cross(list(OFFSET.values()), wrench[:, :3])
    np.testing.assert_allclose(found, settled(SPRINGS, joints, shifted).displacement, atol=1e-13)


def test_readings_in_base_axes_refer_to_the_same_point_of_the_sensor() -> None:
    """The offset is along the sensor's axes as they stand in each pose, whatever axes the components are in."""
    joints, wrench = drawn(18)
    wrench *= 1e-3
    setup = force_sensor_setup(CHAIN)
    _, axes = attached_poses(CHAIN, joints, setup.wrench_axes)
    in_base = np.concatenate([np.einsum("nij,nj->ni", axes, part) for part in np.split(wrench, 2, axis=1)], axis=1)
    base = replace(setup, wrench_axes=Attachment(0, np.eye(4)))
    found = settled([*SPRINGS, (EFFECT, PLACE, OFFSET)], joints, in_base, base).displacement
    expected = settled([*SPRINGS, (EFFECT, PLACE, OFFSET)], joints, wrench).displacement
    # Axes of the base stay while the sensor's turn under weight and load: 2 mrad here.
    np.testing.assert_allclose(found, expected, atol=5e-3 * np.abs(expected).max())


def test_only_where_moments_are_read() -> None:
    setup = force_sensor_setup(CHAIN)
    forces = replace(setup, moments_measured=False)
    assert "load-point-offset" in str(EFFECT.lacking(CHAIN, bare_states([0], setup=forces)))
    assert EFFECT.lacking(CHAIN, bare_states([0], setup=setup)) is None
    inputs = Inputs(np.zeros((6, 1)), np.ones((6, 1)), forces)
    assert EFFECT.adjusted(PLACE, inputs, OFFSET) is inputs
    assert EFFECT.adjusted(PLACE, replace(inputs, setup=setup), {"x": 0.0}).setup is setup

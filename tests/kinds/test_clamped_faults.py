"""What a careless lab does to clamped runs: wrong poses, signs, limits; and what only looks like it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.kinds.clamped.held.faults import loaded_words, other_loaded, why_no_sweep
from stiffcal.kinds.clamped.held.saturation import find_saturation
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.kinds.clamped.loops.torque_angle import TorqueAngleLaw
from stiffcal.measurements.load_states import RunInfo
from tests.kinds.test_clamped_chain import driven

POSE = [39.0, -67.5, 94.5, -37.0, -36.5, -49.0]
NAMES = tuple(f"A{k}" for k in range(1, 7))


def test_a_held_flange_loads_the_moved_joint_alone() -> None:
    soft = np.diag([3e-8, 2e-8, 4e-8, 3e-8, 5e-8, 2e-8])
    for joint in range(1, 7):
        chain, _ = driven(POSE, joint, soft)
        assert other_loaded(chain) is None


def test_joints_in_one_line_are_no_contradiction() -> None:
    chain, _ = driven([10.0, -70.0, 100.0, 30.0, 0.0, 20.0], 4)
    assert other_loaded(chain) is None


def test_a_wrong_pose_is_recognised_by_the_joints_that_should_carry_nothing() -> None:
    right, _ = driven(POSE, 3)
    wrong = replace(right, torque=right.torque @ np.roll(np.eye(6), 1, axis=1) + 0.4 * right.torque)
    found = other_loaded(wrong)
    assert found is not None
    assert found[0] == 4
    assert found[1] == pytest.approx(2.5, rel=0.1)
    assert "the motion of A3 produces a torque on A4, 250 % of that on A3" in loaded_words("a", wrong, NAMES)
    # with forces alone the moments of a held flange are missing, and nothing can be said
    assert other_loaded(replace(wrong, moments_measured=False)) is None


def test_a_torque_that_runs_against_the_angle_is_called_so() -> None:
    angle = np.linspace(-1e-3, 1e-3, 50)
    assert "opposite signs" in why_no_sweep(angle, -1e5 * angle, None)
    assert "not driven from end to end" in why_no_sweep(angle, 1e5 * angle, None)


def swept(clip: float, step: float = 0.0, noise: float = 0.3) -> tuple[ClampedReadings, np.ndarray]:
    """Return a joint driven to and fro with rests at its ends, its torque known from a force along one axis."""
    time = np.arange(0.0, 16.0, 0.02)
    angle = 1e-3 * np.interp(time % 8.0, [0, 1.5, 2.5, 5.5, 6.5, 8], [0, 1, 1, -1, -1, 0])
    force = 400.0 * angle / 1e-3 + noise * np.random.default_rng(3).standard_normal(time.size)
    force = np.clip(force, -clip, clip)
    if step:
        force = np.round(force / step) * step
    wrench = np.zeros((time.size, 6))
    wrench[:, 0] = force
    joints = np.zeros((time.size, 6))
    joints[:, 2] = -angle
    readings = ClampedReadings(
        (RunInfo("a", "clamped"),), np.zeros(time.size, dtype=np.int64), time, joints, wrench,
        np.full((time.size, 6), np.nan), np.array([False]),
    )  # fmt: skip
    return readings, angle


def test_a_sensor_at_its_limit_for_a_few_readings_is_named() -> None:
    chain, _ = driven(POSE, 3)
    readings, angle = swept(clip=380.4)
    found = find_saturation(readings, angle, 400.0 * angle / 1e-3, chain)
    assert found is not None
    assert found.limit == 380.4
    assert "Fx stays at its limit of 380.4 N" in found.sentence


@pytest.mark.parametrize(("step", "noise"), [(0.0, 0.3), (1.0, 0.3), (5.0, 0.0), (25.0, 0.0)])
def test_a_coarse_sensor_at_rest_is_at_no_limit(step: float, noise: float) -> None:
    chain, _ = driven(POSE, 3)
    readings, angle = swept(clip=1e9, step=step, noise=noise)
    assert find_saturation(readings, angle, 400.0 * angle / 1e-3, chain) is None


def test_a_play_whose_far_side_was_not_reached_is_not_reported() -> None:
    law = TorqueAngleLaw(0.0, 8e-4, 4.0, 0.0, 0.0, 0.0, (3e5, 0.0, 0.0), (-6e-4, 6e-4))
    assert law.flank_not_reached == ""
    assert replace(law, reach=(-6e-4, 1e-6)).flank_not_reached == "upper"
    assert replace(law, reach=(-1e-6, 6e-4)).flank_not_reached == "lower"

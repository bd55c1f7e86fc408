"""Steady velocities found in logs: as logged, over the stretch that both directions share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.kinds.friction.logs.steady import (
    ONE_WAY,
    SHORT,
    JointLog,
    JointPass,
    readings_of,
    steady_passes,
    turning_points,
)
from stiffcal.measurements.set_aside import IN_USE
from stiffcal.reduction.holds.unused import UnusedCode, cause_text
from tests.laboratory.joint_strokes import INTERVAL, to_and_fro


@pytest.mark.parametrize("speed", [0.01, 0.1, 0.5, 2.0])
@pytest.mark.parametrize("step", [0.0, 2e-6, 5e-4])
def test_every_stroke_gives_its_velocity(speed: float, step: float) -> None:
    time, angle = to_and_fro(speed, cycles=2)
    angle = np.round(angle / step) * step if step else angle
    passes, dropped = steady_passes(JointLog(time, angle, np.zeros(time.size)))
    assert not dropped
    np.testing.assert_allclose([one.velocity for one in passes], [speed, -speed] * 2, rtol=2e-4)
    assert all(-0.5 <= one.low < one.high <= 0.8 for one in passes)


def test_the_acceleration_is_left_out() -> None:
    """The torque of acceleration is a thousand times the steady one's noise: none of it may be in a pass."""
    for speed in (0.3, 1.0, 2.0):
        time, angle = to_and_fro(speed, cycles=1)
        velocity = np.gradient(angle, INTERVAL)
        passes, _ = steady_passes(JointLog(time, angle, np.gradient(velocity, INTERVAL)))
        assert max(np.abs(one.torque).max() for one in passes) < 1e-6


def test_a_velocity_that_was_never_reached() -> None:
    time, angle = to_and_fro(6.0, cycles=2)
    passes, dropped = steady_passes(JointLog(time, angle, np.zeros(time.size)))
    assert not passes
    assert len(dropped) == 4
    assert {stretch.code for stretch in dropped} == {UnusedCode.NEVER_STEADY}
    assert "a stroke of 74° has no phase of constant velocity" in cause_text(dropped)


def test_the_fastest_moment_of_a_swing_is_not_steady() -> None:
    time = np.arange(0.0, 12.0, INTERVAL)
    for angle in (np.sin(time), 0.4 * np.sin(2.0 * time) + 0.25 * np.sin(5.3 * time) + 0.2 * np.sin(0.7 * time)):
        passes, dropped = steady_passes(JointLog(time, angle, np.zeros(time.size)))
        assert not passes
        assert dropped


def test_the_logged_velocity_counts() -> None:
    """A drive that cannot make its 1.5 rad/s and logs 1.2 is read at 1.2."""
    time, angle = to_and_fro(1.2, cycles=1)
    velocity = np.gradient(angle, INTERVAL) * 1.01
    passes, _ = steady_passes(JointLog(time, angle, np.zeros(time.size), velocity))
    np.testing.assert_allclose([one.velocity for one in passes], [1.212, -1.212], rtol=1e-3)


def test_turning_points_ignore_noise() -> None:
    rng = np.random.default_rng(1)
    time, angle = to_and_fro(0.5, cycles=2)
    turns = turning_points(angle + 1e-4 * rng.normal(size=time.size))
    assert len(turns) == 5
    assert turns[0] == 0
    np.testing.assert_allclose(angle[turns[1:-1]], [0.8, -0.5, 0.8], atol=1e-6)


def moved(speed: float, low: float = -0.5, high: float = 0.8, weight: float = 100.0, joint: int = 2) -> list[JointPass]:
    time, angle = to_and_fro(speed, low, high, cycles=1)
    torque = 10.0 * np.sign(np.gradient(angle)) + weight * np.cos(angle)
    passes, _ = steady_passes(JointLog(time, angle, torque))
    return [JointPass(one, 0, joint, np.zeros(6)) for one in passes]


def test_weight_cancels_to_a_fraction_of_a_sample() -> None:
    for speed in (0.05, 2.0):
        up, down = readings_of(moved(speed))
        assert up.stretch == down.stretch
        assert 0.5 * (up.torque - down.torque) == pytest.approx(10.0, abs=2e-3)


def test_only_the_stretch_that_all_passes_cover_counts() -> None:
    """One way the velocity was held longer than the other: what lies beyond carries other weight."""
    up, down = moved(0.5, weight=500.0)
    part = slice(0, 2 * down.steady_pass.time.size // 3)
    short = replace(
        down,
        steady_pass=replace(
            down.steady_pass, **{n: getattr(down.steady_pass, n)[part] for n in ("time", "angle", "torque")}
        ),
    )
    first, second = readings_of([up, short])
    assert (first.low, first.high) == (second.low, second.high) == (short.steady_pass.low, short.steady_pass.high)
    assert 0.5 * (first.torque - second.torque) == pytest.approx(10.0, abs=0.02)


def test_speeds_and_joints_are_kept_apart() -> None:
    readings = readings_of([*moved(1.8), *moved(2.0), *moved(2.0, joint=3)])
    assert [one.stretch for one in readings] == [0, 0, 1, 1, 2, 2]
    assert all(one.set_aside == IN_USE for one in readings)


def test_one_direction_only() -> None:
    readings = readings_of([*moved(0.5), *moved(1.0)[:1]])
    assert [one.set_aside for one in readings] == [IN_USE, IN_USE, ONE_WAY]


def test_a_pass_elsewhere_is_set_aside() -> None:
    readings = readings_of([*moved(0.5), *moved(0.5), *moved(0.5, 0.6, 1.9)[:1]])
    assert [one.set_aside for one in readings] == [IN_USE] * 4 + [SHORT]

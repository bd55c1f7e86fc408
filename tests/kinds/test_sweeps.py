"""Clamped runs cut into half sweeps, the moved joint found or refused, clocks brought together; motor-side logs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_robot
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.errors import InputError
from stiffcal.kinds.clamped.logs import clocks as clocks_module
from stiffcal.kinds.clamped.logs.clocks import lag_of
from stiffcal.kinds.clamped.logs.sweeps import cut_sweeps, moved_joint
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.clocks.lag_minima import LagMinimum, are_distinguished, lag_minima
from stiffcal.reduction.logs.log_rows import LogRows
from stiffcal.reduction.logs.motor_side import MotorSide

KR125 = Path(__file__).parents[2] / "campaigns" / "kr125" / "robot.toml"
NAMES = ("A1", "A2", "A3")


def triangle(n: int = 4000, cycles: float = 4.0, size: float = 1e-3) -> Floats:
    phase = np.linspace(0.0, cycles, n)
    return np.asarray(size * 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * phase)))


def test_half_sweeps_lead_from_corner_to_corner() -> None:
    angle = np.concatenate([np.zeros(200), triangle(), np.zeros(200)])
    sweeps = cut_sweeps(angle, 1e5 * angle + np.random.default_rng(1).standard_normal(angle.size))
    assert sweeps.count == 7
    assert sweeps.cycles == 3
    for number in range(sweeps.count):
        own = angle[sweeps.number == number]
        assert np.ptp(own) > 1.9e-3
        assert bool(sweeps.up[sweeps.number == number][0]) == bool(own[-1] > own[0])
    assert np.all(sweeps.number[:200] == -1)


def test_a_joint_that_friction_holds_turns_where_its_torque_does() -> None:
    """Driven by torque, the angle stands still at the ends while the torque goes back."""
    torque = triangle(size=40.0)
    angle = np.zeros_like(torque)
    for k in range(1, torque.size):
        angle[k] = min(max(angle[k - 1], (torque[k] - 10.0) / 1e4), (torque[k] + 10.0) / 1e4)
    sweeps = cut_sweeps(angle, torque)
    first = np.flatnonzero(sweeps.number == 1)[[0, -1]]
    assert np.abs(torque[first]) == pytest.approx([40.0, 40.0], abs=0.2)


def test_one_way_is_one_half_sweep() -> None:
    angle = np.concatenate([np.zeros(100), np.linspace(0.0, 1e-3, 500), np.full(100, 1e-3)])
    assert cut_sweeps(angle, 1e5 * angle).count == 1


@pytest.mark.parametrize(
    ("moving", "given", "words"),
    [
        ((), None, "no joint moved"),
        ((1,), 3, "joint 3 (A3) never moved"),
        ((1, 2), 2, "joint 3 (A3) also moved"),
    ],
)
def test_what_moved_is_reported_in_words(moving: tuple[int, ...], given: int | None, words: str) -> None:
    joints = np.random.default_rng(1).normal(0.0, 1e-8, (4000, 3))
    for k in moving:
        joints[:, k] += triangle()
    with pytest.raises(InputError) as caught:
        moved_joint("run1", joints, given, NAMES)
    assert words in str(caught.value)
    assert "run1" in str(caught.value)


def test_a_log_too_coarse_for_its_motion_is_not_one_that_stood_still() -> None:
    joints = 1e-3 * np.sin(2.5 * np.arange(15.0))[:, None]
    with pytest.raises(InputError) as caught:
        moved_joint("run1", joints, 1, ("A1",))
    assert "15 readings" in str(caught.value)
    assert "higher rate" in str(caught.value)


def test_the_moved_joint_is_found() -> None:
    joints = np.random.default_rng(1).normal(0.0, 1e-8, (4000, 3))
    joints[:, 1] += triangle()
    joints[:, 2] += 0.05 * triangle()  # its servo gives way
    assert moved_joint("run1", joints, None, NAMES) == 2


def driven_logs() -> tuple[Floats, Floats, Floats, Floats]:
    """Return times and angles of a joint that goes to and fro, and times and wrenches on a clock 1.35 s ahead."""
    rng = np.random.default_rng(2)
    time = np.arange(0.0, 40.0, 0.012)
    angle = np.interp(time, [2.0, 38.0], [0.0, 1.0]) * 0.0 + np.where(
        (time > 2.0) & (time < 38.0), 1e-3 * 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * (time - 2.0) / 9.0)), 0.0
    )
    other = np.arange(0.0, 42.0, 0.008)
    moved = np.interp(other - 1.35, time, angle)
    play = np.sign(moved) * np.maximum(np.abs(moved) - 3e-4, 0.0)
    wrench = np.outer(play * 4e5, [1.0, 0.2, -0.4, 0.1, 0.3, 0.0]) + 0.3 * rng.standard_normal((other.size, 6))
    return time, angle, other, wrench


def test_the_force_shows_its_clock() -> None:
    time, angle, other, wrench = driven_logs()
    offset = lag_of(time, angle, other, wrench)
    # noise of 0.3 N at 90 N/s in 3000 readings: 0.06 ms
    assert offset.value == pytest.approx(1.35, abs=3e-4)
    nothing = lag_of(time, angle, other, 0.3 * np.random.default_rng(3).standard_normal((other.size, 6)))
    assert nothing.value is None
    assert nothing.reason


def test_a_force_that_fits_at_two_lags_has_no_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a second minimum as deep, in half of the run's parts deeper, neither is taken."""
    minima = lag_minima
    part_losses = iter([[1.0, 2.0, 1.0, 2.0], [2.0, 1.0, 2.0, 1.0]])

    def with_rival(*args: Any) -> list[LagMinimum]:
        best, *others = minima(*args)
        return [best, replace(best, lag=best.lag + 1.0), *others]

    def compared(*_: object) -> bool:
        return are_distinguished(*part_losses)

    monkeypatch.setattr(clocks_module, "lag_minima", with_rival)
    monkeypatch.setattr(clocks_module, "are_distinguished", compared)
    offset = lag_of(*driven_logs())
    assert offset.value is None
    assert offset.reason


def chain() -> Chain:
    return chain_of(load_robot(KR125), KR125.parent)


def motor_log(**more: object) -> Source:
    joints = {"position": "M1..M6", "motor": True, "torque": "T1..T6", **more}
    return Source.model_validate({"time": {"rate_hz": 100.0}, "joints": joints})


def rows(motor: Floats, torque: Floats) -> LogRows:
    n = motor.shape[1]
    return LogRows(np.arange(1, n + 1), np.arange(n) / 100.0, [], {"joints": motor, "joints.torque": torque})


def test_motor_angles_come_to_the_joints_side() -> None:
    ratio = chain().gear_ratio
    joint = np.tile(triangle(1000, size=0.01), (6, 1))
    turned = MotorSide(motor_log(), chain()).joint_side(rows(joint * ratio[:, None], np.ones((6, 1000))))
    np.testing.assert_allclose(turned.signals["joints"], joint, atol=1e-15)
    np.testing.assert_allclose(turned.signals["joints.torque"][:, 0], ratio)


def test_motor_angles_that_start_anew_at_every_turn_go_on() -> None:
    ratio = chain().gear_ratio[:, None]
    joint = np.tile(np.linspace(0.0, 0.2, 3000), (6, 1))
    wrapped = (joint * ratio + 0.5 + np.pi) % (2.0 * np.pi) - np.pi
    side = MotorSide(motor_log(), chain())
    parts = [side.joint_side(rows(wrapped[:, part], wrapped[:, part])) for part in (slice(0, 1700), slice(1700, None))]
    found = np.concatenate([part.signals["joints"] for part in parts], axis=1)
    np.testing.assert_allclose(np.ptp(found, axis=1), 0.2, atol=1e-9)
    assert side.wraps.tolist() == [4, 4, 4, 2, 2, 2]
    # a log that counts turns is left alone, however fast
    fast = MotorSide(motor_log(), chain())
    steps = np.cumsum(np.full((6, 50), 5.0), axis=1)
    np.testing.assert_allclose(fast.joint_side(rows(steps, steps)).signals["joints"][:, -1] * ratio[:, 0], 250.0)


def test_a_motor_side_log_needs_gear_ratios() -> None:
    without = chain_of(load_robot(KR125.parents[2] / "stiffcal" / "propose" / "robots" / "kr125.toml"), Path())
    with pytest.raises(InputError, match="no gear ratio is given"):
        MotorSide(motor_log(), without, "controller")

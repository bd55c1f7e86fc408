"""Friction runs from logs: what is missing is said, and clocks of two devices are brought together by the motion."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from stiffcal.campaign.manifest.manifest import Run
from stiffcal.errors import InputError
from stiffcal.kinds.friction.logs.clocks import torque_clock
from stiffcal.kinds.friction.logs.free_motion import free_motion
from stiffcal.kinds.friction.logs.friction_run import FrictionRun
from stiffcal.kinds.friction.logs.runs import _one_way_words, friction_run, moved_joints, reduce_friction
from stiffcal.measurements.load_states import RunInfo
from stiffcal.reduction.holds.unused import UnusedCode
from stiffcal.reduction.logs.blocks import BlockAverager, Blocks, blocks_of
from stiffcal.reduction.logs.excluded_rows import ExcludedStretches
from tests.laboratory.friction_law import friction_torque
from tests.laboratory.joint_strokes import friction_runs, robot

VALUES = {"coulomb": 50.0, "stribeck": 0.0, "velocity": 0.05, "exponent": 1.3, "viscous": 80.0}


def several_speeds() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time, angle and torque of joint 2 over strokes at several speeds in one log."""
    parts = friction_runs(VALUES, (0.3, 0.7, 1.4))
    time, start = [], 0.0
    for part in parts:
        time.append(part.time + start)
        start += float(part.time[-1]) + 0.005
    return (
        np.concatenate(time),
        np.concatenate([part.angle for part in parts]),
        np.concatenate([part.torque for part in parts]),
    )


def one_log(**signals: np.ndarray) -> dict[str, Blocks]:
    time, angle, torque = several_speeds()
    known = {"joints": angle, "joints.torque": torque, **signals}
    return {"drives": blocks_of(time, known)}


def entry(**how: object) -> Run:
    return Run.model_validate({"id": "a", "experiment": "friction", **how})


def test_one_device_needs_no_clock() -> None:
    run = friction_run(entry(), one_log())
    assert moved_joints(run) == [2]
    assert set(run.clocks) == {"drives"}
    assert run.clocks["drives"].value == 0.0


@pytest.mark.parametrize("ahead", [0.0, 0.37, -2.5])
def test_two_devices_are_aligned_by_the_motion(ahead: float) -> None:
    time, angle, torque = several_speeds()
    logs = {
        "angles": blocks_of(time, {"joints": angle}),
        "torques": blocks_of(time[120:-300] + ahead, {"joints.torque": torque[120:-300]}),
    }
    run = friction_run(entry(), logs)
    found = run.clocks["torques"]
    assert found.value == pytest.approx(ahead, abs=0.004)
    assert found.std is not None
    assert 0.0 < found.std < 0.01
    steady = reduce_friction([run], robot()).steady
    assert steady is not None
    # a hundredth of a second would put weight and acceleration into the passes
    up, down = (steady.torque[(steady.velocity * way > 0.9) & steady.used].mean() for way in (1.0, -1.0))
    assert 0.5 * (up - down) == pytest.approx(float(friction_torque(np.array([1.4]), VALUES)[0]), abs=0.5)


def test_a_given_clock_is_taken() -> None:
    time, angle, torque = several_speeds()
    logs = {"torques": blocks_of(time + 1.0, {"joints.torque": torque}), "angles": blocks_of(time, {"joints": angle})}
    run = friction_run(entry(clock_ahead_s={"angles": -1.0}), logs)
    wanted = np.interp(run.time, time, torque[:, 1])
    assert np.median(np.abs(run.torque[:, 1] - wanted)) < 4.0
    assert run.clocks["angles"].reason == "given in the manifest"


def test_torques_that_follow_nothing() -> None:
    time, angle, _ = several_speeds()
    noise = np.random.default_rng(3).normal(size=(time.size, 1))
    reported = torque_clock(time, angle[:, 1:2], time, noise)
    assert reported.value is None
    assert reported.reason
    logs = {
        "angles": blocks_of(time, {"joints": angle}),
        "torques": blocks_of(time, {"joints.torque": np.tile(noise, 6)}),
    }
    with pytest.raises(InputError, match="clock_ahead_s"):
        friction_run(entry(), logs)


def test_torques_that_fit_at_two_lags_have_no_clock() -> None:
    """The clock of the torques was set by a quarter of a second in the middle of the log."""
    time, angle, torque = several_speeds()
    middle = 0.5 * (time[0] + time[-1])
    shown = np.where(time < middle, time, time + 0.25)
    reported = torque_clock(time, angle[:, 1:2], shown, torque[:, 1:2])
    assert reported.value is None
    assert reported.reason


def test_velocity_alone_will_do() -> None:
    time, angle, torque = several_speeds()
    velocity = np.gradient(angle, 0.005, axis=0)
    run = friction_run(entry(), {"drives": blocks_of(time, {"joints.velocity": velocity, "joints.torque": torque})})
    steady = reduce_friction([run], robot()).steady
    assert steady is not None
    np.testing.assert_allclose(np.unique(np.abs(steady.velocity).round(2)), [0.3, 0.7, 1.4])


def test_a_velocity_of_another_unit() -> None:
    _, angle, _ = several_speeds()
    with pytest.raises(InputError, match=r"joint 2 is 9\.55 times that of its angles"):
        friction_run(entry(), one_log(**{"joints.velocity": np.gradient(angle, 0.005, axis=0) * 9.5493}))
    with pytest.raises(InputError, match=r"joint 2 is −1.00 times that of its angles"):
        friction_run(entry(), one_log(**{"joints.velocity": -np.gradient(angle, 0.005, axis=0)}))


def with_rows_excluded(rows: np.ndarray, spoilt: float) -> tuple[FrictionRun, np.ndarray]:
    """Return a run whose log reads `spoilt` N·m more in some rows that are excluded, and the times of these."""
    time, angle, torque = several_speeds()
    excluded = np.isin(np.arange(time.size), rows)
    torque = np.where(excluded[:, None], torque + spoilt, torque)
    stretches, averager = ExcludedStretches(), BlockAverager()
    for part in (slice(0, 700), slice(700, None)):
        kept = ~excluded[part]
        signals = {"joints": angle[part][kept].T, "joints.torque": torque[part][kept].T}
        averager.add(time[part][kept], signals)
        stretches.update(time[part], excluded[part])
    return friction_run(entry(), {"drives": replace(averager.blocks(), excluded=stretches.array())}), time[excluded]


def test_excluded_rows_within_a_pass_are_no_samples_of_it() -> None:
    time, _, _ = several_speeds()
    whole = reduce_friction([friction_run(entry(), one_log())], robot())
    assert whole.steady is not None
    assert whole.samples is not None
    # the last pass is fast: fewer than 200 samples, each kept by itself
    start, end = whole.steady.start[-1], whole.steady.end[-1]
    inside = np.flatnonzero((time > start) & (time < end))
    rows = inside[[*range(40, 60), 80]]
    run, gone = with_rows_excluded(rows, 500.0)
    reduced = reduce_friction([run], robot())
    assert reduced.steady is not None
    assert reduced.samples is not None
    assert not np.isclose(reduced.samples.time[:, None], gone, atol=1e-4).any()
    assert np.isclose(whole.samples.time[:, None], gone, atol=1e-4).sum() == gone.size
    assert whole.steady.n_readings[-1] - reduced.steady.n_readings[-1] == gone.size
    assert len(whole.samples) - len(reduced.samples) == gone.size
    # the law that is in the log, not the 500 N·m of the excluded rows
    noise = whole.steady.scatter[-1] * np.sqrt(gone.size) / whole.steady.n_readings[-1]
    assert reduced.steady.torque[-1] == pytest.approx(whole.steady.torque[-1], abs=3.0 * noise)
    assert noise < 1.0


def test_a_pass_of_which_hardly_a_row_is_left_is_listed_as_excluded() -> None:
    time, _, _ = several_speeds()
    whole = reduce_friction([friction_run(entry(), one_log())], robot())
    assert whole.steady is not None
    inside = np.flatnonzero((time > whole.steady.start[0]) & (time < whole.steady.end[0]))
    reduced = reduce_friction([with_rows_excluded(inside[3:-3], 0.0)[0]], robot())
    assert reduced.steady is not None
    assert len(reduced.steady) == len(whole.steady) - 1
    assert [stretch.code for stretch in reduced.dropped["a"]] == [UnusedCode.EXCLUDED]


def test_windows_of_free_motion_hold_no_excluded_row() -> None:
    time, angle, torque = several_speeds()
    excluded = np.zeros(time.size, dtype=np.bool_)
    excluded[300:303] = True
    info = RunInfo("a", "friction")
    whole = free_motion(info, robot(), time, angle, torque)
    left = free_motion(info, robot(), time, angle, torque, excluded)
    gone = np.setdiff1d(whole.time, left.time)
    # thirteen samples to a window
    np.testing.assert_array_equal(gone, whole.time[np.abs(whole.time - time[301]) < 7.5 * 0.005])
    assert gone.size > 0


@pytest.mark.parametrize(
    ("signals", "words"),
    [
        ({"wrench": 6}, "needs the motion of the joints"),
        ({"joints": 6}, "needs the torques of the drives"),
        ({"joints": 6, "joints.current": 6}, "no torque constant is given"),
    ],
)
def test_what_is_missing(signals: dict[str, int], words: str) -> None:
    time = np.arange(0.0, 1.0, 0.01)
    log = blocks_of(time, {name: np.zeros((time.size, width)) for name, width in signals.items()})
    with pytest.raises(InputError, match=words):
        friction_run(entry(), {"log": log})


def test_nothing_moved() -> None:
    time = np.arange(0.0, 1.0, 0.01)
    still = np.zeros((time.size, 6))
    run = friction_run(entry(), {"log": blocks_of(time, {"joints": still, "joints.torque": still})})
    with pytest.raises(InputError, match="no joint moved"):
        reduce_friction([run], robot())


def test_what_is_alike_of_several_joints_is_one_warning() -> None:
    steady = SimpleNamespace(
        joint=np.array([1, 1, 2, 2]), set_aside_code=np.array(["a", "", "a", ""]), used=np.array([False, True] * 2),
        velocity=np.array([0.01, 0.1] * 2), set_aside=np.array(["short", ""] * 2),
    )  # fmt: skip
    texts = _one_way_words(cast(Any, steady), cast(Any, SimpleNamespace(joint_names=["A1", "A2"])))
    assert len(texts) == 1
    assert {"A1", "A2"} <= set(texts[0].replace(":", "").split())

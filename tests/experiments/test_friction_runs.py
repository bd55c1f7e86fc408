"""Friction runs from logs: what is missing is said, and clocks of two devices are brought together by the motion."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.campaign.manifest import Run
from stiffcal.errors import InputError
from stiffcal.experiments.friction.clocks import torque_clock
from stiffcal.experiments.friction.runs import friction_run, moved_joints, reduce_friction
from stiffcal.reduction.blocks import Blocks, blocks_of
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
    with pytest.raises(InputError, match=r"joint 2 is -1 times that of its angles"):
        friction_run(entry(), one_log(**{"joints.velocity": -np.gradient(angle, 0.005, axis=0)}))


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

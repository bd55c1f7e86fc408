"""Offsets between devices: found from what both recorded, to a few milliseconds, with an uncertainty that holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.reduction.clocks.lag_search import SharedSignal, moves
from stiffcal.reduction.clocks.offsets import _refine_lag, align_clocks, offset_between
from tests.laboratory.hidden_campaigns import raw_runs, truth
from tests.laboratory.made_up_logs import load_cycle


def tracker_of(
    generator: np.random.Generator, time: Floats, wrench: Floats, ahead: float, rate: float = 25.0
) -> SharedSignal:
    """Return what a tracker sees of a load whose clock it is `ahead` of: 1 N gives 5 µm, with noise of 10 µm."""
    compliance = 5e-6 * generator.normal(size=(3, 3))
    at = np.arange(0.5 * generator.random(), time[-1] - 0.5, 1.0 / rate)
    force = np.stack([np.interp(at, time, column) for column in wrench[:, :3].T], axis=1)
    return SharedSignal("tracker", at + ahead, force @ compliance.T + 1e-5 * generator.normal(size=(at.size, 3)), False)


def test_clocks_of_the_raw_logs() -> None:
    true = truth()["13-raw"]["clock_ahead_s_of_each_run"]
    pulls = []
    for run in raw_runs():
        assert run.clocks["ft"].value == 0.0
        tracker = run.clocks["tracker"]
        assert tracker.value is not None
        assert tracker.std is not None
        error = tracker.value - true[run.states.run[0]]["tracker"]
        assert abs(error) < 0.004
        pulls.append(error / tracker.std)
        assert run.clocks["controller"].value is None
        assert "only noise" in run.clocks["controller"].reason
    assert np.max(np.abs(pulls)) < 3.5


@pytest.mark.parametrize("rate", [2.5, 25.0, 300.0])
@pytest.mark.parametrize("ahead", [0.0, -13.7, 41.234])
def test_offsets_of_made_up_logs(rate: float, ahead: float) -> None:
    generator = np.random.default_rng(int(rate) + int(abs(ahead)))
    time, _, _ = load_cycle(generator, noise=0.0)
    generator = np.random.default_rng(int(rate) + int(abs(ahead)))
    _, wrench, _ = load_cycle(generator)
    force = SharedSignal("ft", time, wrench, True)
    tracker = tracker_of(generator, time, wrench, ahead, rate)
    found = offset_between(force, tracker)
    assert found.value is not None
    assert found.std is not None
    assert abs(found.value - ahead) < max(4.0 * found.std, 0.002)
    assert found.std < 0.01
    back = offset_between(tracker, force)
    assert back.value == pytest.approx(-found.value)


def test_a_log_whose_rate_is_wrong_is_named_by_how_long_it_lasts() -> None:
    """2.5 readings a second that are taken for 100."""
    generator = np.random.default_rng(1)
    time, wrench, _ = load_cycle(generator)
    tracker = tracker_of(generator, time, wrench, 0.0, 2.5)
    fast = replace(tracker, time=tracker.time * 0.025)
    found = offset_between(SharedSignal("ft", time, wrench, True), fast)
    assert found.value is None
    assert "check rate_hz" in found.reason
    in_ms = replace(tracker, time=tracker.time * 1000.0)
    assert "in ms and" in offset_between(SharedSignal("ft", time, wrench, True), in_ms).reason


def test_given_offsets_are_taken_and_the_first_source_counts() -> None:
    generator = np.random.default_rng(1)
    time, wrench, _ = load_cycle(generator)
    force = SharedSignal("ft", time, wrench, True)
    tracker = tracker_of(generator, time, wrench, 0.39)
    given = align_clocks([force, tracker], {"tracker": 0.25})
    assert given["tracker"].value == 0.25
    turned = align_clocks([tracker, force])
    assert turned["tracker"].value == 0.0
    assert turned["ft"].value == pytest.approx(-0.39, abs=0.005)


def test_joints_that_move_with_the_load_are_aligned() -> None:
    generator = np.random.default_rng(2)
    time, wrench, _ = load_cycle(generator)
    at = np.arange(0.0, time[-1], 0.024)
    force = np.stack([np.interp(at, time, column) for column in wrench[:, :3].T], axis=1)
    joints = 1.0 + force @ np.full((3, 6), 1e-8) + 4e-7 * generator.normal(size=(at.size, 6))
    log = SharedSignal("controller", at - 1.7, joints, False)
    found = align_clocks([SharedSignal("ft", time, wrench, True), log])["controller"]
    assert found.value is not None
    assert found.std is not None
    assert abs(found.value + 1.7) < max(4.0 * found.std, 0.005)


def test_what_is_not_shared_is_null_with_the_reason() -> None:
    generator = np.random.default_rng(3)
    time, wrench, _ = load_cycle(generator)
    force = SharedSignal("ft", time, wrench, True)
    still = SharedSignal("joints", np.arange(0.0, 100.0, 0.024), 1e-6 * generator.normal(size=(4167, 6)), False)
    found = offset_between(force, still)
    assert found.value is None
    assert "noise" in found.reason
    walk = np.cumsum(generator.normal(size=(4167, 6)), axis=0)
    drifting = SharedSignal("other", still.time, walk, False)
    found = offset_between(force, drifting)
    assert found.value is None or (found.std is not None and found.std > 0.05)


def test_noise_does_not_move_and_a_step_does() -> None:
    noise = np.random.default_rng(4).normal(size=(3000, 3))
    assert not moves(noise)
    assert moves(noise + 3.0 * (np.arange(3000) > 1500)[:, None])
    assert not moves(np.ones((3000, 2)))


def test_a_lag_that_goes_to_and_fro_between_two_settles_between_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ramp that comes into the windows at one lag and leaves them at the other: simulated max100, run pose3x."""
    asked: list[float] = []

    def answers(*arguments: object) -> tuple[Floats, Floats]:
        lag = float(arguments[4])  # type: ignore[arg-type]
        asked.append(lag)
        return np.full(8, 0.01 if lag < 0.2 else -0.01) - 0.5 * (lag - 0.2), np.ones(8)

    monkeypatch.setattr("stiffcal.reduction.clocks.offsets.ramp_answers", answers)
    monkeypatch.setattr("stiffcal.reduction.clocks.offsets._steps_agree", lambda *_: True)
    time = np.linspace(0.0, 40.0, 4001)
    values = np.sin(time)[:, None]
    one, other = (SharedSignal(name, time, values, False) for name in ("one", "other"))
    found = _refine_lag(one, other, 0.21)
    assert found.value == pytest.approx(0.2, abs=2e-4)
    assert found.std is not None
    assert found.std >= 0.009  # what is left to and fro is in the uncertainty

"""Logs of one run become states: what each device saw of each hold, and what is dropped."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.errors import InputError
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.reduction.holds.unused import UnusedCode
from stiffcal.reduction.logs.blocks import Blocks, blocks_of
from stiffcal.reduction.states.recordings import reduce_run
from tests.laboratory.made_up_logs import load_cycle

COMPLIANCE = 5e-6 * np.array([[1.0, 0.2, 0.0], [0.2, 1.5, -0.3], [0.0, -0.3, 0.8]])


def logs_of(seed: int, ahead: float = 0.4, first: float = 0.0, last: float = 1e9) -> tuple[dict[str, Blocks], Floats]:
    """Return force, tracker and joint logs of a made-up run, and its true holds."""
    generator = np.random.default_rng(seed)
    time, wrench, holds = load_cycle(generator)
    at = np.arange(0.013, time[-1], 0.04)
    at = at[(at >= first) & (at <= last)]
    force = np.stack([np.interp(at, time, column) for column in wrench[:, :3].T], axis=1)
    position = force @ COMPLIANCE + 1e-5 * generator.normal(size=(at.size, 3))
    joints = 0.3 + 1e-7 * generator.normal(size=(2000, 6))
    logs = {
        "ft": blocks_of(time, {"wrench": wrench}),
        "tracker": blocks_of(at + ahead, {"position.target": position}),
        "controller": blocks_of(np.arange(7.0, 107.0, 0.05), {"joints": joints}),
    }
    return logs, holds


def test_a_load_held_too_briefly_is_remembered() -> None:
    """It is no reading, but the load was there: it stays in the order, set aside, for what has a memory."""
    generator = np.random.default_rng(5)
    levels = np.array([0.0, 100.0, 200.0, 100.0, 0.0, 100.0, 220.0, 100.0, 0.0, -100.0, -200.0, -100.0, 0.0])
    lasting = np.where(levels == 220.0, 0.4, 2.0)
    corners = np.cumsum(np.stack([np.full(levels.size, 0.5), lasting], axis=1).ravel())
    at = np.arange(0.0, corners[-1], 0.02)
    load = np.interp(at, corners, np.repeat(levels, 2))
    wrench = np.zeros((at.size, 6))
    wrench[:, 2] = load
    wrench += generator.normal(size=wrench.shape)
    position = 1e-6 * load[:, None] * np.ones(3) + 1e-5 * generator.normal(size=(at.size, 3))
    logs = {"ft": blocks_of(at, {"wrench": wrench}), "tracker": blocks_of(at, {"position.target": position})}
    states = reduce_run(Run(id="a"), logs).states
    np.testing.assert_allclose(states.signals["wrench"][:, 2], levels, atol=2.0)
    brief = [entry.code == SetAsideCode.HELD_BRIEFLY for entry in states.set_aside]
    assert brief == (levels == 220.0).tolist()
    assert states.set_aside[6].text.startswith("dwell too short: 0.")
    assert states.number.tolist() == list(range(1, 14))


def test_joints_that_read_the_same_all_through() -> None:
    """A controller that rounds what it shows writes one number for each joint: it shares nothing, and need not."""
    logs, holds = logs_of(3)
    at = np.arange(7.0, 107.0, 0.05)
    logs["controller"] = blocks_of(at, {"joints": np.tile([0.3, -0.7, 0.1, 0.0, 1.2, 0.4], (at.size, 1))})
    run = reduce_run(Run(id="a"), logs)
    assert len(run.states.run) == len(holds)
    assert run.clocks["controller"].value is None
    np.testing.assert_allclose(run.states.signals["joints"][:, 4], 1.2)


def test_the_order_of_the_sources_does_not_matter() -> None:
    """Joints that stand in one pose share nothing with the load: as the first source they leave the clocks to it."""
    logs, _ = logs_of(3)
    usual = reduce_run(Run(id="a"), logs).states
    turned = reduce_run(Run(id="a"), dict(reversed(logs.items()))).states
    np.testing.assert_allclose(turned.signals["wrench"], usual.signals["wrench"], rtol=1e-12)
    first = reduce_run(Run(id="a"), {"controller": logs["controller"], "ft": logs["ft"], "tracker": logs["tracker"]})
    assert first.clocks["tracker"].value == pytest.approx(reduce_run(Run(id="a"), logs).clocks["tracker"].value)
    assert first.clocks["controller"].value is None


@pytest.mark.parametrize("begins", [0.0, 5000.0])
@pytest.mark.parametrize("wander", [0.0, 1e-3])
def test_temperature_next_to_joints_that_stand_rises_within_the_run(begins: float, wander: float) -> None:
    """The joints need no clock; the temperature next to them is that of each hold: on one clock, or from log begin."""
    logs, _ = logs_of(1)
    end = logs["ft"].end[-1]
    at = np.arange(0.0, end, 0.05)
    joints = 0.3 + wander * np.sin(at)[:, None] * np.ones(6)
    warming = 295.0 + 0.02 * at
    logs["controller"] = blocks_of(begins + at, {"joints": joints, "temperature": warming[:, None]})
    run = reduce_run(Run(id="a", clock_ahead_s={"tracker": 0.4}), logs)
    assert run.clocks["controller"].value is None
    assert np.ptp(run.states.signals["joints"]) == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(run.states.signals["temperature"][:, 0], 295.0 + 0.02 * run.states.time, atol=2e-3)
    assert np.ptp(run.states.signals["temperature"]) > 0.8 * 0.02 * end


def test_means_over_holds_and_their_scatter() -> None:
    logs, holds = logs_of(1)
    run = reduce_run(Run(id="a"), logs)
    states = run.states
    assert len(states.run) == len(holds)
    predicted = states.signals["wrench"][:, :3] @ COMPLIANCE
    assert np.abs(states.signals["position.target"] - predicted).max() < 1e-5
    assert np.median(states.scatter["wrench"][:, :3]) == pytest.approx(1.5, rel=0.1)
    # held for 2 s: its middle, and half of the way there
    assert states.hold[3] == pytest.approx(1.0 + 0.5 * 0.8, abs=0.1)
    assert (states.n_readings[1:-1] > 40).all()
    # joints that stand still are averaged over the whole log: their clock is not known and does not matter
    assert run.clocks["controller"].value is None
    np.testing.assert_allclose(states.signals["joints"], 0.3, atol=1e-7)


def test_holds_that_a_device_missed_are_dropped_and_half_seen_ones_kept() -> None:
    _, holds = logs_of(2)
    logs, _ = logs_of(2, first=holds[2, 0] + 1.5, last=holds[-4, 0] + 1.4)
    run = reduce_run(Run(id="a"), logs)
    assert run.states.number.tolist() == list(range(4, len(holds) - 2))
    assert ("tracker", UnusedCode.NOT_LOGGED) in {(stretch.source, stretch.code) for stretch in run.dropped}
    assert run.states.n_readings[-1] < run.states.n_readings[1]


def test_no_load_is_no_state() -> None:
    generator = np.random.default_rng(3)
    time = np.arange(0.0, 20.0, 0.01)
    ramp = {"ft": blocks_of(time, {"wrench": 50.0 * time[:, None] + generator.normal(size=(time.size, 6))})}
    with pytest.raises(InputError, match="the load was never constant"):
        reduce_run(Run(id="a"), ramp)


def test_a_log_that_moves_by_itself_cannot_be_placed() -> None:
    logs, _ = logs_of(4)
    walk = np.cumsum(1e-4 * np.random.default_rng(5).normal(size=(2000, 3)), axis=0)
    logs["tracker"] = blocks_of(np.arange(0.0, 100.0, 0.05), {"position.target": walk})
    with pytest.raises(InputError, match="give clock_ahead_s"):
        reduce_run(Run(id="a"), logs)
    assert len(reduce_run(Run(id="a", clock_ahead_s={"tracker": 0.0}), logs).states.run) > 30

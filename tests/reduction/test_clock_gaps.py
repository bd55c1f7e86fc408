"""Gaps in a log's times: readings that were lost, or a clock that was set, where the loads repeat with another sign."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffcal.reduction.clocks.lag_search import SharedSignal
from stiffcal.reduction.clocks.offsets import offset_between
from tests.reduction.test_clocks import tracker_of

AHEAD = 1.3
DIRECTIONS = np.concatenate([np.eye(3), -np.eye(3)])


def logs() -> tuple[SharedSignal, SharedSignal]:
    """Return logs of loads along +x, +y, +z, −x, −y, −z: half a cycle later they are the same with the other sign."""
    generator = np.random.default_rng(5)
    levels = [np.zeros(3), *(share * one for one in DIRECTIONS for share in (150.0, 300.0, 150.0, 0.0))]
    knots = (2.8 * np.arange(len(levels))[:, None] + np.array([0.0, 2.0])).ravel()
    time = np.arange(0.0, knots[-1], 0.05)
    force = np.stack([np.interp(time, knots, np.repeat(levels, 2, axis=0)[:, c]) for c in range(3)], axis=1)
    wrench = np.concatenate([force, np.cross([0.1, 0.2, -0.1], force)], axis=1)
    wrench += 0.8 * generator.normal(size=wrench.shape) * np.array([1.0, 1.0, 1.0, 0.2, 0.2, 0.2])
    return SharedSignal("ft", time, wrench, True), tracker_of(generator, time, wrench, AHEAD, 10.0)


def set_by(signal: SharedSignal, jump: float, share: float) -> SharedSignal:
    """Return a log whose clock is set forward after so much of it, by so many seconds."""
    return replace(signal, time=signal.time + jump * (np.arange(len(signal.time)) >= share * len(signal.time)))


def kept(signal: SharedSignal, where: NDArray[np.bool_]) -> SharedSignal:
    return replace(signal, time=signal.time[where], values=signal.values[where])


@pytest.mark.parametrize(("jump", "share"), [(4.0, 0.5), (2.0, 0.75), (5.0, 0.3), (30.0, 0.5)])
@pytest.mark.parametrize("which", ["ft", "tracker"])
def test_a_clock_that_is_set_within_a_log_gives_no_offset(jump: float, share: float, which: str) -> None:
    """One lag for all of it lay half a cycle away, and `diagnose` took the run for one of the other sign."""
    both = [set_by(one, jump, share) if one.source == which else one for one in logs()]
    found = offset_between(*both)
    assert found.value is None
    log = both[which == "tracker"]
    before = log.time[1 + int(np.argmax(np.diff(log.time)))]
    assert f"its clock was set: with the gap before {before:.1f} s in the times of {which}" in found.reason


@pytest.mark.parametrize(("begin", "end"), [(10.0, 25.0), (20.0, 60.0), (30.0, 42.7), (8.0, 12.0)])
@pytest.mark.parametrize("which", ["ft", "tracker"])
def test_readings_that_were_lost_move_no_offset(begin: float, end: float, which: str) -> None:
    """A gap that was filled with a straight line drew the lag to another part of the cycle."""
    ft, tracker = (kept(one, (one.time < begin) | (one.time > end)) if one.source == which else one for one in logs())
    found = offset_between(ft, tracker)
    assert found.value is not None
    assert found.std is not None
    assert found.value == pytest.approx(AHEAD, abs=max(4.0 * found.std, 0.005))

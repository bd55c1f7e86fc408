"""A load that is swept up and down instead of held: cut into passes, states at comparable loads, up and down apart."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.measurements.load_states import Attachment, LoadStates, MeasurementSetup, RunInfo
from stiffcal.reduction.holds.swept import find_sweeps, is_swept, turning_points
from stiffcal.reduction.loads.cycles import LOADING, PEAK, UNLOADED, UNLOADING, find_load_cycles, repeat_groups
from stiffcal.reduction.logs.blocks import blocks_of
from stiffcal.reduction.states.recordings import ReducedRun, reduce_run

CORNERS = (
    [0, 5, 15, 16, 26, 36, 37, 47, 57, 58, 68, 78, 79, 89, 95],
    [0, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, -1, 0, 0],
)
LARGEST = 900.0
COMPLIANCE = 1.2e-6  # m/N
LAG = 30e-6  # m, by which the way down stays behind the way up


def swept(waviness: float = 0.02, rate: float = 50.0) -> tuple[Floats, Floats]:
    """Return time and true load of two sweeps to either side, wavy by a share of the largest load."""
    time = np.arange(0.0, 95.0, 1.0 / rate)
    even = np.interp(time, *CORNERS)
    moving = np.abs(np.gradient(even)) > 0.0
    return time, LARGEST * (even + waviness * np.sin(2.0 * np.pi * 6.0 * even) * moving)


def reduced(waviness: float = 0.02, ahead: float = 0.37) -> ReducedRun:
    """Return the run of a device that reads force and displacement, and of rods with a clock of their own."""
    rng = np.random.default_rng(3)
    time, force = swept(waviness)
    rising = np.sign(np.gradient(np.interp(time, *CORNERS))) * np.sign(force)
    wrench = np.zeros((time.size, 6))
    wrench[:, 1] = -(force + 2.0 * rng.standard_normal(time.size))
    moved = COMPLIANCE * force + np.where(rising < 0.0, LAG, 0.0) * np.sign(force)
    rods = np.stack([2e-8 * force, -2e-8 * force], axis=1) + 0.2e-6 * rng.standard_normal((time.size, 2))
    logs = {
        "device": blocks_of(time, {"wrench": wrench, "displacement.device": moved[:, None] + 3e-4}),
        "ids": blocks_of(time + ahead, {"lengths.a": rods[:, :1], "lengths.b": rods[:, 1:]}),
    }
    return reduce_run(Run(id="sweep"), logs)


def as_states(run: ReducedRun) -> LoadStates:
    """Return what `find_load_cycles` looks at."""
    n = len(run.states.run)
    base, nothing = Attachment(0, np.eye(4)), np.zeros((n, 0, 3))
    return LoadStates(
        runs=(RunInfo("sweep"),), run=np.zeros(n, dtype=np.int64), time=run.states.time, hold=run.states.hold,
        joints=np.zeros((n, 6)), wrench=run.states.signals["wrench"], position=nothing,
        rotation=np.zeros((n, 0, 3, 3)), deflection=np.zeros((n, 0, 6)), reference=np.zeros(n, dtype=np.bool_),
        temperature=np.zeros((n, 0)), row=run.states.number, n_readings=run.states.n_readings,
        wrench_scatter=np.full((n, 6), np.nan), position_scatter=nothing, set_aside=np.full(n, ""),
        setup=MeasurementSetup(base, base, (), (), False),
    )  # fmt: skip


def test_turns_are_no_waves() -> None:
    _, force = swept(waviness=0.025)
    turns = turning_points(force, 0.15 * np.ptp(force))
    assert len(turns) == 6, "start, four turns, end"
    np.testing.assert_allclose(np.abs(force[turns[1:-1]]), LARGEST, rtol=0.03)


@pytest.mark.parametrize("waviness", [0.0, 0.025])
def test_states_lie_at_comparable_loads_on_every_pass(waviness: float) -> None:
    time, force = swept(waviness)
    found = find_sweeps(time, -force[:, None])
    assert found is not None
    assert found.passes == 5
    holds = found.holds
    assert (holds.start[1:] >= holds.end[:-1]).all(), "no reading is in two states"
    mean = np.array([force[(time >= a) & (time <= b)].mean() for a, b in zip(holds.start, holds.end, strict=True)])
    levels = np.round(10.0 * mean / LARGEST)
    assert np.abs(10.0 * mean / LARGEST - levels).max() < 0.35
    # each level but the turns is met four times: twice up, twice down
    for level in (-7, -3, 3, 7):
        assert np.count_nonzero(levels == level) == 4


def test_a_load_that_is_held_is_no_sweep() -> None:
    time = np.arange(0.0, 90.0, 0.02)
    steps = np.repeat([0, 250, 500, 750, 1000, 750, 500, 250, 0], 10) * 1.0
    held = np.interp(time, np.arange(90) + 0.3 * (np.arange(90) % 10 == 0), steps)
    assert not is_swept(time, held[:, None])
    for waviness in (0.0, 0.025):
        moments, force = swept(waviness)
        assert is_swept(moments, force[:, None])


def test_a_run_with_a_device_is_read_at_levels_with_up_and_down_apart() -> None:
    run = reduced()
    assert run.passes == 5
    assert run.clocks["ids"].value == pytest.approx(0.37, abs=0.02)
    signals = run.states.signals
    force, moved = -signals["wrench"][:, 1], signals["displacement.device"][:, 0] - 3e-4
    cycles = find_load_cycles(as_states(run))
    assert set(cycles.branch.tolist()) == {UNLOADED, LOADING, PEAK, UNLOADING}
    up, down = cycles.branch == LOADING, cycles.branch == UNLOADING
    np.testing.assert_allclose(moved[up], COMPLIANCE * force[up], atol=5e-6)
    np.testing.assert_allclose(moved[down] - COMPLIANCE * force[down], LAG * np.sign(force[down]), atol=5e-6)
    np.testing.assert_allclose(signals["lengths.a"][:, 0], 2e-8 * force, atol=0.5e-6)
    np.testing.assert_allclose(signals["lengths.b"], -signals["lengths.a"], atol=0.5e-6)
    groups = repeat_groups(as_states(run), cycles)
    assert sum(len(group) - 1 for group in groups) > 15, "the second sweep repeats the first"
    assert all(len(set(cycles.branch[group].tolist())) == 1 for group in groups)

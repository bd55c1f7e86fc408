"""Targets that read the same, or zero, in part of a table or of a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.mistakes.displacements.stopped_targets import stopped_targets
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played

NOISE = Sigma(translation=20e-6, force=0.3)
PER_RUN = 25


@pytest.fixture(scope="module")
def runs() -> LoadStates:
    """Four runs of three directions up and down, twice: 25 positions each."""
    return played(joint_springs(six_axes(), np.array(SIX_STIFFNESS)), 4, noise=NOISE, full_pose=False)


def as_table(states: LoadStates, resolution: float = 0.0) -> LoadStates:
    """Return the loaded states as a table of displacements, rounded where a resolution, m, is given."""
    first = np.searchsorted(states.run, states.run)
    change = states.position - states.position[first]
    deflection = np.full((len(states), 1, 6), np.nan)
    deflection[:, :, :3] = np.round(change / resolution) * resolution if resolution else change
    table = replace(states, deflection=deflection, position=np.full_like(states.position, np.nan))
    return table.select(~states.reference)


@pytest.mark.parametrize("rows", [slice(7, 11), slice(12, 25), slice(0, 25), slice(0, 50), slice(1, 3)])
def test_positions_that_stand_still_are_named(rows: slice, runs: LoadStates) -> None:
    position = runs.position.copy()
    position[rows] = position[rows.start]
    (line,) = stopped_targets(replace(runs, position=position), six_axes())
    assert line.startswith(f"run pose1, rows {runs.row[rows.start]} to ")


@pytest.mark.parametrize("resolution", [0.0, 1e-6, 1e-5, 1e-4])
def test_zeros_in_a_table_are_named_and_coarse_gauges_are_not(resolution: float, runs: LoadStates) -> None:
    table = as_table(runs, resolution)
    assert stopped_targets(table, six_axes()) == []
    for rows, value in ((slice(30, 40), 0.0), (slice(0, 40), 0.0), (slice(8, 20), 1e-4), (slice(9, 10), 0.0)):
        deflection: Floats = table.deflection.copy()
        deflection[rows, 0, :3] = value
        (line,) = stopped_targets(replace(table, deflection=deflection), six_axes())
        assert str(table.row[rows.start]) in line


def test_a_component_alone_is_named(runs: LoadStates) -> None:
    position = runs.position.copy()
    position[30:44, 0, 2] = position[30, 0, 2]
    (line,) = stopped_targets(replace(runs, position=position), six_axes())
    assert f"rows {runs.row[30]} to {runs.row[43]}" in line


def test_nothing_is_said_of_repeats_under_the_same_load(runs: LoadStates) -> None:
    """The state at the top of a cycle twice, with the very same reading of a gauge of a tenth of a millimetre."""
    table = replace(runs, position=np.round(runs.position / 1e-4) * 1e-4)
    assert stopped_targets(table.select(np.repeat(np.arange(len(runs)), 2)), six_axes()) == []


@pytest.mark.parametrize("value", [0.0, None])
def test_a_force_sensor_that_stops_is_named_and_loads_that_are_set_are_not(
    value: float | None, runs: LoadStates
) -> None:
    wrench = runs.wrench.copy()
    wrench[30:44] = wrench[30] if value is None else value
    (line,) = stopped_targets(replace(runs, wrench=wrench), six_axes())
    assert f"rows {runs.row[30]} to {runs.row[43]}" in line
    set_loads = runs.select(np.repeat(np.arange(len(runs)), 2))
    assert stopped_targets(replace(set_loads, wrench=np.round(set_loads.wrench, -1)), six_axes()) == []

"""Rows that stand in a table twice, word for word, are named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.reduction.copies.repeated_rows import repeated_rows
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played


@pytest.fixture(scope="module")
def states() -> LoadStates:
    robot = joint_springs(six_axes(), np.array(SIX_STIFFNESS))
    return played(robot, runs=3, noise=Sigma(1e-5, 2e-5, 0.5, 0.1))


def copied(states: LoadStates, source: int, target: int) -> LoadStates:
    arrays = {}
    for name in ("joints", "wrench", "position", "rotation", "deflection"):
        arrays[name] = getattr(states, name).copy()
        arrays[name][target] = getattr(states, name)[source]
    return replace(states, **arrays)


def test_readings_that_differ_are_no_copies(states: LoadStates) -> None:
    assert repeated_rows(states) == []


def test_a_row_that_is_a_copy_is_named_with_its_original(states: LoadStates) -> None:
    (warning,) = repeated_rows(copied(states, 2, 5))
    name = states.runs[0].name
    assert f"run {name} row {states.row[5]} repeats run {name} row {states.row[2]}:" in warning
    assert "[[exclude]]" in warning


def test_a_run_that_was_pasted_twice_is_one_entry_whatever_its_rows_without_load(states: LoadStates) -> None:
    run = np.flatnonzero(states.run == 0)
    half = len(run) // 2
    resting = np.isin(np.arange(len(states)), run[[1, 3, half + 1, half + 3]])
    pasted = replace(states, wrench=np.where(resting[:, None], 0.0, states.wrench))
    for k in range(half):
        pasted = copied(pasted, run[k], run[half + k])
    (warning,) = repeated_rows(pasted)
    assert warning.count("repeat") == 1
    assert f"({half - 2} of them)" in warning


def test_zeros_without_a_load_are_left_alone(states: LoadStates) -> None:
    unloaded = replace(states, wrench=np.where(np.isin(np.arange(len(states)), (2, 5))[:, None], 0.0, states.wrench))
    assert repeated_rows(copied(unloaded, 2, 5)) == []


def test_a_campaign_without_load_states_has_no_copies(states: LoadStates) -> None:
    """Friction and clamped runs alone leave none."""
    assert repeated_rows(states.select(np.zeros(0, dtype=np.int64))) == []

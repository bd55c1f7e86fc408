"""Bumped readings go, everything else stays: crossings, hysteresis, slips and drifts are no bumps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.measurements.load_states import Sigma
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.reduction.loads.cycles import find_load_cycles
from stiffcal.reduction.set_aside.outliers import load_is_good, outlier_readings, reject_outliers
from tests.laboratory.hidden_campaigns import reduced
from tests.laboratory.simulated_states import LOAD_POINT, cycles_of, medium_robot, played

OTHERS = ["01", "02", "03", "04", "05", "06", "07", "08", "09", "10", "12", "13-table"]
# of campaign 11, found by looking: run, state (data row within the run, from 0), off by 0.3 to 1.4 mm
BUMPED = {("pose01", 1), ("pose01", 18), ("pose01", 42), ("pose03", 72), ("pose06", 87), ("pose07", 11)}


def test_practice_11_holds_six_bumped_readings() -> None:
    states = reduced("11").states
    aside = np.flatnonzero(~states.used)
    first = {k: int(np.flatnonzero(states.run == k)[0]) for k in range(len(states.runs))}
    assert {(states.runs[states.run[k]].name, int(k) - first[int(states.run[k])]) for k in aside} == BUMPED
    assert all(reason.startswith("outlier: differs by") and "mm" in reason for reason in states.set_aside[aside])


@pytest.mark.parametrize("name", OTHERS)
def test_no_false_alarm(name: str) -> None:
    assert reduced(name).states.used.all()


@pytest.mark.parametrize("name", ["01", "03", "08"])
def test_bumps_put_in_are_found(name: str) -> None:
    states, generator = reduced(name).states, np.random.default_rng(3)
    chosen = generator.choice(len(states), 8, replace=False)
    push = generator.normal(size=(8, 3))
    position = states.position.copy()
    position[chosen, 0] += 4e-4 * push / np.linalg.norm(push, axis=1)[:, None]
    found = set(outlier_readings(replace(states, position=position)))
    assert len(found & set(chosen.tolist())) >= 7
    assert len(found - set(chosen.tolist())) <= 1


@pytest.mark.parametrize("name", ["01", "04"])
def test_slips_are_no_bumps(name: str) -> None:
    states, generator = reduced(name).states, np.random.default_rng(4)
    position = states.position.copy()
    for k in range(len(states.runs)):
        members = np.flatnonzero(states.run == k)
        position[members[generator.integers(5, len(members) - 5) :], 0] += 3e-4 * generator.normal(size=3)
    assert not outlier_readings(replace(states, position=position))


def test_a_jump_within_the_loads_is_no_bump() -> None:
    states = reduced("01").states
    cycles = find_load_cycles(states)
    position = states.position.copy()
    for k in range(len(states.runs)):
        members = np.flatnonzero(states.run == k)
        # play crossed between the second and the third level of the first axis
        along = cycles.magnitude[members] * np.where(cycles.axis[members] == 0, 1.0, 0.0)
        position[members, 0] += np.tanh((along - 0.62 * along.max()) / 2.0)[:, None] * np.array([2e-4, 3e-4, -1e-4])
    assert len(outlier_readings(replace(states, position=position))) <= 1


def test_states_set_aside_keep_their_reasons() -> None:
    states = reduced("11").states
    again = reject_outliers(states)
    assert (again.set_aside == states.set_aside).all()


def test_the_load_of_a_bumped_reading_is_good_that_of_an_excluded_row_in_doubt() -> None:
    states = reduced("11").states
    assert load_is_good(states).all()
    excluded = states.with_set_aside([7], SetAsideCode.EXCLUDED, "outlier: differs by a hand")
    assert np.flatnonzero(~load_is_good(excluded)).tolist() == [7]
    for code in (SetAsideCode.BUMPED, SetAsideCode.HELD_BRIEFLY):
        assert load_is_good(states.with_set_aside([7], code, "any text")).all()


def test_loads_that_are_set_at_an_angle_are_no_bumps() -> None:
    """A force of 1.2 kN two degrees off its direction moves a soft robot sideways by many times the tracker's noise."""
    generator = np.random.default_rng(8)
    wrench = []
    for _ in range(4):
        run = cycles_of(np.linalg.qr(generator.normal(size=(3, 3)))[0], cycles=3, force=1200.0)
        size = np.linalg.norm(run[:, :3], axis=1, keepdims=True)
        run[:, :3] += 0.035 * size * generator.normal(size=(len(run), 3))
        run[:, 3:] = np.cross(LOAD_POINT, run[:, :3])
        wrench.append(run)
    states = played(medium_robot(), runs=4, wrench=wrench, noise=Sigma(16e-6, 30e-6, 0.5, 0.1))
    assert not outlier_readings(states)
    position = states.position.copy()
    position[6, 0] += [6e-4, 0.0, -4e-4]
    assert set(outlier_readings(replace(states, position=position))) == {6}


@pytest.mark.parametrize(
    ("two", "push"),
    [
        ((56, 62), ((-0.77e-3, -0.04e-3, 0.30e-3), (0.41e-3, 0.20e-3, 0.45e-3))),
        ((54, 56), ((-0.16e-3, -0.68e-3, 0.01e-3), (0.28e-3, 0.31e-3, -0.16e-3))),
        ((54, 63), ((-0.39e-3, 0.20e-3, 0.29e-3), (0.16e-3, -0.77e-3, -0.46e-3))),
    ],
)
def test_two_bumps_do_not_hide_behind_a_good_reading(two: tuple[int, int], push: tuple[tuple[float, ...], ...]) -> None:
    """Two of the six readings of one branch: what is left of a course through all is largest at a good one."""
    generator = np.random.default_rng(0)
    levels = np.tile([0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0], 2)
    wrench = []
    for _ in range(4):
        axes = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        loads = [np.outer(levels * 300.0 * (1.0 + 0.03 * generator.normal(size=16)), axis) for axis in axes]
        force = np.concatenate([np.zeros((1, 3)), *loads])
        wrench.append(np.concatenate([force, np.cross(LOAD_POINT, force)], axis=1))
    states = played(medium_robot(), runs=4, wrench=wrench, noise=Sigma(16e-6, 30e-6, 0.5, 0.1), seed=0)
    position = states.position.copy()
    position[list(two), 0] += push
    assert set(outlier_readings(replace(states, position=position))) == set(two)

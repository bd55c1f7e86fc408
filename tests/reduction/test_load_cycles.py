"""Directions, branches and repeats of a load history."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.reduction.loads.cycles import BRANCH_NAMES, find_load_cycles, repeat_groups
from tests.laboratory.effect_bench import bare_states
from tests.laboratory.simulated_states import cycles_of, medium_robot, played


def test_branches_of_a_cycle() -> None:
    """Up, peak, down, released; opposite directions share an axis."""
    wrench = cycles_of(np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]), cycles=2)
    states = played(medium_robot(), runs=1, wrench=[wrench])
    cycles = find_load_cycles(states)
    words = [BRANCH_NAMES[b] for b in cycles.branch]
    assert words[:5] == ["unloaded", "loading", "peak", "unloading", "unloaded"]
    assert cycles.direction[1] == cycles.direction[5] != cycles.direction[9]
    assert cycles.axis[1] == cycles.axis[9]
    assert cycles.cycle[[1, 5, 9, 13]].tolist() == [1, 2, 1, 2]
    assert cycles.first.nonzero()[0].tolist() == [1]


def test_repeats_are_like_states_of_different_cycles() -> None:
    """Loads that miss their mark by 3 % still repeat each other; branches are not mixed."""
    states = played(medium_robot(), runs=3, load_scatter=0.03)
    cycles = find_load_cycles(states)
    groups = repeat_groups(states, cycles)
    # per run and direction: peak, unloading, unloaded; the first loading has no second to repeat but the next one
    assert len(groups) == 3 * 3 * 3
    for group in groups:
        assert len(set(cycles.branch[group])) == 1
        assert len(set(cycles.cycle[group])) == len(group)
        assert len(set(states.run[group])) == 1


def test_cycles_that_do_not_pass_zero() -> None:
    """A load that swings between half and full begins a new cycle each time it turns up."""
    levels = np.array([0.0, 0.5, 1.0, 0.5, 1.0, 0.5, 1.0, 0.0]) * 300.0
    wrench = np.zeros((len(levels), 6))
    wrench[:, 1] = levels
    cycles = find_load_cycles(played(medium_robot(), runs=1, wrench=[wrench]))
    assert [BRANCH_NAMES[b] for b in cycles.branch[1:7]] == [
        "loading",
        "peak",
        "unloading",
        "peak",
        "unloading",
        "peak",
    ]
    assert cycles.cycle[1:7].tolist() == [1, 1, 1, 2, 2, 3]


def test_states_that_are_alone_in_their_run() -> None:
    """A load that is the only state of its run is the peak of its one cycle; without a load there is none."""
    wrench = np.zeros((4, 6))
    wrench[1, :3] = [0.0, 30.0, -40.0]
    wrench[2, 3:] = [6.0, 0.0, 8.0]
    cycles = find_load_cycles(replace(bare_states([0, 1, 2, 3]), wrench=wrench))
    np.testing.assert_allclose(cycles.magnitude, [0.0, 50.0, 10.0, 0.0])
    assert [BRANCH_NAMES[b] for b in cycles.branch] == ["unloaded", "peak", "peak", "unloaded"]
    assert cycles.cycle.tolist() == [0, 1, 1, 0]
    assert cycles.direction.tolist() == cycles.axis.tolist() == cycles.last_direction.tolist() == [-1, 0, 0, -1]
    assert not cycles.first.any()

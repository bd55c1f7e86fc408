"""What is left out together of clamped runs: positions of a joint, or its cycles where positions are few."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Booleans
from stiffcal.identification.derivatives.observation import Observations, observe
from stiffcal.identification.readings.observations import WrenchCorrection
from stiffcal.identification.readings.row_layout import MOTOR
from stiffcal.kinds.clamped.states.folds import LEAST_POSITIONS, cycles
from stiffcal.measurements.load_states import members_of
from stiffcal.validation.heldout import search_folds, validation_folds
from tests.laboratory.clamped_bench import CYCLE, clamped_bench
from tests.laboratory.robots import six_axes, six_axis_joints

CHAIN = six_axes()
FIXTURE = np.diag([1e-9] * 3 + [1e-9] * 3)


def observed(positions: int, moved: tuple[int, ...]) -> Observations:
    """Return clamped runs, two cycles each: every moved joint in every position."""
    poses = six_axis_joints(np.random.default_rng(8), positions)
    return observe(clamped_bench(CHAIN, poses, moved, FIXTURE), CHAIN)


def motor_rows(data: Observations) -> Booleans:
    """Return (m, 1) True for the rows of motor angles."""
    return np.isin(np.arange(len(data.measured)), data.rows_of(MOTOR))[:, None]


def of_runs(data: Observations) -> list[list[int]]:
    """Return the folds of each run, in order of their first state."""
    fold = search_folds(data)
    return [list(dict.fromkeys(fold[members].tolist())) for members in members_of(data.run)]


def test_each_position_is_a_fold_where_there_are_five() -> None:
    folds = of_runs(observed(LEAST_POSITIONS, (2,)))
    assert len(folds) == LEAST_POSITIONS
    assert all(len(run) == 1 for run in folds)
    assert len({fold for run in folds for fold in run}) == LEAST_POSITIONS


def test_each_cycle_is_a_fold_where_positions_are_fewer() -> None:
    data = observed(LEAST_POSITIONS - 1, (2,))
    folds = of_runs(data)
    assert len(folds) == LEAST_POSITIONS - 1
    # turns at 1/4, 3/4, 5/4 and 7/4 of a period: the way to the first, two half sweeps, two half sweeps
    assert [len(run) for run in folds] == [3] * len(folds)
    assert len({fold for run in folds for fold in run}) == 3 * len(folds)


def test_joints_moved_in_one_position_do_not_share_a_fold() -> None:
    """They are at one pose, which is one fold of load runs."""
    folds = of_runs(observed(LEAST_POSITIONS, (2, 3)))
    assert [len(run) for run in folds] == [1] * 2 * LEAST_POSITIONS
    assert len({fold for run in folds for fold in run}) == 2 * LEAST_POSITIONS


def test_positions_count_by_joint() -> None:
    """Five runs of joint 2 are left out whole, next to four of joint 3 that are left out by cycles."""
    data = observed(LEAST_POSITIONS, (2, 3))
    data = data.subset(data.run != data.run[-1])
    assert [len(run) for run in of_runs(data)] == [1, 3] * 4 + [1]


def test_no_fold_holds_states_of_clamped_and_of_load_runs() -> None:
    """All are in one pose; folds are numbered without a gap, those of loads first."""
    data = observed(2, (2,))
    first = data.run == data.run[0]
    kinds = ["load" if number == data.run[0] else "clamped" for number in range(int(data.run.max()) + 1)]
    data = replace(data, run_kinds=tuple(kinds))
    fold = search_folds(data)
    assert set(fold[first]) == {0}
    assert sorted(set(fold.tolist())) == [0, 1, 2, 3]
    assert validation_folds(data)[1].tolist() == fold.tolist()


def test_correcting_wrenches_for_a_model_leaves_the_folds() -> None:
    """Models are compared over the same folds, so a correction that moves a turn must not move a cycle's end."""
    data = observed(LEAST_POSITIONS - 1, (2,))
    rng = np.random.default_rng(3)
    rows = np.where(motor_rows(data), 0.5 * np.ptp(data.measured) * rng.standard_normal(data.measured.shape), 0.0)
    none = np.zeros(data.n_states)
    corrected = data.corrected(
        WrenchCorrection(np.zeros_like(data.wrench), np.zeros_like(data.wrench), rows, none, none)
    )
    assert not np.array_equal(corrected.measured, data.measured)
    assert search_folds(corrected).tolist() == search_folds(data).tolist()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_cycle_is_two_half_sweeps_after_the_way_to_the_first_turn(sign: float) -> None:
    """A turn belongs to the half sweep that it ends, as a play has not begun to be crossed there."""
    turns = sign * np.array([0.0, 1.0, -1.0, 1.0, -1.0, 0.0])
    angle = np.interp(np.arange(51.0), np.arange(6) * 10.0, turns)
    # turns at 10, 20, 30 and 40
    assert cycles(angle).tolist() == [0] * 11 + [1] * 20 + [2] * 20


def test_small_steps_back_are_no_turn() -> None:
    """The angle goes back by 0.4 of 2.5 again and again, a sixth of the span; 0.35 of it would be a turn."""
    angle = np.interp(np.arange(51.0), np.arange(6) * 10.0, [0.0, 1.0, -1.0, 1.0, -1.0, 0.0])
    shaken = angle + np.where(np.arange(51) % 2, 0.25, -0.25)
    assert cycles(shaken).max() == cycles(angle).max() == 2


def test_a_stroke_one_way_is_one_cycle() -> None:
    assert cycles(np.linspace(0.0, 1.0, 9)).tolist() == [0] * 9
    assert cycles(1e-3 * CYCLE).max() == 1

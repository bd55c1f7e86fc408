"""Which parameters a plan can identify, and the order of measuring."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.planning.choice import choose_runs, identifiable, short_order
from stiffcal.planning.criterion import Criterion


def test_parameters_that_make_up_for_each_other_are_not_identified() -> None:
    factors = 10.0 * np.random.default_rng(0).normal(size=(30, 2, 4))
    factors[:, :, 3] = 2.0 * factors[:, :, 1]
    free, identified = identifiable(factors, None)
    assert np.count_nonzero(free) == 3
    assert identified.tolist() == [True, False, True, False]


def test_columns_that_agree_to_a_thousandth_are_not_distinguished() -> None:
    """The rule is the fit's: a number from such a difference would be an artefact with an error bar."""
    rng = np.random.default_rng(0)
    factors = 1e6 * rng.normal(size=(30, 2, 3))
    factors[:, :, 2] = factors[:, :, 1] * (1.0 + 2e-4 * rng.normal(size=(30, 2)))
    free, identified = identifiable(factors, None)
    assert free.tolist() == [True, True, False]
    assert identified.tolist() == [True, False, False]
    # what was known before counts
    assert identifiable(factors, np.diag([0.0, 1e14, 0.0]))[1].all()


def test_what_no_run_shows_is_left_out_of_the_choice() -> None:
    factors = 10.0 * np.random.default_rng(0).normal(size=(30, 2, 3))
    factors[:, :, 2] *= 1e-6
    choice = choose_runs(factors, 6, Criterion.WORST)
    assert choice is not None
    assert choice.identified.tolist() == [True, True, False]
    assert choice.design.covariance.shape == (2, 2)
    assert choose_runs(1e-6 * factors, 6, Criterion.WORST) is None


def test_a_parameter_that_so_few_runs_cannot_show_does_not_decide() -> None:
    factors = 10.0 * np.random.default_rng(0).normal(size=(200, 1, 3))
    factors[:, :, 2] *= 0.02
    without = choose_runs(factors[:, :, :2], 6, Criterion.WORST)
    choice = choose_runs(factors, 6, Criterion.WORST)
    assert choice is not None
    assert without is not None
    assert choice.free.all()
    assert choice.identified.tolist() == [True, True, False]
    assert np.diagonal(choice.design.covariance)[2] > 1.0
    worst = np.diagonal(choice.design.covariance)[:2].max()
    assert worst < 1.3 * np.diagonal(without.design.covariance).max()


@pytest.mark.parametrize("criterion", [Criterion.WORST, Criterion.DETERMINANT])
def test_parameters_that_are_no_goal_take_no_run_of_their_own(criterion: Criterion) -> None:
    """A knee that alone some runs show, which show nothing else: it stays in the fit, and in no run's place."""
    factors = 10.0 * np.random.default_rng(0).normal(size=(40, 1, 3))
    factors[:20, :, 2] = 0.0
    factors[20:, :, :2] *= 1e-3
    every = choose_runs(factors, 6, criterion)
    aimed = choose_runs(factors, 6, criterion, named=np.array([True, True, False]))
    assert every is not None
    assert aimed is not None
    assert aimed.free.all()
    assert (every.design.chosen >= 20).any()
    assert (aimed.design.chosen < 20).all()


def test_the_order_has_short_moves() -> None:
    joints = np.array([[0.0], [3.0], [1.0], [2.0], [0.0]])
    assert short_order(joints).tolist() == [0, 4, 2, 3, 1]

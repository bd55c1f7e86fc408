"""Exact designs by exchange, and the bound of the relaxed optimum."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.planning import design
from stiffcal.planning.criterion import Criterion, losses_after
from stiffcal.planning.design import VAGUE, best_design, compressed, information, loss_of, relaxed_optimum


def random_factors(n: int, rows: int, p: int, seed: int = 3) -> Floats:
    rng = np.random.default_rng(seed)
    return np.asarray(10.0 * rng.normal(size=(n, rows, p)))


WANTED = np.random.default_rng(5).normal(size=(7, 3))


CRITERIA = [
    pytest.param(Criterion.DETERMINANT, None, id="determinant"),
    pytest.param(Criterion.DETERMINANT, np.eye(3)[[0, 2]], id="determinant of some"),
    pytest.param(Criterion.WORST, None, id="worst"),
    pytest.param(Criterion.WORST, np.eye(3)[[0, 2]], id="worst of some"),
    pytest.param(Criterion.PREDICTION, WANTED, id="prediction"),
]


def every_loss(factors: Floats, n_runs: int, criterion: Criterion, wanted: Floats | None) -> Floats:
    """Return the loss of every design there is."""
    start = np.eye(factors.shape[2]) / VAGUE**2
    matrices = information(factors)
    designs = combinations_with_replacement(range(len(factors)), n_runs)
    return np.array(
        [loss_of(np.linalg.inv(start + matrices[list(one)].sum(axis=0)), criterion, wanted) for one in designs]
    )


@pytest.mark.parametrize(("criterion", "wanted"), CRITERIA)
@pytest.mark.parametrize("seed", range(4))
def test_the_design_is_the_best_there_is_or_next_to_it(criterion: Criterion, wanted: Floats | None, seed: int) -> None:
    factors = random_factors(10, 1, 3, seed)
    found = best_design(factors, 4, criterion, wanted=wanted)
    losses = every_loss(factors, 4, criterion, wanted)
    assert found.loss >= losses.min() * (1.0 - 1e-9)
    # of 715 designs at most two are better
    assert np.count_nonzero(losses < found.loss * (1.0 - 1e-9)) <= 2


@pytest.mark.parametrize(("criterion", "wanted"), CRITERIA)
def test_no_design_undercuts_the_bound(criterion: Criterion, wanted: Floats | None) -> None:
    factors = random_factors(9, 1, 3)
    rows = design.wanted_rows(criterion, 3, wanted)
    _, _, bound = relaxed_optimum(factors, 5, criterion, np.eye(3) / VAGUE**2, rows)
    least = every_loss(factors, 5, criterion, wanted).min()
    # and not far below: five runs round the weights
    assert 0.8 * least < bound <= least * (1.0 + 1e-9)
    found = best_design(factors, 5, criterion, wanted=wanted)
    assert found.efficiency == pytest.approx((bound / found.loss) ** 2, rel=1e-3)


@pytest.mark.parametrize(("criterion", "wanted"), CRITERIA)
def test_many_runs_reach_the_relaxed_optimum(criterion: Criterion, wanted: Floats | None) -> None:
    found = best_design(random_factors(60, 2, 3), 200, criterion, wanted=wanted)
    assert 0.985 < found.efficiency <= 1.0


def test_the_determinant_of_a_line_takes_its_ends() -> None:
    """A straight line through [-1, 1] is known best from readings at both ends (Atkinson et al. 2007, section 5.2)."""
    x = np.linspace(-1.0, 1.0, 21)
    factors = 10.0 * np.stack([np.ones_like(x), x], axis=1)[:, None]
    found = best_design(factors, 6, Criterion.DETERMINANT)
    assert sorted(x[found.chosen]) == pytest.approx([-1.0] * 3 + [1.0] * 3)
    assert found.efficiency == pytest.approx(1.0, abs=0.01)


def test_the_determinant_of_a_parabola_takes_ends_and_middle() -> None:
    """Atkinson et al. 2007, table 11.1: a third of the readings at each of -1, 0 and 1."""
    x = np.linspace(-1.0, 1.0, 21)
    factors = 10.0 * np.stack([np.ones_like(x), x, x**2], axis=1)[:, None]
    found = best_design(factors, 9, Criterion.DETERMINANT)
    assert sorted(x[found.chosen].round(9)) == pytest.approx([-1.0] * 3 + [0.0] * 3 + [1.0] * 3)


def test_repeats_are_limited() -> None:
    factors = random_factors(12, 1, 3)
    free, once = (best_design(factors, 12, Criterion.WORST, limit=limit) for limit in (None, 1))
    assert sorted(once.chosen) == list(range(12))
    assert np.bincount(free.chosen).max() > 1
    assert free.loss < once.loss


def test_what_is_known_already_is_not_measured_again() -> None:
    factors = 10.0 * np.eye(3)[:, None]
    known = np.diag([1e6, 0.0, 0.0])
    found = best_design(factors, 4, Criterion.WORST, known)
    assert sorted(found.chosen) == [1, 1, 2, 2]


def test_the_course_ends_in_the_covariance() -> None:
    found = best_design(random_factors(30, 2, 4), 8, Criterion.WORST)
    np.testing.assert_allclose(found.course[-1], np.sqrt(np.diagonal(found.covariance)))
    assert (np.diff(found.course, axis=0) <= 1e-12).all()


def test_compressing_keeps_the_information() -> None:
    thin = random_factors(20, 2, 5)
    thick = np.concatenate([thin, 0.3 * thin, -2.0 * thin], axis=1)
    small = compressed(thick)
    assert small.shape == (20, 2, 5)
    np.testing.assert_allclose(information(small), information(thick), rtol=1e-9, atol=1e-9)


def test_the_update_of_rank_r_is_the_inverse() -> None:
    factors = random_factors(6, 2, 4)
    matrix = np.eye(4)
    covariance: Floats = np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    some = np.eye(4)[[0, 2, 3]]
    for criterion, rows in [
        *((criterion, np.eye(4)) for criterion in Criterion),
        (Criterion.PREDICTION, np.random.default_rng(1).normal(size=(4, 4))),
        *((criterion, some) for criterion in Criterion),
    ]:
        fast = losses_after(factors, covariance, criterion, rows)
        covariances = [np.linalg.inv(matrix + factor.T @ factor) for factor in factors]
        slow = [np.log(design.value_of(after, criterion, rows)) for after in covariances]
        np.testing.assert_allclose(fast, slow, atol=1e-6 + 1e-6 * (criterion is Criterion.WORST))


def test_nothing_to_choose_from_is_refused() -> None:
    with pytest.raises(ValueError, match="candidates"):
        best_design(np.zeros((0, 1, 2)), 3, Criterion.WORST)
    with pytest.raises(ValueError, match="rows"):
        best_design(random_factors(3, 1, 2), 3, Criterion.PREDICTION)

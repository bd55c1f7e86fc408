"""Fits without each fold are those that are made from the other rows alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from stiffcal.arrays import Floats, Integers
from stiffcal.estimation.leave_out import LeaveOut


def drawn(rng: np.random.Generator) -> LeaveOut:
    """Return a small problem: folds of one to many rows, some in none, bounds, some unknowns on them, and priors."""
    p, n = int(rng.integers(1, 6)), int(rng.integers(12, 60))
    columns = rng.normal(size=(p, n)) * 10.0 ** rng.uniform(-4, 4, (p, 1))
    truth = rng.normal(size=p) / np.linalg.norm(columns, axis=1) * 3.0
    wanted = truth @ columns + rng.normal(size=n)
    size = 1.0 / np.linalg.norm(columns, axis=1)
    lower = np.where(rng.random(p) < 0.5, -rng.random(p) * size, -np.inf)
    upper = np.where(rng.random(p) < 0.3, rng.random(p) * size, np.inf)
    lower = np.where(rng.random(p) < 0.2, 0.0, lower)
    r = int(rng.integers(0, 3))
    prior = np.concatenate([rng.normal(size=(r, p)) / size, rng.normal(size=(r, 1))], axis=1)
    fold = rng.integers(0, rng.integers(2, 9), n)
    if rng.random() < 0.3:
        fold = np.arange(n)  # single rows
    elif rng.random() < 0.3:
        # the first unknown is measured by one fold alone, or nearly so
        columns[0, fold != 0] *= float(rng.choice([0.0, 1e-7]))
    folds = [np.flatnonzero(fold == number) for number in np.unique(fold) if number != 7]
    return LeaveOut(np.vstack([columns, wanted]), folds, prior, lower, upper)


def with_candidates(problem: LeaveOut, rng: np.random.Generator) -> LeaveOut:
    """Return the problem with one or two candidates' columns, some of them bounded, and what comes with them."""
    q, n = int(rng.integers(1, 3)), problem.white.shape[1]
    columns = rng.normal(size=(q, n)) * 10.0 ** rng.uniform(-4, 4, (q, 1))
    if rng.random() < 0.3:  # much alike an unknown of the model
        columns[0] = problem.white[0] * (1.0 + 1e-3 * rng.normal(size=n))
    lower = np.where(rng.random(q) < 0.5, 0.0, -np.inf)
    return problem.with_columns(columns, lower, np.full(q, np.inf), rng.normal(0.0, 0.3, size=(n,)))


def refit(problem: LeaveOut, kept: Integers) -> tuple[Floats, float]:
    """Return what scipy finds of some rows and the prior, and by how many standard errors it may be off."""
    matrix = np.vstack([problem.white[:-1, kept].T, problem.prior[:, :-1]])
    wanted = np.append(problem.white[-1, kept], problem.prior[:, -1])
    scale = np.linalg.norm(matrix, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    answer = lsq_linear(
        matrix / scale, wanted, (problem.lower * scale, problem.upper * scale), method="bvls", tol=1e-15
    )
    return answer.x / scale, float(np.sum((matrix @ (answer.x / scale) - wanted) ** 2))


def squares(problem: LeaveOut, kept: Integers, x: Floats) -> float:
    matrix = np.vstack([problem.white[:-1, kept].T, problem.prior[:, :-1]])
    return float(np.sum((matrix @ x - np.append(problem.white[-1, kept], problem.prior[:, -1])) ** 2))


def test_two_hundred_problems_against_plain_refits() -> None:
    rng = np.random.default_rng(39)
    deleted = 0
    for number in range(200):
        problem = drawn(rng)
        if number % 2:
            problem = with_candidates(problem, rng)
        deleted += int(problem._by_deletion()[1].sum())
        every = np.arange(problem.white.shape[1])
        for step, fold in zip(problem.steps[:6], problem.folds[:6], strict=False):
            kept = np.setdiff1d(every, fold)
            expected, least = refit(problem, kept)
            assert np.all((step >= problem.lower) & (step <= problem.upper))
            # of dependent unknowns many answers leave as little
            assert squares(problem, kept, step) <= least * (1.0 + 1e-9) + 1e-9
            matrix = np.vstack([problem.white[:-1, kept].T, problem.prior[:, :-1]])
            scale = np.linalg.norm(matrix, axis=0)
            if scale.all() and np.linalg.cond(matrix / scale) < 1e6:
                np.testing.assert_allclose(step * scale, expected * scale, atol=1e-7)
    assert deleted > 500  # the formula answers most, not the refits that it falls back on


@pytest.mark.parametrize("p", [0, 2])
def test_rows_left_out_and_columns_added(p: int) -> None:
    rng = np.random.default_rng(5)
    white = rng.normal(size=(p + 1, 30))
    folds = [np.arange(k, 24, 4) for k in range(4)]  # six rows are in no fold
    infinite = np.full(p, np.inf)
    known = rng.normal(size=(p, p + 1))
    problem = LeaveOut(white, folds, known, -infinite, infinite)
    added, fixed = rng.normal(size=(1, 30)), rng.normal(size=30)
    more = problem.with_columns(added, np.zeros(1), np.full(1, np.inf), fixed)
    # the same by hand: of the candidate nothing is known before, and it comes with a part of the readings
    columns, wanted = np.vstack([white[:-1], added]), white[-1] - fixed
    by_hand = LeaveOut(
        np.vstack([columns, wanted]), folds, np.insert(known, p, 0.0, axis=1),
        np.append(-infinite, 0.0), np.append(infinite, np.inf),
    )  # fmt: skip
    for fold in folds:
        expected, _ = refit(by_hand, np.setdiff1d(np.arange(30), fold))
        np.testing.assert_allclose(more.residual[fold], wanted[fold] - expected @ columns[:, fold], atol=1e-12)
    assert problem.steps.shape == (4, p)
    expected, least = refit(by_hand, np.arange(30))
    np.testing.assert_allclose(more.solution, expected, atol=1e-12)
    assert more.sum_of_squares == pytest.approx(least)


def test_what_one_fold_alone_determines() -> None:
    rng = np.random.default_rng(6)
    white = rng.normal(size=(3, 12))
    white[1, 4:] = 0.0
    infinite = np.full(2, np.inf)
    problem = LeaveOut(white, [np.arange(4), np.arange(4, 8), np.arange(8, 12)], np.zeros((0, 3)), -infinite, infinite)
    assert problem.determined(1).tolist() == [False, True, True]
    assert problem.determined(0).tolist() == [True, True, True]
    assert problem.steps[0, 1] == 0.0


def test_the_spread_of_what_a_fit_without_its_fold_leaves() -> None:
    rng = np.random.default_rng(8)
    columns = rng.normal(size=(3, 14)) * np.array([[1e-3], [1.0], [1e4]])
    columns[2, 1:] = 0.0  # by the first row alone
    folds = [np.array([0]), np.array([1]), np.array([2, 5]), np.arange(6, 14)]
    free = np.full(3, np.inf)
    prior = np.array([[0.0, 2.0, 0.0, 0.0]])
    problem = LeaveOut(np.vstack([columns, np.zeros(14)]), folds, prior, -free, free)
    assert np.isinf(problem.spread[0])
    assert np.isnan(problem.spread[3:5]).all()  # in no fold
    for fold in folds[1:]:
        kept = np.setdiff1d(np.arange(14), fold)
        matrix = np.vstack([columns[:, kept].T, prior[:, :-1]])
        covariance = np.eye(len(fold)) + columns[:, fold].T @ np.linalg.inv(matrix.T @ matrix) @ columns[:, fold]
        np.testing.assert_allclose(problem.spread[fold], np.sqrt(np.diag(covariance)), rtol=1e-9)

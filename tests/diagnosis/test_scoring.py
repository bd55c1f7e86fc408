"""The batched solves of the diagnosis against plain least squares."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from stiffcal.diagnosis.scoring import fold_products, quadratic, score_variants, solve_within


@pytest.mark.parametrize("seed", range(5))
def test_bounded_solution_is_the_best_within_bounds(seed: int) -> None:
    """Against scipy's bounded least squares; the active set without going back may stop a little above it."""
    rng = np.random.default_rng(seed)
    columns, target = rng.normal(size=(60, 5)), rng.normal(size=60)
    lower = np.array([-np.inf, -np.inf, 0.0, 0.0, 0.0])
    upper = np.full(5, np.inf)
    found = solve_within(columns.T @ columns, columns.T @ target, lower, upper)
    best = lsq_linear(columns, target, bounds=(lower, upper)).x
    assert np.all(found >= lower)
    assert np.sum((columns @ found - target) ** 2) <= 1.02 * np.sum((columns @ best - target) ** 2)


def test_leaving_folds_out_equals_refitting() -> None:
    """Unseen squares from inner products are those of fits really made without the fold."""
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(4, 120))
    folds = [np.arange(k, 120, 6) for k in range(6)]
    score = score_variants([fold_products(rows, folds)], np.full(3, -np.inf), np.full(3, np.inf), np.arange(6))
    for number, fold in enumerate(folds):
        rest = np.setdiff1d(np.arange(120), fold)
        x, *_ = np.linalg.lstsq(rows[:3, rest].T, rows[3, rest], rcond=None)
        left = rows[3, fold] - x @ rows[:3, fold]
        assert score.unseen[number] == pytest.approx(float(left @ left), rel=1e-6)
        assert np.allclose(score.without[number], x, rtol=1e-6)
    assert np.allclose(np.diagonal(score.nested), score.unseen, rtol=1e-6)


def test_the_shape_is_chosen_without_the_fold_it_is_judged_on() -> None:
    """Of two variants the one that is better on the rest is judged, also where the other suits the fold better."""
    rng = np.random.default_rng(2)
    truth, noise = rng.normal(size=90), 0.01 * rng.normal(size=90)
    residual = truth + noise
    folds = [np.arange(30), np.arange(30, 60), np.arange(60, 90)]
    tempting = rng.normal(size=90)
    tempting[:30] = residual[:30]  # perfect on the first fold, useless elsewhere
    products = [fold_products(np.stack([column, residual]), folds) for column in (truth, tempting)]
    score = score_variants(products, np.array([-np.inf]), np.array([np.inf]), np.arange(3))
    assert score.variant == 0
    assert score.unseen[0] == pytest.approx(float(noise[:30] @ noise[:30]), rel=0.2)


def test_quadratic_is_the_sum_of_squares() -> None:
    """|r − x·c|² from inner products."""
    rng = np.random.default_rng(3)
    rows, x = rng.normal(size=(3, 40)), np.array([0.3, -1.2])
    left = rows[2] - x @ rows[:2]
    assert quadratic(rows @ rows.T, x) == pytest.approx(float(left @ left))

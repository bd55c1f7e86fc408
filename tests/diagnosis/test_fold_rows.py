"""Folds of few rows: leaving each out by a change of small rank, against solving each by itself."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.diagnosis.scoring import FoldRows, fold_products, rows_by_fold, score_variants


@pytest.mark.parametrize("bounded", [False, True])
def test_a_fold_of_few_rows_is_left_out_as_any_other(bounded: bool) -> None:
    """With a bound that is met without some folds, a column of one fold alone, and folds of unlike size."""
    rng = np.random.default_rng(11)
    n, k = 303, 12
    rows = rng.normal(size=(k + 1, n))
    rows[-1] += 0.4 * rows[0] + 0.3 * rows[1]
    sizes = [3] * 90 + [1, 2, 6, 9, 15]
    folds = np.split(np.arange(n), np.cumsum(sizes)[:-1])
    rows[5] = 0.0
    rows[5, folds[7]] = [1.0, -2.0, 0.5]  # only pose 7 moves this parameter
    groups, lower, upper = np.arange(len(folds)) % 10, np.full(k, -np.inf), np.full(k, np.inf)
    if bounded:
        lower[2:5] = 0.0  # their values are zero but for noise
        # bounds just below and just above the best value: without some folds it meets one, and leaves the other
        best = score_variants([fold_products(rows, folds)], lower, upper, groups).solution
        lower[0], lower[1] = best[0] - 1e-4, best[1] + 1e-4
    exact = score_variants([fold_products(rows, folds)], lower, upper, groups)
    by_rows = rows_by_fold(rows, [slice(int(fold[0]), int(fold[-1]) + 1) for fold in folds])
    assert isinstance(by_rows, FoldRows)
    quick = score_variants([by_rows], lower, upper, groups)
    on_bound = exact.without <= lower
    assert not bounded or np.any(on_bound.any(axis=0) & ~on_bound.all(axis=0))
    for name in ("sum_of_squares", "heldout", "nested", "solution", "without", "prediction_change", "normal"):
        assert np.allclose(getattr(quick, name), getattr(exact, name), rtol=1e-7, atol=1e-9), name
    assert quick.without[7, 5] == 0.0

"""Folds of few rows: leaving each out by a change of small rank, against solving each by itself."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from stiffcal.diagnosis.scans.few_rows import AddedColumns, FewRows
from stiffcal.diagnosis.scans.folds import FoldProducts, inner_outside
from stiffcal.diagnosis.scans.scan import Scan, Trial, helped
from stiffcal.diagnosis.scans.scoring import score_variants


@pytest.mark.parametrize("n_added", [0, 1, 3])
@pytest.mark.parametrize("bounded", [False, True])
def test_a_fold_of_few_rows_is_left_out_as_any_other(bounded: bool, n_added: int) -> None:
    """With bounds that are met without some folds, a column of one fold alone, and folds of unlike size."""
    rng = np.random.default_rng(11)
    n, k = 303, 12
    rows = rng.normal(size=(k + 1, n))
    rows[-1] += 0.4 * rows[0] + 0.3 * rows[1] + 0.2 * rows[k - 1]
    sizes = [3] * 90 + [1, 2, 6, 9, 15]
    cuts = [slice(int(end) - size, int(end)) for end, size in zip(np.cumsum(sizes), sizes, strict=True)]
    rows[5] = 0.0
    rows[5, cuts[7]] = [1.0, -2.0, 0.5]  # only pose 7 moves this parameter
    groups, lower, upper = np.arange(len(cuts)) % 10, np.full(k, -np.inf), np.full(k, np.inf)
    if bounded:
        lower[[2, 3, 4, 10]] = 0.0  # their values are zero but for noise
        # bounds just below and just above the best value: without some folds it meets one, and leaves the other
        best = score_variants([FoldProducts.of(rows, cuts)], lower, upper, groups).solution
        lower[0], lower[1], lower[11] = best[0] - 1e-4, best[1] + 1e-4, best[11] - 1e-4
    base_rows = np.concatenate([rows[: k - n_added], rows[-1:]])
    first = slice(0, k - n_added)
    # what is known before of some of the base model's parameters
    outside = np.zeros((3, k - n_added + 1))
    outside[[0, 1, 2, 2, 2], [0, 5, 6, 7, -1]] = [3.0, 0.1, 4.0, 2.0, 1.5]
    known = [inner_outside(outside, k - added) for added in (n_added, 0)]
    few = FewRows.of(base_rows[:-1], cuts, outside)
    assert few is not None
    bases = [
        score_variants([variant], lower[first], upper[first], groups)
        for variant in (FoldProducts.of(base_rows, cuts, known[0]), AddedColumns.of(few, base_rows[-1:]))
    ]
    exact = score_variants([FoldProducts.of(rows, cuts, known[1])], lower, upper, groups, bases[0])
    added = AddedColumns.of(few, rows[k - n_added :])
    quick = score_variants([added], lower, upper, groups, bases[1])
    assert exact.left.without is not None
    assert exact.left.without[7, 5] == 0.0
    on_bound = exact.left.without <= lower
    assert not bounded or np.any(on_bound.any(axis=0) & ~on_bound.all(axis=0))
    for name in ("sum_of_squares", "heldout", "nested", "solution", "prediction_change", "normal"):
        assert np.allclose(getattr(quick, name), getattr(exact, name), rtol=1e-7, atol=1e-9), name
    for name in ("residual", "rest"):
        assert np.allclose(getattr(quick.left, name), getattr(exact.left, name), rtol=1e-7, atol=1e-9), name


def test_a_column_that_the_base_model_holds_already_adds_nothing() -> None:
    """A law that contains one of the model's own: both share what they explain, and the poses left out stay as well."""
    rng = np.random.default_rng(5)
    rows = rng.normal(size=(12, 240))
    cuts = [slice(k, k + 3) for k in range(0, 240, 3)]
    groups, free = np.arange(80) % 10, np.full(12, np.inf)
    few = FewRows.of(rows[:-1], cuts)
    assert few is not None
    base = score_variants([AddedColumns.of(few, rows[-1:])], -free[:11], free[:11], groups)
    twice = score_variants([AddedColumns.of(few, np.stack([2.0 * rows[3], rows[-1]]))], -free, free, groups, base)
    assert np.allclose(twice.heldout, base.heldout, rtol=1e-5)
    assert np.allclose(twice.nested, base.nested, rtol=1e-5)
    assert np.allclose(twice.prediction_change, 0.0, atol=1e-6)


def test_an_error_that_falls_by_rounding_alone_does_not_fall() -> None:
    base, score = (SimpleNamespace(heldout=np.array(values)) for values in ([2.0, 2.0, 2.0], [2.0, 2.0 - 1e-12, 1.9]))
    scan, trial = cast(Scan, SimpleNamespace(base=base)), cast(Trial, SimpleNamespace(score=score))
    assert helped(scan, trial).tolist() == [False, False, True]

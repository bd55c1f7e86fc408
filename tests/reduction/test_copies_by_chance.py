"""The one account of how probable it is that readings look like copies."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.stats import hypergeom

from stiffcal.reduction.copies.by_chance import probability_of_as_many


def test_it_is_the_tail_of_drawing_each_row_once() -> None:
    rng = np.random.default_rng(0)
    for _ in range(300):
        rows, others = rng.integers(1, 60, 2)
        alike, by_chance = rng.integers(0, rows + 1), rng.integers(0, others + 1)
        expected = hypergeom.sf(alike - 1, rows + others, alike + by_chance, rows)
        found = probability_of_as_many(int(alike), int(rows), int(by_chance), int(others))
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-12)


def test_a_hundred_thousand_rows_are_no_more_work() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert probability_of_as_many(9, 100_000, 90_000, 900_000) == pytest.approx(1.0)
        assert probability_of_as_many(100_000, 100_000, 0, 900_000) < 1e-300
        assert 1e-12 < probability_of_as_many(10_500, 100_000, 90_000, 900_000) < 1e-3

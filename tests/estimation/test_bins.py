"""Means of neighbouring readings, and their noise."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.estimation.bins import Bins, noise_of_mean

PART = np.repeat([1, 2], [40, 6])
STRETCH = np.concatenate([np.repeat([0, 1, 2], [24, 12, 4]), np.zeros(6, dtype=np.int64)])


def test_a_part_with_few_readings_stays_as_it_is_and_stretches_are_not_mixed() -> None:
    bins = Bins.of(PART, STRETCH, 10)
    of_first, of_second = bins.count[bins.number[PART == 1]], bins.count[bins.number[PART == 2]]
    assert set(of_second.tolist()) == {1}
    assert set(of_first.tolist()) == {4}
    for number in range(len(bins.count)):
        own = bins.number == number
        assert len(np.unique(STRETCH[own])) == len(np.unique(PART[own])) == 1
        assert np.ptp(np.flatnonzero(own)) == own.sum() - 1
    assert len(np.unique(bins.number[PART == 1])) == 10


def test_means_of_columns_are_columns_of_means() -> None:
    bins = Bins.of(PART, STRETCH, 10)
    rows = np.random.default_rng(1).normal(size=(3, 1, len(PART)))
    means = bins.means(rows)
    assert means.shape == (3, 1, len(bins.count))
    assert means[2, 0, 1] == pytest.approx(rows[2, 0, bins.number == 1].mean())
    single = Bins.of(PART, STRETCH, 100)
    assert single.means(rows) is rows
    assert bins.first.tolist() == [int(np.flatnonzero(bins.number == k)[0]) for k in range(len(bins.count))]


@pytest.mark.parametrize("correlation", [0.0, 0.6, -0.3])
def test_the_noise_of_a_mean_is_that_of_correlated_neighbours(correlation: float) -> None:
    steps = np.abs(np.subtract.outer(np.arange(7), np.arange(7)))
    exact = float(np.sqrt(np.mean(correlation**steps)))
    assert noise_of_mean(np.array([7]), correlation)[0] == pytest.approx(exact, rel=1e-9)
    bins = Bins(np.zeros(7, dtype=np.int64))
    assert bins.sigma(np.full(7, 2.0), correlation)[0] == pytest.approx(2.0 * exact, rel=1e-9)

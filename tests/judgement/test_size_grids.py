"""Sums over sizes along splines through their grids, against sums over grids a hundred times as fine."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.judgement.numbers import DISCREPANCIES, RUN_SIZES, SIZE_WEIGHTS, SIZES, UNLISTED_SIZES
from stiffcal.judgement.size_grids import log_sum, over_cells

MOST = 0.05
"""Nats: less than what a probability of one half moves by 0.01."""


def log_evidence(sizes: Floats, gram: Floats, square: Floats) -> Floats:
    """Return (s,) that of coefficients along their axes, by the squares that these show."""
    grown = sizes[:, None] ** 2 * gram
    return np.asarray(-0.5 * np.sum(np.log1p(grown) + square / (1.0 + grown), axis=1))


@pytest.mark.parametrize(
    ("sizes", "weights", "most"), [(SIZES, SIZE_WEIGHTS, 9), (UNLISTED_SIZES, None, 30), (RUN_SIZES, None, 30)]
)
def test_a_size_of_several_coefficients(sizes: Floats, weights: Floats | None, most: int) -> None:
    """On grids twice as coarse one of nine coefficients lost up to two nats where it lies between two points."""
    rng = np.random.default_rng(1)
    prior = np.zeros(len(sizes)) if weights is None else np.log(weights)
    half = 0.5 * np.log(sizes[1] / sizes[0])
    fine = np.linspace(np.log(sizes[0]) - half, np.log(sizes[-1]) + half, 4001)
    prior_there = np.zeros(len(fine)) if weights is None else -0.5 * (fine / np.log(5.0)) ** 2
    for _ in range(100):
        count = int(rng.integers(1, most + 1))
        gram = 10.0 ** rng.uniform(0.0, 2.0, count)
        true = np.exp(rng.uniform(*np.log(sizes[[len(sizes) // 4, -len(sizes) // 4]])))
        square = (1.0 + true**2 * gram) * rng.normal(size=count) ** 2
        found = log_sum((log_evidence(sizes, gram, square) + prior)[None]) - log_sum(prior[None])
        dense = np.logaddexp.reduce(log_evidence(np.exp(fine), gram, square) + prior_there)
        assert found == pytest.approx(dense - np.logaddexp.reduce(prior_there), abs=MOST)


def test_a_discrepancy_of_a_hundred_directions() -> None:
    """As a plain sum over the grid the evidence of a size between two of its points lost half a nat."""
    half = 0.5 * np.log(DISCREPANCIES[1] / DISCREPANCIES[0])
    fine = np.linspace(np.log(DISCREPANCIES[0]) - half, np.log(DISCREPANCIES[-1]) + half, 4001)
    directions = np.ones(100)
    off = []
    for true in np.geomspace(0.3, 6.0, 40):
        square = (1.0 + true**2) * directions
        at_grid = log_evidence(DISCREPANCIES, directions, square)
        found = np.logaddexp.reduce(over_cells(at_grid, [slice(0, len(at_grid))])) - np.log(len(at_grid))
        off.append(found - np.logaddexp.reduce(log_evidence(np.exp(fine), directions, square)) + np.log(len(fine)))
    assert np.max(np.abs(off)) < MOST


def test_few_sizes_are_those_that_they_are() -> None:
    assert log_sum(np.log([[0.25, 0.5, 0.25]])) == pytest.approx(0.0)

"""Like readings, against the table of all pairs."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Booleans, Floats
from stiffcal.reduction.copies.like_readings import FEW, LikeReadings, most_alike_from

STEP = 3.0


def readings(seed: int, near_levels: int = 60) -> Floats:
    """Return forces at a few levels, some of them in steps along one axis, and some at random."""
    rng = np.random.default_rng(seed)
    levels = rng.normal(scale=30.0, size=(4, 3))
    near = levels[rng.integers(4, size=near_levels)] + rng.normal(scale=0.5, size=(near_levels, 3))
    along = np.arange(30.0)[:, None] * [0.0, 0.7 * STEP, 0.0]
    return np.asarray(rng.permutation(np.concatenate([near, along, rng.normal(scale=5.0, size=(30, 3))])))


def pairs(force: Floats) -> Booleans:
    return np.asarray(np.linalg.norm(force[:, None] - force, axis=2) < STEP)


@pytest.mark.parametrize("near_levels", [60, 2 * FEW])
@pytest.mark.parametrize("seed", range(5))
def test_they_are_those_of_the_table_of_pairs(seed: int, near_levels: int) -> None:
    """Of few readings a table, of many a tree says which are alike."""
    force = readings(seed, near_levels)
    like, table = LikeReadings(force, STEP), pairs(force)
    assert like.counts.tolist() == table.sum(axis=1).tolist()
    assert all(like.of(k).tolist() == np.flatnonzero(table[k]).tolist() for k in range(len(force)))


def test_readings_far_from_each_other_have_none() -> None:
    like = LikeReadings(np.diag([300.0, 200.0, 300.0]), STEP)
    assert like.counts.tolist() == [1, 1, 1]
    assert like.of(2).tolist() == [2]


@pytest.mark.parametrize("seed", range(5))
def test_the_bound_is_one(seed: int) -> None:
    force = readings(seed)
    starts = np.array([0, 7, 8, 60, 119, 120])
    bound, table = most_alike_from(force, STEP, starts), pairs(force)
    exact = [int(table[start:, start:].sum(axis=1).max(initial=0)) for start in starts]
    assert (bound >= exact).all()
    assert bound[-2:].tolist() == [1, 0]
    # of levels that are further apart than three steps it is exact
    levels = 12.0 * STEP * np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])[np.arange(30) % 3] + 0.1
    assert most_alike_from(levels, STEP, np.array([0, 15])).tolist() == [10, 5]

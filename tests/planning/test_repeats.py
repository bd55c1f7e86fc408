"""Runs of a plan differ: near-copies count as one run."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.planning.criterion import Criterion
from stiffcal.planning.design import best_design
from stiffcal.planning.repeats import Repeats, TooAlikeError


def candidates(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return factors (3 n, 2, 3) and joints (3 n, 2) rad: each pose with two others within a degree of it."""
    rng = np.random.default_rng(seed)
    joints = np.repeat(rng.uniform(-1.0, 1.0, (n, 2)) * np.radians(160.0), 3, axis=0)
    joints += np.radians(0.3) * rng.standard_normal(joints.shape)
    factors = np.repeat(rng.standard_normal((n, 2, 3)) * rng.uniform(0.1, 5.0, (n, 1, 1)), 3, axis=0)
    return factors, joints


@pytest.mark.parametrize("criterion", [Criterion.WORST, Criterion.DETERMINANT])
def test_chosen_runs_differ_in_pose_or_load(criterion: Criterion) -> None:
    factors, joints = candidates(40)
    load, near = np.zeros(len(joints), dtype=np.int64), np.radians(10.0)
    chosen = best_design(factors, 8, criterion, limit=Repeats(1, joints, load, near)).chosen
    apart = np.abs(joints[chosen][:, None] - joints[chosen]).max(axis=2) + np.eye(8) * 10.0
    assert apart.min() > near
    free = best_design(factors, 8, criterion).chosen
    apart = np.abs(joints[free][:, None] - joints[free]).max(axis=2) + np.eye(8) * 10.0
    assert apart.min() < near


def test_a_whole_turn_is_no_other_pose_and_another_load_is_another_run() -> None:
    joints = np.radians([[0.0, 0.0], [360.0, 1.0], [0.0, 0.0], [0.0, 20.0]])
    repeats = Repeats(1, joints, np.array([0, 0, 1, 0]), np.radians(10.0))
    assert repeats.exhausted(np.array([0]), 4).tolist() == [True, True, False, False]
    assert repeats.kept([0, 1], 3, np.arange(4)).tolist() == [0, 2, 3]


def test_too_few_that_differ_are_an_error_with_their_number() -> None:
    factors, joints = candidates(2)
    with pytest.raises(TooAlikeError) as raised:
        best_design(
            factors, 5, Criterion.WORST, limit=Repeats(1, joints, np.zeros(6, dtype=np.int64), np.radians(10.0))
        )
    assert raised.value.found == 2

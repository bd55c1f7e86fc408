"""Configurations are sorted into poses as by comparing each with all, in time that grows with their number."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.fitting.identify import fit_problem
from stiffcal.measurements.load_states import members_of
from stiffcal.mechanics.like_poses import pose_groups
from stiffcal.reduction.registration.poses import different_poses
from stiffcal.validation.heldout import search_folds
from tests.laboratory.simulated_states import medium_robot, played

DEGREE = float(np.radians(1.0))


def compared_with_all(angles: Floats, tolerance: float) -> Integers:
    """Return the pose of each configuration by comparing it with the founder of every pose before."""
    found = np.full(len(angles), -1, dtype=np.int64)
    founders: list[int] = []
    for k in range(len(angles)):
        for number, founder in enumerate(founders):
            if np.max(np.abs(angles[k] - angles[founder])) < tolerance:
                found[k] = number
                break
        else:
            found[k] = len(founders)
            founders.append(k)
    return found


@settings(max_examples=60)
@given(
    st.integers(0, 2**32 - 1), st.integers(0, 80), st.integers(1, 7), st.sampled_from([0.3, 1.0, 3.0, 60.0])
)  # fmt: skip
def test_poses_are_those_of_comparing_each_with_all(seed: int, n: int, joints: int, spread: float) -> None:
    """Also for angles that lie whole degrees apart, where a grid's cells end, and however many joints move."""
    rng = np.random.default_rng(seed)
    angles = spread * rng.normal(size=(n, joints))
    angles = np.radians(np.concatenate([angles, np.round(angles), angles + 0.7 * rng.normal(size=angles.shape)]))
    assert np.array_equal(pose_groups(angles, DEGREE), compared_with_all(angles, DEGREE))


def test_runs_of_a_campaign_fall_into_these_poses() -> None:
    """The folds of states are those of their runs' angles."""
    robot = medium_robot()
    data = fit_problem(played(robot, runs=7), robot).data
    first = [members[0] for members in members_of(data.run)]
    expected = compared_with_all(data.angles[:, first].T, DEGREE)
    assert np.array_equal(search_folds(data), np.repeat(expected, np.bincount(data.run)))


@pytest.mark.parametrize("count", [pose_groups, lambda angles, _: different_poses(angles)])
def test_eight_times_the_runs_take_no_forty_times_as_long(count: object) -> None:
    """Comparing each with all takes 64 times as long; processor time, best of three, so that others do not count."""
    assert callable(count)
    best = []
    for n in (300, 2400):
        angles = np.random.default_rng(n).uniform(-1.5, 1.5, (n, 6))
        taken = []
        for _ in range(3):
            began = process_time()
            count(angles, DEGREE)
            taken.append(process_time() - began)
        best.append(min(taken))
    assert best[1] < 40.0 * best[0]

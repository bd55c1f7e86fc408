"""A chain as rows of Denavit-Hartenberg's conventions: the same robot, and the numbers that Hayati's β is for."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.conventions import Convention
from stiffcal.mechanics.joint_rows import JointRows, RowsOfChain, rows_as_planned, rows_of_chain
from stiffcal.mechanics.kinematics import body_poses
from stiffcal.mechanics.rotations import rotation_from_vector, transform
from tests.laboratory.robots import six_axes

N_POSES = 200


def planned_rows(convention: Convention) -> JointRows:
    """Return rows of a robot with two parallel axes, an antiparallel pair and transforms at both ends."""
    alpha = np.radians([0.0, -90.0, 0.0, 178.0, 90.0, -90.0])
    a, d = np.array([0.0, 0.2, 0.9, 0.15, 0.0, 0.02]), np.array([0.7, 0.0, 0.16, 0.9, 0.1, 0.14])
    if convention == "dh":  # what lies between two axes stands in the row of the first
        alpha, a = np.roll(alpha, -1), np.roll(a, -1)
    theta = np.radians([10.0, -90.0, 0.0, 180.0, 0.0, 30.0])
    base = transform(rotation_from_vector(np.array([0.1, -0.2, 0.3])), np.array([0.5, 0.1, 0.2]))
    flange = transform(rotation_from_vector(np.array([-0.4, 0.1, 0.2])), np.array([0.01, 0.02, 0.1]))
    return JointRows(convention, a, alpha, np.zeros(6), d, theta, base, flange)


def chain_of_rows(rows: JointRows) -> Chain:
    """Return a six-axis chain with this geometry."""
    fixed, flange = rows.fixed()
    return replace(six_axes(), fixed=fixed, flange=flange, offset=rows.theta, coupling=np.eye(6))


def off(chain: Chain, seed: int) -> Chain:
    """Return the chain with every axis half a millimetre and half a milliradian off."""
    rng = np.random.default_rng(seed)
    errors = [transform(rotation_from_vector(rng.normal(0.0, 5e-4, 3)), rng.normal(0.0, 5e-4, 3)) for _ in range(6)]
    return replace(chain, fixed=chain.fixed @ np.array(errors))


def flange_poses(chain: Chain) -> tuple[Floats, Floats]:
    """Return places and rotations of the flange over the same random angles."""
    joints = np.random.default_rng(1).uniform(-np.pi, np.pi, (N_POSES, 6))
    positions, rotations = body_poses(chain, chain.model_angles(joints))
    return positions[:, -1], rotations[:, -1]


def worst_difference(one: Chain, other: Chain) -> float:
    """Return the largest difference between two chains' flanges, m and as a matrix."""
    return max(float(np.abs(a - b).max()) for a, b in zip(flange_poses(one), flange_poses(other), strict=True))


@pytest.mark.parametrize("convention", get_args(Convention))
@pytest.mark.parametrize("held", [True, False])
def test_rows_are_the_same_robot(convention: Convention, held: bool) -> None:
    rows = planned_rows(convention)
    chain = off(chain_of_rows(rows), 3)
    found = rows_of_chain(chain, RowsOfChain.own(rows), first_held=held, last_held=held)
    assert worst_difference(chain_of_rows(found.rows), chain) < 1e-12
    assert worst_difference(chain_of_rows(rows), chain) > 1e-3
    # half a millimetre and half a milliradian remain numbers of that size, also between parallel axes
    for name in ("a", "alpha", "beta", "d", "theta"):
        assert np.abs(getattr(found.rows, name) - getattr(rows, name)).max() < 0.01, name
    # axes 2 and 3 and axes 3 and 4 are the nearly parallel ones: only their rows have β, and keep d
    parallel = np.flatnonzero(found.rows.beta)
    assert parallel.tolist() == ([1, 2] if convention == "dh" else [2, 3])
    if held:
        assert found.rows.theta[[0, 5]] == pytest.approx(rows.theta[[0, 5]], abs=1e-12)
        assert found.rows.d[[0, 1, 2, 5]] == pytest.approx(rows.d[[0, 1, 2, 5]], abs=1e-12)
    else:
        assert np.abs(found.rows.theta[[0, 5]] - rows.theta[[0, 5]]).min() > 1e-6
        assert found.rows.flange == pytest.approx(rows.flange, abs=1e-12)


@pytest.mark.parametrize("convention", get_args(Convention))
def test_rows_of_the_planned_robot_are_its_own(convention: Convention) -> None:
    rows = planned_rows(convention)
    found = rows_of_chain(chain_of_rows(rows), RowsOfChain.own(rows), first_held=False, last_held=False).rows
    for name in ("a", "alpha", "beta", "d", "theta", "base", "flange"):
        assert getattr(found, name) == pytest.approx(getattr(rows, name), abs=1e-12), name


def test_frames_of_the_links_are_where_the_rows_put_them() -> None:
    rows = planned_rows("dh")
    chain = off(chain_of_rows(rows), 4)
    found = rows_of_chain(chain, RowsOfChain.own(rows))
    built = chain_of_rows(found.rows)
    joints = np.random.default_rng(1).uniform(-np.pi, np.pi, (N_POSES, 6))
    (here, turned), (there, _) = (body_poses(c, c.model_angles(joints)) for c in (chain, built))
    for k, moved in enumerate(found.moved_frames()):
        assert here[:, k + 1] + turned[:, k + 1] @ moved[:3, 3] == pytest.approx(there[:, k + 1], abs=1e-12)


def test_strict_rows_have_no_beta_and_lie_far_away() -> None:
    rows = planned_rows("modified-dh")
    chain = off(chain_of_rows(rows), 3)
    found = rows_of_chain(chain, RowsOfChain.own(rows), strict=True)
    assert not found.rows.beta.any()
    assert np.abs(found.rows.d).max() > 100.0
    assert worst_difference(chain_of_rows(found.rows), chain) < 1e-9


@pytest.mark.parametrize("convention", get_args(Convention))
def test_a_robot_without_rows_gets_some(convention: Convention) -> None:
    chain = chain_of_rows(planned_rows("dh"))
    planned = rows_as_planned(chain, convention)
    assert worst_difference(chain_of_rows(planned.rows), chain) < 1e-12
    assert (planned.rows.a > -1e-9).all()
    found = rows_of_chain(off(chain, 3), planned)
    assert worst_difference(chain_of_rows(found.rows), off(chain, 3)) < 1e-12
    assert np.abs(found.rows.theta - planned.rows.theta).max() < 0.01
    assert np.abs(found.rows.d - planned.rows.d).max() < 0.01

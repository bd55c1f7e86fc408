"""Poses from several points on a body, some of them hidden: the pose, and how far it is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.markers import Markers
from stiffcal.measurements.tables import states_from_table, states_table
from stiffcal.mechanics.rotations import rotation_from_vector, vector_from_rotation
from stiffcal.reduction.logs.markers import fitted_poses
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played

FOUR = Markers(("a", "b", "c", "d"), np.array([[0.1, 0.3, 0.0], [0.3, 0.3, 0.0], [0.1, 0.45, 0.02], [0.25, 0.5, 0.1]]))
POINT_NOISE = 40e-6


def test_markers_give_the_pose_while_three_are_found() -> None:
    turn = rotation_from_vector(np.array([0.3, -0.2, 1.4]))
    shown = np.stack([FOUR.places @ turn.T + [1.0, 2.0, 3.0]] * 3)
    shown[1, 0], shown[2, :2] = np.nan, np.nan
    position, rotation, seen = fitted_poses(FOUR, shown)
    np.testing.assert_allclose(position[:2], [[1.0, 2.0, 3.0]] * 2, atol=1e-12)
    np.testing.assert_allclose(rotation[1], turn, atol=1e-12)
    assert np.isnan(position[2]).all()
    assert seen.tolist() == [[True] * 4, [False, True, True, True], [False, False, True, True]]


def test_three_points_on_one_line_give_no_pose() -> None:
    line = Markers(("a", "b", "c", "d"), np.array([[0.0, 0, 0], [0.1, 0, 0], [0.3, 0, 0], [0, 0.2, 0]]))
    shown = np.stack([line.places, line.places])
    shown[1, 3] = np.nan
    position, _, _ = fitted_poses(line, shown)
    assert np.isfinite(position).all(axis=1).tolist() == [True, False]


def test_covariance_is_that_of_the_fitted_poses() -> None:
    """4000 draws for each set of points seen: a covariance is then known to 1/√2000 = 2.2 % of its variances."""
    rng = np.random.default_rng(6)
    turn = rotation_from_vector(np.array([0.7, -1.1, 0.4]))
    n = 4000
    for hidden in ((), (0,), (3,)):
        shown = FOUR.places @ turn.T + [1.5, 0.2, 0.9] + POINT_NOISE * rng.normal(size=(n, 4, 3))
        shown[:, list(hidden)] = np.nan
        position, rotation, seen = fitted_poses(FOUR, shown)
        away = np.concatenate([position - [1.5, 0.2, 0.9], vector_from_rotation(rotation @ turn.T)], axis=1)
        reported = POINT_NOISE**2 * FOUR.covariance(seen[:1], turn[None])[0]
        size = np.sqrt(np.diag(reported))
        found = away.T @ away / n
        # 21 numbers, each within four of its standard uncertainties
        assert np.all(np.abs(found - reported) / np.outer(size, size) < 4.0 * np.sqrt(2.0 / n))
        # and the frame lies off the points: place and turn err together
        assert np.abs(reported[:3, 3:] / np.outer(size[:3], size[3:])).max() > 0.5


def watched(share: float, seed: int = 3) -> LoadStates:
    """Return states of a robot whose tool carries four points, a share of them hidden; the body's frame is off them."""
    chain = six_axes()
    robot = joint_springs(chain, SIX_STIFFNESS)
    states = played(robot, runs=8, load_scatter=0.02, seed=seed)
    rng = np.random.default_rng(seed)
    places = np.einsum("nij,kj->nki", states.rotation[:, 0], FOUR.places) + states.position[:, 0, None]
    shown = places + POINT_NOISE * rng.normal(size=places.shape)
    shown[rng.uniform(size=shown.shape[:2]) < share] = np.nan
    position, rotation, seen = fitted_poses(FOUR, shown)
    setup = replace(states.setup, markers=(FOUR,))
    return replace(
        states, position=position[:, None], rotation=rotation[:, None], markers_measured=seen[:, None], setup=setup
    )


def unweighted(states: LoadStates) -> LoadStates:
    """Return the same poses as if they had been read: nothing is known of points."""
    nothing = np.zeros((0, 0, 0), dtype=np.bool_)
    return replace(states, markers_measured=nothing, setup=replace(states.setup, markers=()))


def test_a_pose_from_few_points_counts_less() -> None:
    states = watched(0.15)
    hidden = float(np.mean(~states.markers_measured))
    assert 0.1 < hidden < 0.2
    fit = identify_parameters(states, joint_springs(six_axes()))
    # the noise is that of the points' middle and of the turn by all four, whatever was hidden
    assert fit.noise is not None
    known = 3.0 / np.sqrt(fit.noise.dof)  # three standard uncertainties of each, from half of the contrasts
    assert abs(fit.noise.translation / (POINT_NOISE / 2.0) - 1.0) < known
    assert abs(fit.noise.rotation / (POINT_NOISE * np.sqrt(FOUR.turn_variance)) - 1.0) < known
    # six deviations: χ² above 22.5 once in a thousand
    away = np.array([one.value for one in fit.parameters], dtype=np.float64) - 1.0 / SIX_STIFFNESS
    assert away @ np.linalg.solve(fit.covariance, away) < 22.5
    # the noise comes from the repeats, and is known as well as they tell it
    assert fit.reduced_chi2 is not None
    assert abs(fit.reduced_chi2 - 1.0) < 3.0 * np.sqrt(2.0 / fit.noise.dof + 2.0 / fit.dof)
    # poses taken as alike are weighed wrongly: the uncertainty grows by more than a third
    blind = identify_parameters(unweighted(states), joint_springs(six_axes()))
    ratio = [(two.std or 0.0) / (one.std or 1.0) for one, two in zip(fit.parameters, blind.parameters, strict=True)]
    assert np.median(ratio) > 1.33


def test_which_points_were_seen_stays_in_the_table() -> None:
    states = watched(0.3)
    table = states_table(states)
    words = set(table.column("target_markers").to_pylist())
    assert {"a,b,c,d", "b,c,d"} <= words
    again = states_from_table(table)
    np.testing.assert_array_equal(again.markers_measured, states.markers_measured)
    assert again.setup.markers[0] is not None
    assert again.setup.markers[0].names == FOUR.names
    np.testing.assert_array_equal(again.setup.markers[0].places, FOUR.places)

"""Places and displacements in the same observations: offsets of runs, whose noise is whose, what is left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.derivatives.observation import Evaluation, Observations, observe
from stiffcal.identification.fitting.least_squares import reduce_blocks
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.noise.reading_noise import Noise, own_variance, stated_noise, whiten, with_stated_places
from stiffcal.identification.noise.run_offsets import run_offsets
from stiffcal.identification.noise.weights import huber_whitening
from stiffcal.measurements.load_states import LoadStates, RunInfo, Sigma
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.validation.heldout import search_folds, validation_folds
from stiffcal.validation.schemes import BY_REGION_AND_POSE
from tests.laboratory.simulated_states import medium_robot, played

NOISE = Noise(2e-5, 1e-5, 0.7, 0.2, "manifest", np.inf)


def places_and_loads(correlated: bool = False) -> LoadStates:
    """Return five runs of loads of which the single states of the first two are made rows of an absolute run."""
    states = played(medium_robot(), runs=5, noise=Sigma(2e-5, 1e-5))
    keep = (states.run >= 2) | states.reference
    states = states.select(keep)
    runs = tuple(
        RunInfo(f"row {k}", "absolute", of="places", measures=StateMeasure.PLACE) if k < 2 else info
        for k, info in enumerate(states.runs)
    )
    wrench = np.where(states.run[:, None] < 2, 0.0, states.wrench)
    return replace(states, runs=runs, wrench=wrench)


def observed() -> Observations:
    return observe(places_and_loads(), medium_robot().chain)


def test_runs_of_places_carry_no_offset() -> None:
    data = observed()
    assert data.carries_offset.tolist() == [False, False] + [True] * (data.n_states - 2)
    whitening = whiten(NOISE, data, None)
    rng = np.random.default_rng(1)
    stack = rng.normal(size=(2, *data.measured.shape))
    offsets = run_offsets(data, whitening)
    centred = offsets.centred(stack, whitening.apply(stack))
    assert np.array_equal(centred[:, :, :2], stack[:, :, :2])
    for run in (2, 3, 4):
        assert np.abs(centred[:, :, data.run == run].mean(axis=2)).max() < 1e-12
    assert offsets.n_free == 3 * len(data.measured)


@pytest.mark.parametrize("correlated", [False, True])
def test_the_reduced_problem_is_the_whole_one(correlated: bool) -> None:
    """Same minimum and degrees of freedom as generalised least squares with offset columns of the loads' runs alone."""
    data, rng = observed(), np.random.default_rng(2)
    m, n = data.measured.shape
    columns = rng.normal(size=(3, m, n))
    sensitivity = rng.normal(size=(m, 6, n)) * 1e-5 if correlated else None
    whitening = whiten(NOISE, data, sensitivity)
    block = Evaluation(slice(0, n), np.zeros((m, n)), columns, None)
    reduced = reduce_blocks([block], data, whitening)
    offsets = np.zeros((3 * m, m, n))
    for k, run in enumerate((2, 3, 4)):
        offsets[k * m + np.arange(m), np.arange(m)] = data.run == run
    rows = whitening.apply(np.concatenate([columns, offsets])).reshape(3 + 3 * m, -1)
    solution, squares, *_ = np.linalg.lstsq(rows.T, whitening.apply(data.measured).ravel(), rcond=None)
    assert reduced.solve() == pytest.approx(solution[:3], rel=1e-9)
    assert reduced.cost(reduced.solve()) == pytest.approx(float(squares[0]), rel=1e-9)
    assert reduced.dof == m * n - 3 * m
    # the space in which candidates are compared is the same one
    space = Projection.of(data, whitening)
    of_space = np.linalg.lstsq(space.rows(columns).T, space.rows(data.measured[None])[0], rcond=None)[0]
    assert of_space == pytest.approx(solution[:3], rel=1e-9)
    assert space.n_constants == 3 * m
    assert np.array_equal(space.centred(columns)[:, :, :2], columns[:, :, :2])


def test_a_place_has_the_noise_that_is_stated_for_it() -> None:
    data = observed()
    stated = stated_noise(Sigma(2e-5, 1e-5, absolute_translation=5e-5), data)
    assert stated is not None
    variance = own_variance(stated, data)
    shift, turn = data.kind == 0, data.kind == 1
    assert variance[shift][:, :2] == pytest.approx(25e-10)
    assert variance[shift][:, 2:] == pytest.approx(4e-10)
    assert variance[turn] == pytest.approx(1e-10)
    # repeats of loads show the noise of loads; no place is repeated
    of_repeats = with_stated_places(replace(NOISE, translation=9e-5, source="repeats"), stated, data)
    variance = own_variance(of_repeats, data)
    assert variance[shift][:, :2] == pytest.approx(25e-10)
    assert variance[shift][:, 2:] == pytest.approx(81e-10)


def test_no_load_has_no_uncertainty() -> None:
    sizes = NOISE.of_wrenches(observed())
    assert not sizes[:, :2].any()
    assert sizes[:3, 2:] == pytest.approx(0.7)


def test_places_and_loads_are_left_out_apart() -> None:
    states = places_and_loads()
    states = replace(states, joints=np.where(states.run[:, None] == 3, states.joints[[0]], states.joints))
    data = observe(states, medium_robot().chain)
    fold = search_folds(data)
    # the same pose, but a place and a displacement
    assert fold[0] != fold[data.run == 3][0]
    scheme, by_region = validation_folds(data)
    assert scheme == BY_REGION_AND_POSE
    assert set(by_region[:2].tolist()).isdisjoint(by_region[2:].tolist())
    assert sorted(set(by_region.tolist())) == list(range(5))


def test_the_place_of_one_pose_is_not_left_out_with_the_loads_of_another() -> None:
    states = places_and_loads()
    # the loads of run 2 in the pose of the first place
    states = replace(states, joints=np.where(states.run[:, None] == 2, states.joints[[0]], states.joints))
    data = observe(states, medium_robot().chain)
    fold = search_folds(data)
    assert len(np.unique(fold)) == len(np.unique(data.run)) == 5


def test_a_row_counts_by_its_own_uncertainty() -> None:
    """Three times the usual standard uncertainty: nine times the variance, of shifts and of turns."""
    states = places_and_loads()
    states = replace(states, setup=replace(states.setup, sigma=Sigma(2e-5, 1e-5)))
    own = np.full((len(states), 1, 6), np.nan)
    own[3, 0] = [6e-5] * 3 + [3e-5] * 3
    data = observe(replace(states, sigma=own), medium_robot().chain)
    variance = own_variance(NOISE, data)
    usual = np.where(data.kind == 0, 4e-10, 1e-10)
    np.testing.assert_allclose(variance[:, data.index == 3], 9.0 * usual[:, None])
    np.testing.assert_allclose(variance[:, data.index == 4], usual[:, None])


def test_a_wild_reading_counts_as_hubers_loss_has_it() -> None:
    """Beyond k = 2.5 typical lengths the loss grows by k |r|: the squared weight is k over the length."""
    data = replace(observed(), free_offset=False)
    full = whiten(NOISE, data, None)
    predicted = data.measured.copy()
    shift = data.kind == 0
    predicted[shift] += 1e-5
    predicted[shift, 1] += 1e-3
    lowered = huber_whitening(full, full, data, predicted)
    lengths = np.linalg.norm((predicted - data.measured)[shift], axis=0)
    wanted = np.sqrt(np.minimum(1.0, 2.5 * np.median(lengths) / lengths))
    np.testing.assert_allclose(lowered.scale[shift] / full.scale[shift], np.tile(wanted, (3, 1)))
    assert 0.1 < wanted.min() < 0.2

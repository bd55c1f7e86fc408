"""What the geometry's tolerance explains is no candidate's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.diagnosis.refits.heldout_error import left_out_residual
from stiffcal.diagnosis.scans.candidates import list_candidates
from stiffcal.diagnosis.scans.geometry_nuisance import GeometryNuisance
from stiffcal.diagnosis.scans.lack_of_fit import judge, lack_of_fit
from stiffcal.diagnosis.scans.load_scan import scan_candidates
from stiffcal.estimation.triangular import triangular_of_rows
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.geometry import geometry_slope
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.rates.playing import Hidden, simulate_runs


@pytest.fixture(scope="module")
def campaign() -> Hidden:
    """A robot whose geometry is off by the default tolerance, with nothing else hidden."""
    return simulate_runs("only geometry off", np.random.default_rng([14, 1]))


@pytest.fixture(scope="module")
def fit(campaign: Hidden) -> Fit:
    return identify_parameters(campaign.states, campaign.model)


def nuisance_of(states: LoadStates, fit: Fit) -> GeometryNuisance:
    nuisance = GeometryNuisance.of(states, fit)
    assert nuisance is not None
    return nuisance


def test_the_score_is_that_of_readings_with_the_geometry_in_their_covariance(campaign: Hidden, fit: Fit) -> None:
    scan = scan_candidates(fit, [], geometry=nuisance_of(campaign.states, fit))
    # Turned by an orthogonal matrix, so that the dense covariance is small.
    rows = triangular_of_rows(scan.space.rows(np.concatenate([scan.columns, scan.residual[None]])))
    own, errors, residual = rows[:, : scan.n_columns], rows[:, scan.n_columns : -1], rows[:, -1]
    assert errors.shape[1] > 3
    # Generalised least squares with the dense covariance I + A Aᵀ (Seber and Lee 2003, section 3.10).
    root = np.linalg.inv(np.linalg.cholesky(np.eye(len(rows)) + errors @ errors.T))
    left = root @ residual - (root @ own) @ np.linalg.lstsq(root @ own, root @ residual, rcond=None)[0]
    assert scan.base.sum_of_squares == pytest.approx(float(left @ left), rel=1e-8)


def test_a_pose_left_out_takes_nothing_of_what_is_known_of_the_geometry(campaign: Hidden, fit: Fit) -> None:
    scan = scan_candidates(fit, [], geometry=nuisance_of(campaign.states, fit))
    rows = scan.space.rows(np.concatenate([scan.columns, scan.residual[None]]))
    errors = np.arange(len(scan.columns)) >= scan.n_columns
    for number, fold in enumerate(scan.folds[:3]):
        others = np.delete(np.arange(rows.shape[1]), fold)
        # every error of the geometry has its prior of unit variance, once
        matrix = np.vstack([rows[:-1, others].T, np.diag(errors.astype(np.float64))])
        wanted = np.append(rows[-1, others], np.zeros(len(errors)))
        scale = np.linalg.norm(matrix, axis=0)
        refit = np.linalg.lstsq(matrix / scale, wanted, rcond=None)[0] / scale
        left = rows[-1, fold] - refit @ rows[:-1, fold]
        assert scan.base.heldout[number] == pytest.approx(float(left @ left), rel=1e-6)


def test_directions_looked_for_in_some_runs_are_those_of_the_whole_chain(campaign: Hidden, fit: Fit) -> None:
    nuisance = nuisance_of(campaign.states, fit)
    axis = np.random.default_rng(3).normal(size=len(nuisance.sizes))
    combined = np.einsum("g,gmn->mn", axis, nuisance.columns)
    slope = geometry_slope(nuisance.robot, fit.data, axis * nuisance.sizes)
    assert np.abs(slope - combined).max() < 1e-4 * np.abs(combined).max()


def test_directions_from_some_of_the_states_span_nearly_what_all_span(campaign: Hidden, fit: Fit) -> None:
    scan = scan_candidates(fit, [])
    whole = nuisance_of(campaign.states, fit)
    half = fit.data.run % 2 == 0
    part = replace(whole, chosen=half, columns=whole.columns[:, :, half])
    rows = [scan.space.rows(n.directions(scan.space, scan.columns)) for n in (whole, part)]
    own = scan.space.rows(scan.columns)
    bases = [np.linalg.qr(np.concatenate([own, row]).T)[0] for row in rows]
    # The foremost direction of all states lies in the space of those found from half of them.
    foremost = rows[0][0] / np.linalg.norm(rows[0][0])
    assert np.linalg.norm(bases[1].T @ foremost) > 0.97
    assert len(rows[1]) >= len(rows[0]) - 6


def test_places_that_contradict_the_robot_file_give_no_tolerance(campaign: Hidden, fit: Fit) -> None:
    fixed = np.array(fit.robot.chain.fixed)
    fixed[1, :3, 3] += 0.05
    wrong = replace(fit, robot=replace(fit.robot, chain=replace(fit.robot.chain, fixed=fixed)))
    assert GeometryNuisance.of(campaign.states, wrong) is None


@pytest.mark.long
def test_no_effect_is_named_for_a_geometry_off_by_twice_its_tolerance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.rates.playing.GEOMETRY_OFF", (1e-3, 7e-4))
    hidden = simulate_runs("only geometry off", np.random.default_rng([14, 58]))
    found = diagnose_states(hidden.states, hidden.model, built_in_effects())
    assert found.found == ()
    assert not found.unexplained
    # Without the tolerance an effect is supported.
    fit = identify_parameters(hidden.states, hidden.model)
    candidates, _ = list_candidates(fit.robot, hidden.states, built_in_effects())
    scan = scan_candidates(fit, candidates)
    assert judge(scan, scan.trials[0]).supported


def test_what_the_geometry_leaves_is_in_the_held_out_error(campaign: Hidden, fit: Fit) -> None:
    """Poses left out are predicted by the model and its sags alone: the rest of the change is in neither's columns."""
    scan = scan_candidates(fit, [], geometry=nuisance_of(campaign.states, fit))
    assert scan.geometry is not None
    n_sags = len(scan.geometry.sag)
    left = left_out_residual(scan, None)
    m = len(left)
    of_model = np.concatenate([scan.columns[: scan.n_columns], scan.columns[len(scan.columns) - n_sags :]])
    for run in np.unique(fit.data.run):
        states = np.flatnonzero(fit.data.run == run)
        offsets = np.repeat(np.eye(m)[:, :, None], len(states), axis=2)
        columns = np.concatenate([of_model[:, :, states], offsets, scan.residual[None][:, :, states]])
        columns = columns.reshape(len(columns), -1).T
        assert len(columns) > columns.shape[1]
        scale = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        own = left[:, states].ravel()
        rest = own - columns / scale @ np.linalg.lstsq(columns / scale, own, rcond=1e-12)[0]
        assert np.linalg.norm(rest) < 1e-8 * np.linalg.norm(own)


def test_lack_of_fit_has_the_fits_degrees_of_freedom(campaign: Hidden) -> None:
    known = Noise(2e-5, 2e-5, 0.5, 0.1, "manifest", np.inf)
    stated = identify_parameters(campaign.states, campaign.model, Settings(noise=known))
    scan = scan_candidates(stated, [])
    lack = lack_of_fit(scan.fit, scan)
    assert lack is not None
    assert stated.reduced_chi2 is not None
    assert lack.dof == (float(stated.dof), np.inf)
    assert lack.statistic == pytest.approx(stated.reduced_chi2, rel=1e-3)

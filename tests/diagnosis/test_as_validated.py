"""Errors of the search and of validation: which data each leaves out, and that one word stands for each."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.diagnosis.refits.heldout_error import as_validated, left_out_residual, residual_without_folds
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.diagnosis.scans.load_scan import LoadScan, scan_candidates
from stiffcal.effects.joint_eccentricity import JointEccentricity
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Place
from stiffcal.validation.heldout import heldout_residuals, left_out_residuals, validation_folds
from stiffcal.validation.validate import rms_of
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import six_axes


@pytest.fixture(scope="module")
def looked_at() -> tuple[LoadStates, LoadScan]:
    """Return absolute poses of a robot with a wave of 0.3 mrad at each joint, and the scan of the model without it."""
    chain = six_axes()
    waves = [{"a": 3e-4, "b": -3e-4, "order": 1.0}] * 6
    truth = CompliantRobot(chain, tuple(on_all_joints(JointEccentricity(), 6, waves)))
    states = measured_by(truth, absolute_states(chain, 70, 5), 6)
    fit = identify_parameters(states, CompliantRobot(chain, tuple(on_all_joints(LinkGeometry(), 6))))
    return states, scan_candidates(fit, [Candidate(JointEccentricity(), Place("joints", (3,)), 2)])


def test_the_diagnosis_states_what_validate_states(looked_at: tuple[LoadStates, LoadScan]) -> None:
    states, scan = looked_at
    found = as_validated(states, scan.fit, None)
    assert found is not None
    heldout = heldout_residuals(states, scan.fit)
    assert (found.scheme, heldout.scheme) == ("poses-region", "poses-region")
    assert found.rms.translation == rms_of(heldout.residual, heldout.data)["translation"]
    # regions left out are farther from what was fitted than single poses
    by_pose = rms_of(left_out_residual(scan, None), scan.fit.data)["translation"]
    assert found.rms.translation is not None
    assert by_pose is not None
    assert found.rms.translation > 1.02 * by_pose


def test_a_candidate_is_left_out_by_region_as_the_model_is(looked_at: tuple[LoadStates, LoadScan]) -> None:
    _, scan = looked_at
    _, fold = validation_folds(scan.fit.data)
    own = left_out_residuals(scan.fit, fold).residual
    # the same linear problem by its inner products and by its triangular factors, of residuals of 0.5 mm
    np.testing.assert_allclose(residual_without_folds(scan, None, fold), own, atol=1e-8)
    trial = scan.trials[0]
    single = left_out_residual(scan, trial)
    np.testing.assert_allclose(residual_without_folds(scan, trial, scan.fold_of_state), single, atol=1e-8)
    assert np.abs(residual_without_folds(scan, trial, fold) - single).max() > 1e-5

"""Errors in held-out poses, against fits that were really made without them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem, identify_parameters
from stiffcal.measurements.load_states import Sigma
from stiffcal.validation.heldout import heldout_residuals, search_folds
from stiffcal.validation.validate import rms_of, validate_fit
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

NOISE = Sigma(16e-6, 30e-6)


def test_leaving_a_pose_out_equals_a_fit_without_it() -> None:
    """The folds' triangular factors give what refitting gives, within the curvature of one step."""
    stiffness = SIX_STIFFNESS.copy()
    states = played(joint_springs(six_axes(), stiffness), runs=5, noise=Sigma(2e-4, 3e-4))
    robot = joint_springs(six_axes())
    fit = identify_parameters(states, robot)
    quick = heldout_residuals(states, fit)
    for number in range(5):
        without = fit_observations(fit_problem(states, robot, states.run != number), robot, Settings(noise=fit.noise))
        runs = tuple(replace(info, holdout=k == number) for k, info in enumerate(states.runs))
        exact = heldout_residuals(replace(states, runs=runs), without)
        part = quick.residual[:, quick.data.run == number]
        assert exact.scheme == "holdout"
        assert np.allclose(part, exact.residual, atol=0.02 * float(np.std(exact.residual)))


def test_noise_alone_leaves_the_noise() -> None:
    """Nothing missing: the held-out error is the noise, within three standard uncertainties and the fit's own share."""
    states = played(medium_robot(), runs=12, noise=NOISE)
    states = replace(states, setup=replace(states.setup, sigma=NOISE))
    validation = validate_fit(states, identify_parameters(states, joint_springs(six_axes())))
    for kind in ("translation", "rotation"):
        error, noise = getattr(validation.rms, kind), getattr(validation.noise, kind)
        assert error is not None
        assert noise is not None
        assert error / noise == pytest.approx(1.0, abs=3.0 / np.sqrt(6.0 * len(states)) + 0.02)
    assert validation.relative.translation is not None
    assert validation.relative.translation < 0.1


def test_runs_of_one_pose_are_left_out_together() -> None:
    """Two runs within a degree of each other are one pose."""
    states = played(medium_robot(), runs=4)
    joints = states.joints.copy()
    joints[states.run == 3] = joints[states.run == 1][0] + np.radians(0.4)
    fit = identify_parameters(replace(states, joints=joints), joint_springs(six_axes()))
    fold = search_folds(fit.data)
    assert sorted(set(fold)) == [0, 1, 2]
    assert fold[fit.data.run == 1][0] == fold[fit.data.run == 3][0]


def test_the_lost_degree_of_freedom_is_counted() -> None:
    """A run of n readings of pure noise about its own mean has the noise's rms, not √((n − 1)/n) of it."""
    rng = np.random.default_rng(0)
    states = played(medium_robot(), runs=400, wrench=[np.zeros((3, 6))] * 400)
    states = replace(states, position=states.position + 1e-4 * rng.normal(size=states.position.shape))
    runs = tuple(replace(info, holdout=True) for info in states.runs)
    fit = identify_parameters(played(medium_robot(), runs=4), joint_springs(six_axes()))
    residuals = heldout_residuals(replace(states, runs=runs), fit)
    assert rms_of(residuals.residual, residuals.data)["translation"] == pytest.approx(1e-4 * np.sqrt(3.0), rel=0.06)

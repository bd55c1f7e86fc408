"""Distances of absolute places, and which poses are left out together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.assembled.measured_frames import placed_frame
from stiffcal.validation.distance_results import NoiseDistance
from stiffcal.validation.distances import distances_of, summary_of
from stiffcal.validation.heldout import heldout_residuals
from stiffcal.validation.region_folds import REGIONS, random_folds, region_folds
from tests.laboratory.absolute_places import TARGET, absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import six_axes


def test_like_poses_share_a_fold_and_regions_are_close() -> None:
    chain = six_axes()
    states = absolute_states(chain, 120, 3)
    joints = states.joints.copy()
    joints[60:] = joints[:60] + np.radians(0.3)
    data = observe(replace(states, joints=joints), chain)
    for folds in (region_folds(data), random_folds(data)):
        np.testing.assert_array_equal(folds[:60], folds[60:])
        assert set(folds.tolist()) == set(range(REGIONS))
    features = np.concatenate([np.cos(data.angles), np.sin(data.angles)]).T

    def spread(fold: np.ndarray) -> float:
        return float(sum(np.sum((features[fold == k] - features[fold == k].mean(axis=0)) ** 2) for k in range(REGIONS)))

    assert spread(region_folds(data)) < 0.75 * spread(random_folds(data))


def test_lengths_of_known_residuals() -> None:
    chain = six_axes()
    data = observe(absolute_states(chain, 4, 1), chain)
    residual = np.array([[3.0, 0.0, 0.0, 0.0], [4.0, 0.0, 2.0, 0.0], [0.0, 1.0, 0.0, 0.0]]) * 1e-3
    found = summary_of(residual, data)
    assert found is not None
    assert (found.mean, found.median, found.max, found.n) == pytest.approx((2e-3, 1.5e-3, 5e-3, 4))
    assert found.rms == pytest.approx(np.sqrt(30.0 / 4.0) * 1e-3)
    assert found.p95 == pytest.approx(np.quantile([5e-3, 1e-3, 2e-3, 0.0], 0.95))
    assert [part.target for part in found.by_target] == [TARGET]


def test_a_region_left_out_is_predicted_as_a_fit_without_it_predicts() -> None:
    """The folds' factors about the full fit against a fit of its own without the fold."""
    chain = six_axes()
    frames = (placed_frame("tracker", True), placed_frame(TARGET, False))
    errors = [dict.fromkeys(("x", "y", "rx", "ry"), 0.0), *[{"x": 2e-4, "ry": -5e-4}] * 5]
    truth = CompliantRobot(chain, (*frames, *on_all_joints(LinkGeometry(), 6, errors)))
    states = measured_by(truth, absolute_states(chain, 90, 5), 6)
    blank = CompliantRobot(chain, (*frames, *on_all_joints(LinkGeometry(), 6)))
    fit = identify_parameters(states, blank)
    heldout = heldout_residuals(states, fit)
    assert heldout.scheme == "poses-region"
    without = heldout.fold != 2
    own = identify_parameters(states.select(without), blank)
    from stiffcal.identification.fitting.identify import predict_observations

    data = fit.data.subset(~without)
    exact = data.measured - predict_observations(own.robot, data)
    # 20 µm of noise; what is quadratic in the step without the fold stays below a hundredth of it
    np.testing.assert_allclose(heldout.residual[:, ~without], exact, atol=2e-7)
    distances = distances_of(fit)
    assert distances is not None
    assert distances.heldout_region is not None
    assert distances.heldout_region.rms > distances.fit.rms
    assert distances.noise is not None
    assert distances.noise.rms == pytest.approx(fit.noise_length["translation"])
    # each region with the mean direction of its joints
    assert sum(region.n for region in distances.by_region) == 90
    for region in distances.by_region:
        own_rows = states.joints[region_folds(fit.data) == region.region - 1]
        direction = np.angle(np.exp(1j * own_rows).sum(axis=0))
        np.testing.assert_allclose(np.exp(1j * np.array(region.centre)), np.exp(1j * direction), atol=1e-9)


def test_noise_alone_makes_the_distances_that_are_stated() -> None:
    """Against drawn noise: 200 000 of them give each figure to a quarter of a percent."""
    drawn = np.linalg.norm(np.random.default_rng(3).normal(0.0, 2e-5, (200_000, 3)), axis=1)
    stated = NoiseDistance.of_rms(float(np.sqrt(3.0)) * 2e-5)
    found = (drawn.mean(), np.median(drawn), np.quantile(drawn, 0.95), np.sqrt(np.mean(drawn**2)))
    assert (stated.mean, stated.median, stated.p95, stated.rms) == pytest.approx(found, rel=5e-3)

"""T-optimality: the separation of two models is what a refit of the wrong one leaves, and designs make it large."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from stiffcal.planning.rivals import PairInformation, RivalModel, pairs_of_rivals, separating_design
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axes, six_axis_joints
from tests.laboratory.simulated_states import joint_springs
from tests.laboratory.states_of_runs import states_of_runs

NOISE = Noise(2e-5, 0.0, 0.0, 0.0, "manifest", np.inf)
LEVELS = np.array([0.1, 0.3, 1.0, -0.1, -0.3, -1.0])


def with_effect(name: str, joint: int, values: dict[str, float]) -> CompliantRobot:
    robot = joint_springs(six_axes(), SIX_STIFFNESS)
    placed = (*robot.placed, PlacedEffect(find_effects()[name], Place("joints", (joint,)), values))
    return CompliantRobot(robot.chain, placed, robot.deformed)


TRUTH = with_effect("backlash", 4, {"width": 5e-4, "band": 2.0})
EXACT = Noise(1e-12, 0.0, 0.0, 0.0, "manifest", np.inf)


def runs(seed: int, n: int) -> tuple[Floats, Floats, MeasurementSetup]:
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=(n, 1, 6))
    direction /= np.linalg.norm(direction[:, :, :3], axis=2, keepdims=True)
    wrench = 300.0 * LEVELS[None, :, None] * direction
    wrench[:, :, 3:] *= 0.1
    return six_axis_joints(rng, n), wrench, force_sensor_setup(TRUTH.chain)


def refitted(joints: Floats, wrench: Floats, setup: MeasurementSetup) -> Fit:
    """Return the wrong model fitted to what the true one does, as a plan has it fitted to a campaign."""
    played = states_of_runs(TRUTH, joints, wrench, setup, EXACT, np.random.default_rng(1))
    return identify_parameters(played, with_effect("cubic-stiffness", 4, {}), Settings(noise=NOISE))


def pairs(joints: Floats, wrench: Floats, setup: MeasurementSetup) -> list[PairInformation]:
    other = refitted(*runs(0, 8)).robot
    return pairs_of_rivals(
        [RivalModel.of_covariance(TRUTH, {}), RivalModel.of_covariance(other, {})],
        joints,
        wrench,
        setup,
        NOISE,
        with_rotation=False,
    )


def test_the_separation_is_what_a_refit_of_the_wrong_model_leaves() -> None:
    joints, wrench, setup = runs(0, 8)
    both = pairs(joints, wrench, setup)
    (pair,) = (pair for pair in both if pair.truth == 0)
    left = float(np.sum(refitted(joints, wrench, setup).residual ** 2)) / NOISE.translation**2
    assert left > 10.0
    assert pair.separation(np.arange(8)) == pytest.approx(left, rel=1e-3)


def test_a_rival_is_weighed_with_the_noise_of_its_own_fit() -> None:
    """The model without the effect takes part of it for noise: its noise would promise too little."""
    joints, wrench, setup = runs(0, 8)
    other, doubled = refitted(joints, wrench, setup).robot, replace(NOISE, translation=2.0 * NOISE.translation)
    common, own = (
        pairs_of_rivals(
            [RivalModel.of_covariance(TRUTH, {}), RivalModel.of_covariance(other, {}, noise)],
            joints, wrench, setup, doubled, with_rotation=False,
        )
        for noise in (None, NOISE)
    )  # fmt: skip
    ratio = {k: own[k].separation(np.arange(8)) / common[k].separation(np.arange(8)) for k in range(2)}
    assert ratio[[pair.truth for pair in own].index(0)] == pytest.approx(4.0, rel=1e-3)
    assert ratio[[pair.truth for pair in own].index(1)] == pytest.approx(1.0, rel=1e-9)


def test_the_design_separates_both_ways_better_than_random_runs() -> None:
    candidates = pairs(*runs(1, 80))
    design = separating_design(candidates, 6, limit=2)
    smallest = min(pair.separation(design.chosen) for pair in candidates)
    assert smallest == pytest.approx(1.0 / design.loss**2, rel=1e-3)
    rng = np.random.default_rng(2)
    random = [min(pair.separation(rng.choice(80, 6)) for pair in candidates) for _ in range(20)]
    assert smallest > 1.5 * max(random)
    assert design.efficiency > 0.85


def test_models_that_predict_the_same_are_not_separated() -> None:
    joints, wrench, setup = runs(3, 20)
    same = pairs_of_rivals(
        [RivalModel.of_covariance(TRUTH, {}), RivalModel.of_covariance(TRUTH, {})],
        joints,
        wrench,
        setup,
        NOISE,
        with_rotation=False,
    )
    design = separating_design(same, 4)
    assert all(pair.separation(design.chosen) < 1e-6 for pair in same)


def test_what_was_measured_counts_as_the_covariance_of_its_fit_does() -> None:
    joints, wrench, setup = runs(4, 10)
    fit = refitted(joints, wrench, setup)
    assert fit.whitening is not None
    of_data = RivalModel.of_data(fit.robot, fit.data, fit.whitening, frozenset())
    names = [name for name in of_data.names if name in fit.free_names]
    at = [of_data.names.index(name) for name in names]
    own = [fit.free_names.index(name) for name in names]
    np.testing.assert_allclose(
        np.sqrt(np.diagonal(np.linalg.inv(of_data.information[np.ix_(at, at)]))),
        np.sqrt(np.diagonal(fit.covariance)[own]),
        rtol=0.02,
    )

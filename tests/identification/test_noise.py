"""The noise estimated from repeats, against the noise that was put in."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.identification.fitting.identify import fit_problem, identify_parameters
from stiffcal.measurements.load_states import Sigma
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played


def test_repeats_show_tracker_and_wrench_noise() -> None:
    """All four levels come back; each within four of its own standard uncertainties , the wrench wider."""
    truth = Sigma(translation=20e-6, rotation=40e-6, force=3.0, moment=0.8)
    states = played(medium_robot(), runs=20, noise=truth, load_scatter=0.03)
    fit = identify_parameters(states, joint_springs(six_axes()))
    assert fit.noise is not None
    assert fit.noise.source == "repeats"
    assert fit.noise.translation == pytest.approx(20e-6, rel=0.12)
    assert fit.noise.rotation == pytest.approx(40e-6, rel=0.12)
    assert fit.noise.force == pytest.approx(3.0, rel=0.4)
    assert fit.noise.moment == pytest.approx(0.8, rel=0.4)


def test_without_repeats_the_manifest_is_believed() -> None:
    """Single cycles leave no repeats; then the stated sigma counts, and without one nothing is said."""
    from dataclasses import replace

    from tests.laboratory.simulated_states import cycles_of

    noise = Sigma(20e-6, 40e-6)
    wrench = [cycles_of(np.eye(3)[:2], cycles=1) for _ in range(4)]
    states = played(medium_robot(), runs=4, wrench=wrench, noise=noise)
    silent = identify_parameters(states, joint_springs(six_axes()))
    assert silent.noise is None
    assert silent.reduced_chi2 is None
    assert silent.scaled
    stated = identify_parameters(replace(states, setup=replace(states.setup, sigma=noise)), joint_springs(six_axes()))
    assert stated.noise is not None
    assert stated.noise.source == "manifest"
    assert stated.noise_length["translation"] == pytest.approx(20e-6 * np.sqrt(3.0))


def test_the_first_loading_is_no_repeat() -> None:
    """Friction and play start from an unknown memory: the first branch up is left out of the groups."""
    states = played(medium_robot(), runs=2)
    problem = fit_problem(states, joint_springs(six_axes()))
    first_up = {1, 2, 9, 10, 17, 18}  # of three directions, each up (0.5, 1.0), down, twice
    grouped = {int(i) for group in problem.groups for i in group}
    assert not grouped & {i for i in first_up if i % 8 == 1}
    assert len(problem.groups) > 0

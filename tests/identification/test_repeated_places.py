"""Noise of absolute places from rows in which the robot stood alike, where the manifest states none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.fitting.identify import fit_problem, identify_parameters
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.model.assembled.composite import CompliantRobot
from tests.laboratory.absolute_places import SIGMA, absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import six_axes

N_ROWS, N_PAIRS = 120, 40
ROBOT = CompliantRobot(six_axes(), tuple(on_all_joints(LinkGeometry(), 6)))


def places(sigma: float | None = None, tilt: float = 0.0) -> LoadStates:
    """Return rows of which the last forty repeat the first forty within 0.05°; the robot's axes are tilted."""
    plan = absolute_states(ROBOT.chain, N_ROWS, 3)
    joints = plan.joints.copy()
    near = np.radians(0.05) * np.random.default_rng(4).uniform(-1.0, 1.0, (N_PAIRS, 6))
    joints[-N_PAIRS:] = joints[:N_PAIRS] + near
    tilted = CompliantRobot(ROBOT.chain, tuple(on_all_joints(LinkGeometry(), 6, [{"rx": tilt}] * 6)))
    states = measured_by(tilted, replace(plan, joints=joints), 5)
    return replace(states, setup=replace(states.setup, sigma=Sigma(translation=sigma)))


def test_pairs_of_like_rows_show_the_noise() -> None:
    """Forty pairs of three components: known to 6.5 %; the robot differs from the nominal one by 2 mrad per axis."""
    noise = identify_parameters(places(tilt=2e-3), ROBOT).noise
    assert noise is not None
    assert noise.source == "repeats"
    assert noise.translation == pytest.approx(SIGMA, rel=0.2)
    assert noise.dof == 3 * N_PAIRS
    # nothing loads the robot: no force is uncertain
    assert noise.force == noise.moment == 0.0


def test_what_the_manifest_states_comes_first() -> None:
    noise = identify_parameters(places(sigma=3e-5), ROBOT).noise
    assert noise is not None
    assert (noise.source, noise.translation) == ("manifest", 3e-5)


def test_copies_and_other_loads_are_no_repeats() -> None:
    states = places()
    assert len(fit_problem(states, ROBOT).groups) == N_PAIRS
    copied = replace(states, joints=states.joints.copy(), position=states.position.copy())
    copied.joints[-N_PAIRS:], copied.position[-N_PAIRS:] = states.joints[:N_PAIRS], states.position[:N_PAIRS]
    assert not fit_problem(copied, ROBOT).groups
    loaded = states.wrench.copy()
    loaded[-N_PAIRS:, 2] = -50.0
    assert not fit_problem(replace(states, wrench=loaded), ROBOT).groups

"""Kinds of experiment that determine the same parameters: by how much, and in which direction, they disagree."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stiffcal.identification.answers.agreement import _agreement
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.measurements.load_states import Sigma
from tests.laboratory.robots import SIX_STIFFNESS
from tests.laboratory.rod_states import bending_swing, six_axes_with_beams, with_effect
from tests.laboratory.simulated_states import joint_springs, played

NOISE = Sigma(translation=2e-6, rotation=4e-6)
HELD = frozenset(f"joint-compliance.j{k}.c" for k in (1, 3, 4, 5, 6)) | {"link-beam.swing.GJ", "link-beam.swing.EA"}


def fit_of(stiffness: float, softness: float, seed: int) -> Fit:
    """Return a fit of joint 2 and of the swing's bending, both times so much of the usual value."""
    swing = {"EI2": 4e6 * stiffness, "EI3": 6e6 * stiffness, "GJ": 3e6, "EA": 1.5e9}
    values = SIX_STIFFNESS.copy()
    values[1] /= softness
    robot = with_effect(joint_springs(six_axes_with_beams(), values), bending_swing(**swing))
    states = played(robot, runs=5, noise=NOISE, seed=seed)
    states = replace(states, setup=replace(states.setup, sigma=NOISE))
    return identify_parameters(states, robot, Settings(fixed=HELD))


def test_a_second_value_that_is_larger_is_so_by_positive_standard_errors() -> None:
    """Of a compliance, and of a stiffness, whose amplitude is one over the value."""
    first, second = fit_of(1.0, 1.0, 1), fit_of(1.5, 1.5, 2)
    agreement = _agreement(("loads", first), ("clamped", second))
    assert agreement is not None
    assert not agreement.agree
    assert {common.name.rpartition(".")[2] for common in agreement.parameters} == {"c", "EI2", "EI3"}
    for common in agreement.parameters:
        assert common.second > common.first
        assert common.standard_errors > 3.0


def test_two_measurements_of_one_robot_agree() -> None:
    agreement = _agreement(("loads", fit_of(1.0, 1.0, 1)), ("clamped", fit_of(1.0, 1.0, 2)))
    assert agreement is not None
    assert agreement.agree
    assert agreement.statistic == pytest.approx(agreement.dof, abs=5.0 * (2.0 * agreement.dof) ** 0.5)

"""What data determine of two parameters together is in the fitted robot: it predicts what was fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.answers.document import values_in_fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.identification.readings.observations import observe
from stiffcal.measurements.load_states import Sigma
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from stiffcal.results.identify_answer import identify_result
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import cycles_of, joint_springs, medium_robot, played

ONCE = cycles_of(np.eye(3), cycles=1)[[0, 2, 6, 10]]
"""Each load once: nothing shows the noise."""


def with_base(chain: Chain) -> CompliantRobot:
    """Return springs in all joints, and a base that gives about the axis of joint 1 as well."""
    robot = joint_springs(chain)
    return replace(robot, placed=(*robot.placed, PlacedEffect(find_effects()["base-compliance"], Place("setup"))))


def test_the_robot_of_an_answer_predicts_what_was_fitted() -> None:
    """Joint 1 and the base about its axis were rigid in predictions: 0.26 mm in place of 0.80 at 300 N."""
    states = played(medium_robot(), 6, noise=Sigma(15e-6, 30e-6, 0.5, 0.1))
    fit = identify_parameters(states, with_base(six_axes()))
    result = identify_result(fit, states)
    alone = {name for group in result.not_identifiable for name in group.parameters}
    assert {"joint-compliance.j1.c", "base-compliance.setup.rz"} <= alone
    assert result.values().keys().isdisjoint(alone)
    robot = with_base(six_axes()).with_values(result.robot_values())
    data = observe(states, robot.chain)
    assert predict_observations(robot, data) == pytest.approx(predict_observations(fit.robot, data), abs=1e-9)
    [in_fit] = [parameter.in_fit for parameter in result.parameters if parameter.in_fit is not None]
    assert in_fit == pytest.approx(1.0 / SIX_STIFFNESS[0], rel=0.05)
    assert np.isfinite(in_fit)


def test_a_stiffness_that_is_infinite_in_the_fit_stands_for_nothing() -> None:
    """A number in a stored fit is finite: one that was not made every command fit again."""
    fit = identify_parameters(played(medium_robot(), 2), with_base(six_axes()))
    rigid = PlacedEffect(find_effects()["link-beam"], Place("links", (2,)), {"EA": np.inf})
    unknown = replace(fit.parameters[0], name=rigid.parameter_name("EA"), value=None)
    robot = replace(fit.robot, placed=(*fit.robot.placed, rigid))
    assert unknown.name not in values_in_fit(replace(fit, robot=robot, parameters=(*fit.parameters, unknown)))


def test_springs_that_are_not_significant_are_named_where_others_of_the_effect_are() -> None:
    """A base that tilts about x by 39 standard uncertainties was "not significant" because of its other springs."""
    robot = with_base(six_axes())
    base = robot.placed[-1]
    given = {spec.symbol: 0.0 for spec in base.effect.parameters} | {"rx": 1e-7}
    true = replace(medium_robot(), placed=(*medium_robot().placed, replace(base, values=given)))
    states = played(true, 6, noise=Sigma(15e-6, 30e-6, 0.5, 0.1))
    fit = identify_parameters(states, robot)
    [lost] = [parameter.spec.symbol for parameter in fit.parameters if parameter.name == "base-compliance.setup.ry"]
    named = [
        warning for warning in identify_result(fit, states).warnings if warning.startswith("base-compliance at setup")
    ]
    assert len(named) == 1
    symbols = named[0].partition("(")[2].partition(")")[0].split(", ")
    assert lost in symbols
    assert "rx" not in symbols


def test_the_example_of_a_stated_noise_has_all_that_was_read() -> None:
    """With the position's alone the noise stayed unknown, and the same warning came again."""
    for full_pose in (False, True):
        states = played(medium_robot(), 6, wrench=[ONCE] * 6, full_pose=full_pose)
        warnings = identify_result(identify_parameters(states, joint_springs(six_axes())), states).warnings
        [stated] = [warning for warning in warnings if "sigma = {" in warning]
        assert ("rotation = " in stated) == full_pose

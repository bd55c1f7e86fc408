"""Where nothing in the catalogue fits: whose compliance follows what, and the effect that is written to test it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.diagnosis.answers.pattern_results import CompliancePattern, FollowedBy
from stiffcal.diagnosis.remainder.pattern_plugin import plugin_text
from stiffcal.diagnosis.remainder.patterns import Followed, find_pattern
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Effect, Law, Place
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played
from tests.rates.outside import CrossStiffness, QuadraticCross, TorqueProduct

NOISE = Sigma(16e-6, 30e-6, 0.5, 0.1)
ANGLE = PlacedEffect(CrossStiffness(), Place("pairs", (1, 3)), {"c": 5e-7, "order": 2.3, "phase": 0.7})
TORQUE = PlacedEffect(TorqueProduct(), Place("pairs", (2, 3)), {"c": 1e-9})
NO_COMPLIANCE = PlacedEffect(QuadraticCross(), Place("pairs", (2, 3)), {"c": 1e-9})


def campaign_with(*hidden: PlacedEffect) -> tuple[Fit, LoadStates]:
    """Return the joints' springs fitted to a robot with something hidden, and its states."""
    robot = medium_robot()
    states = played(replace(robot, placed=(*robot.placed, *hidden)), runs=14, noise=NOISE, seed=5)
    return identify_parameters(states, joint_springs(six_axes())), states


def pattern_of(*hidden: PlacedEffect) -> CompliancePattern:
    pattern = find_pattern(*campaign_with(*hidden))
    assert pattern is not None
    return pattern


def test_the_joint_and_the_angle_that_it_follows_are_named() -> None:
    pattern = pattern_of(ANGLE)
    assert (pattern.joint, pattern.follows, pattern.of_joint) == (3, FollowedBy.JOINT_ANGLE, 1)
    assert pattern.share > 0.95
    values = {parameter.symbol: parameter.value or 0.0 for parameter in pattern.parameters}
    assert np.hypot(values["a"], values["b"]) == pytest.approx(5e-7, rel=0.2)
    # Each run's apparent compliance lies on the law, up to noise and what the refitted springs take.
    curve = np.array(pattern.curve)
    off = [point.compliance - np.interp(point.at, curve[:, 0], curve[:, 1]) for point in pattern.points]
    assert float(np.std(off)) < 0.2 * float(np.std([point.compliance for point in pattern.points]))


def test_a_compliance_that_follows_another_joints_torque() -> None:
    pattern = pattern_of(TORQUE)
    assert (pattern.joint, pattern.follows, pattern.of_joint) == (3, FollowedBy.JOINT_TORQUE, 2)
    assert pattern.share > 0.95


@pytest.mark.parametrize("hidden", [(), (NO_COMPLIANCE,)], ids=["nothing hidden", "no compliance"])
def test_no_pattern_where_no_compliance_varies(hidden: tuple[PlacedEffect, ...]) -> None:
    assert find_pattern(*campaign_with(*hidden)) is None


@pytest.mark.parametrize("hidden", [ANGLE, TORQUE], ids=["angle", "torque"])
def test_the_effect_that_is_written_has_the_same_law(hidden: PlacedEffect) -> None:
    fit, states = campaign_with(hidden)
    pattern = find_pattern(fit, states)
    assert pattern is not None
    names: dict[str, type[Effect]] = {}
    exec(plugin_text(pattern, "follows-it"), names)
    effect = names["FollowsIt"]()
    assert isinstance(effect, Law)
    assert effect.name == "follows-it"
    state = Linearised.about(fit.robot, fit.data)
    values = {parameter.symbol: parameter.value or 0.0 for parameter in pattern.parameters}
    shape = {"order": values["order"]} if "order" in values else {}
    regressor = state.regressor(effect, Place("joints", (pattern.joint,)), shape)
    followed = Followed(pattern.follows, pattern.of_joint or 0, pattern.scale)
    at = followed.of(fit.robot.chain, state.loads)
    covariate = effect.covariate(Place("joints", (pattern.joint,)), fit.robot.chain, state.loads)
    assert covariate is not None
    assert np.allclose(covariate.value, at)
    moved = sum(values[symbol] * column for symbol, column in zip(regressor.symbols, regressor.columns, strict=True))
    spring = state.regressor(fit.robot.placed[2].effect, Place("joints", (pattern.joint,)), {}).columns[0]
    law = values["a"] * at + values["b"] * at**2
    if pattern.follows is FollowedBy.JOINT_ANGLE:
        law = values["a"] * np.cos(shape["order"] * at) + values["b"] * np.sin(shape["order"] * at)
        # The angle is that of the pose, so that the law scales what the joint's own spring does in each state.
        assert np.allclose(moved, law * spring, atol=1e-6 * np.abs(moved).max())
    assert effect.nonlinear_grid(Place("joints", (1,)), fit.robot.chain, state.loads).keys() == shape.keys()

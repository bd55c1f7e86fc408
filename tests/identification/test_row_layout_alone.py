"""The prediction of an absolute row does not depend on which other rows are evaluated with it."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.wrench_bias import WrenchBias
from stiffcal.identification.derivatives.observation import FIT_TOLERANCE, observe
from stiffcal.identification.fitting.identify import predict_observations
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.absolute_places import absolute_states, on_all_joints
from tests.laboratory.robots import six_axes

CHAIN = six_axes()
SPRINGS = on_all_joints(JointCompliance(), 6, [{"c": 1e-6}] * 6)
SETUP = {name: effect for name, effect in built_in_effects().items() if effect.place_kind == "setup"}
CLOSE = 10.0 * FIT_TOLERANCE
"""m, rad: rests are found to FIT_TOLERANCE in every joint."""


def loads(n: int, loaded: int) -> Floats:
    """Return (n, 6) N, N·m: a force and a moment in the first rows, none in the others."""
    wrench = np.zeros((n, 6))
    wrench[:loaded] = [20.0, -30.0, -50.0, 3.0, 2.0, -4.0]
    return wrench


def robot_with(effect: str) -> CompliantRobot:
    spec = SETUP[effect]
    values = {parameter.symbol: parameter.typical for parameter in spec.parameters}
    return CompliantRobot(CHAIN, (*SPRINGS, PlacedEffect(spec, Place("setup"), values)))


@pytest.mark.parametrize("effect", ["wrench-bias", "wrench-scale", "load-point-offset", "wrench-frame"])
def test_rows_alone_and_together(effect: str) -> None:
    data = observe(absolute_states(CHAIN, 12, 1, wrench=loads(12, 4)), CHAIN)
    robot = robot_with(effect)
    together = predict_observations(robot, data)
    alone = predict_observations(robot, data.subset(slice(4, 12)))
    np.testing.assert_allclose(together[:, 4:], alone, atol=CLOSE)


@pytest.mark.parametrize("loaded", [0, 5])
def test_fit_and_search_have_one_prediction(loaded: int) -> None:
    data = observe(absolute_states(CHAIN, 10, 1, wrench=loads(10, loaded)), CHAIN)
    robot = robot_with("wrench-bias")
    np.testing.assert_allclose(predict_observations(robot, data), Linearised.about(robot, data).predicted, atol=CLOSE)


def test_a_bias_acts_where_a_sensor_was_read() -> None:
    data = observe(absolute_states(CHAIN, 10, 1, wrench=loads(10, 5)), CHAIN)
    plain = CompliantRobot(CHAIN, tuple(SPRINGS))
    biased = CompliantRobot(CHAIN, (*SPRINGS, PlacedEffect(WrenchBias(), Place("setup"), {"fz": 100.0})))
    change = np.abs(predict_observations(biased, data) - predict_observations(plain, data)).max(axis=0)
    assert change[:5].min() > 1e-5
    assert change[5:].max() < CLOSE

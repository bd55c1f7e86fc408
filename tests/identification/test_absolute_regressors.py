"""Derivatives of absolute places: what weight does to them is part of the displacement, and of its derivatives."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.identification.derivatives.observation import Observations, observe
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from stiffcal.stages.experiments import robot_to_fit
from stiffcal.stages.steps import RunContext, up_to_date_states

SOURCE = Path(__file__).parents[2] / "campaigns" / "absolute" / "05"
PLACES = {
    "bearing-tilt": Place("joints", (3,)),
    "link-beam": Place("links", link="swing"),
    "joint-translation": Place("joints", (2,)),
    "joint-eccentricity": Place("joints", (2,)),
    "joint-offset": Place("joints", (3,)),
    "link-geometry": Place("joints", (4,)),
}
SHAPES = {"joint-eccentricity": {"order": 2.0}}


@pytest.fixture(scope="module")
def at_hand(tmp_path_factory: pytest.TempPathFactory) -> tuple[CompliantRobot, Observations]:
    """Seven-axis robot with springs in its drives, and its poses: weight is the only load in half of them."""
    folder = shutil.copytree(SOURCE, tmp_path_factory.mktemp("absolute") / "05", ignore=shutil.ignore_patterns("store"))
    data = up_to_date_states(folder, RunContext())
    robot = robot_to_fit(data)
    values = {p.parameter_name("c"): 2e-5 for p in robot.placed if p.effect.name == "joint-compliance"}
    return robot.with_values(values), observe(data.states, robot.chain)


@pytest.mark.parametrize("name", PLACES)
def test_candidates_columns_are_differences_of_the_whole_balance(
    name: str, at_hand: tuple[CompliantRobot, Observations]
) -> None:
    robot, data = at_hand
    effect, place, shape = built_in_effects()[name], PLACES[name], SHAPES.get(name, {})
    state = Linearised.about(robot, data)
    regressor = state.regressor(effect, place, shape)
    assert regressor.symbols
    rounding = 1e-9 * float(np.abs(regressor.columns).max())
    for symbol, column in zip(regressor.symbols, regressor.columns, strict=True):
        step = 1e-2 * effect.spec(symbol).amplitude_of(effect.spec(symbol).typical)
        value = effect.spec(symbol).value_of(step)
        gives = replace(robot, placed=(*robot.placed, PlacedEffect(effect, place, {**shape, symbol: value})))
        moved = Linearised.about(gives, data).predicted
        difference = (moved - state.predicted) / step
        # sag of the balance is of second order: a per cent of what a robot gives
        assert np.abs(column - difference).max() < 0.02 * np.abs(difference).max() + rounding, symbol

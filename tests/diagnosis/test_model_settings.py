"""A value that model.toml holds wrong is named itself, and no effect for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.diagnosis.model_settings import search_with_settings
from stiffcal.diagnosis.search import search_missing
from stiffcal.diagnosis.search_results import Search
from stiffcal.diagnosis.setting_results import SettingKind
from stiffcal.identification.identify import Settings, fit_problem
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.model.catalogue import find_effects
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, Place
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

NOISE = Sigma(16e-6, 30e-6, 0.5, 0.1)
FIXED = "joint-compliance.j4.c"


def catalogue() -> Mapping[str, Effect]:
    return {name: find_effects()[name] for name in ("joint-compliance", "backlash", "bearing-tilt", "axis-coupling")}


def searched(states: LoadStates, robot: CompliantRobot, fixed: frozenset[str]) -> Search:
    def search_again(robot: CompliantRobot, settings: Settings) -> Search:
        return search_missing(states, robot, catalogue(), settings)

    settings = Settings(fixed=fixed)
    return search_with_settings(search_again(robot, settings), fit_problem(states, robot), settings, search_again)


def with_fixed_fourth(factor: float) -> CompliantRobot:
    """Return the joints' springs, the fourth of so many times its true compliance."""
    springs, true = joint_springs(six_axes()), medium_robot().placed[3].values["c"]
    fourth = PlacedEffect(springs.placed[3].effect, Place("joints", (4,)), {"c": factor * true})
    return replace(springs, placed=(*springs.placed[:3], fourth, *springs.placed[4:]))


def test_a_stiffness_that_is_fixed_wrong_is_named_and_no_effect() -> None:
    states = played(medium_robot(), runs=8, noise=NOISE, seed=3)
    search = searched(states, with_fixed_fourth(1.5), frozenset({FIXED}))
    (setting,) = search.contradicted
    assert (setting.setting, setting.parameter) == (SettingKind.FIXED, FIXED)
    true = medium_robot().placed[3].values["c"]
    assert setting.free_value == pytest.approx(true, abs=4.0 * (setting.free_std or 0.0))
    assert setting.fixed_at == pytest.approx(1.5 * true)
    assert search.found == ()
    assert not search.unexplained


def test_a_stiffness_that_is_fixed_right_is_left() -> None:
    states = played(medium_robot(), runs=8, noise=NOISE, seed=3)
    search = searched(states, with_fixed_fourth(1.0), frozenset({FIXED}))
    assert search.contradicted == ()
    assert search.found == ()


def test_what_is_missing_is_not_taken_for_a_wrong_value() -> None:
    """Backlash makes the joint seem softer than its spring is, which is fixed at what it is."""
    backlash = PlacedEffect(find_effects()["backlash"], Place("joints", (4,)), {"width": 2e-3, "band": 1.0})
    robot = medium_robot()
    states = played(replace(robot, placed=(*robot.placed, backlash)), runs=8, noise=NOISE, seed=3)
    search = searched(states, with_fixed_fourth(1.0), frozenset({FIXED}))
    assert [missing_effect.candidate.name for missing_effect in search.found] == ["backlash j4"]
    assert search.contradicted == ()


def test_the_first_order_balance_is_switched_where_the_deformation_shows() -> None:
    soft = medium_robot()
    placed = tuple(replace(one, values={"c": 10.0 * one.values["c"]}) for one in soft.placed)
    states = played(replace(soft, placed=placed), runs=8, noise=NOISE, seed=3)
    search = searched(states, joint_springs(six_axes(), deformed=False), frozenset())
    assert [setting.setting for setting in search.contradicted] == [SettingKind.BALANCE]
    assert search.found == ()
    assert np.sqrt(np.sum(search.final_scan.base.heldout) / search.final_scan.dof) < 1.05

"""A value on a bound of its range has no ±, and its interval ends in no bound that a search has."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.diagnosis.refits.refit_values import _at_bound, _interval
from stiffcal.estimate import Estimate
from stiffcal.estimation.parameters import Parameter, reported_parameters
from stiffcal.identification.answers.before_after import estimated_parameters
from stiffcal.identification.answers.document import identified_parameter, rest_in_words, resting_on_limits
from stiffcal.kinds.friction.answers.documents import _identified
from stiffcal.kinds.friction.answers.page import _value_cell
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from stiffcal.presentation.texts import printed_rows
from stiffcal.presentation.values import Table
from stiffcal.python.frames import parameters_frame
from stiffcal.show.builder import PageBuilder
from stiffcal.show.parameters import add_parameters
from stiffcal.view.gathering.models import _values
from tests.laboratory.effect_bench import robot_chain

BACKLASH = built_in_effects()["backlash"]
WIDTH = "backlash.j1.width"


def found(width: float, std: float = 1e-4) -> Parameter:
    """Return the width of a backlash as a fit reports it."""
    placed = PlacedEffect(BACKLASH, Place("joints", (1,)), {"width": width, "band": 3.0})
    reported = reported_parameters(CompliantRobot(robot_chain(), (placed,)), {WIDTH: std}, 2.0, frozenset())
    (parameter,) = (one for one in reported if one.name == WIDTH)
    return parameter


UPPER = BACKLASH.spec("width").upper


def test_inside_its_range_a_value_has_its_uncertainty() -> None:
    one = found(0.5 * UPPER)
    assert (one.std, one.at_bound) == (1e-4, False)
    assert one.interval == pytest.approx((0.5 * UPPER - 2e-4, 0.5 * UPPER + 2e-4))


def test_on_a_bound_the_interval_is_open_to_that_side() -> None:
    one = found(UPPER)
    assert (one.std, one.at_bound, one.above_noise) == (None, True, None)
    assert one.interval == pytest.approx((UPPER - 2e-4, math.inf))
    assert _interval(one.spec, UPPER, 2e-4) == [pytest.approx(UPPER - 2e-4), None]


@pytest.mark.parametrize(("width", "at_bound"), [(UPPER, True), (0.5 * UPPER, False)])
def test_a_refit_says_that_a_value_is_at_its_limit(width: float, at_bound: bool) -> None:
    assert _at_bound(found(width).spec, width, 2e-4) is at_bound


@pytest.mark.parametrize(
    ("width", "correlation", "resting"), [(UPPER, -0.8, [WIDTH]), (UPPER, 0.6, None), (0.5 * UPPER, 0.8, None)]
)
def test_what_rests_on_a_value_at_its_limit_says_so(
    width: float, correlation: float, resting: list[str] | None
) -> None:
    """Half of a variance are 0.71 of a correlation."""
    spread = np.diag([1e-6, 1e-4])
    covariance = spread @ np.array([[1.0, correlation], [correlation, 1.0]]) @ spread
    fit: Any = SimpleNamespace(
        parameters=(found(width),), free_names=("joint-compliance.j1.c", WIDTH), covariance=covariance
    )
    assert resting_on_limits(fit).get("joint-compliance.j1.c") == resting
    assert WIDTH not in resting_on_limits(fit)


@pytest.mark.parametrize(("names", "verb"), [([], ""), (["a"], " holds "), (["a", "b"], " hold ")])
def test_the_warning_agrees_with_how_many_values_rest_on_a_limit(names: list[str], verb: str) -> None:
    text = rest_in_words(names)
    assert bool(text) == bool(names)
    assert verb in text


def test_the_page_says_that_a_value_rests_on_a_limit() -> None:
    (one,) = estimated_parameters([replace(identified_parameter(found(0.5 * UPPER)), rests_on=["a.b.c"])])
    assert "a.b.c" in _values({one.name: one.estimate})[0].text


def test_what_is_absent_has_an_upper_limit() -> None:
    one = found(0.0)
    assert (one.std, one.at_bound, one.above_noise) == (None, True, False)
    assert one.interval == pytest.approx((0.0, 2e-4))


def test_of_a_stiffness_the_bound_is_that_of_its_compliance() -> None:
    """A parameter that counts by one over it, at the largest value that is possible."""
    inverse = next(spec for effect in built_in_effects().values() for spec in effect.parameters if spec.inverse)
    amplitude = 1.0 / inverse.lower
    assert _interval(inverse, amplitude, 0.1 * amplitude) == [0.0, pytest.approx(inverse.lower / 0.9)]


@pytest.mark.parametrize("width", [0.0, UPPER])
def test_no_medium_shows_an_uncertainty(width: float) -> None:
    answered = identified_parameter(found(width))
    assert (answered.std, answered.at_bound) == (None, True)
    assert answered.interval is not None
    assert (answered.interval[1] is None) == (width > 0.0)
    made = PageBuilder("")
    add_parameters(made, [answered])
    (table,) = made.page().blocks
    assert isinstance(table, Table)
    assert not any("±" in cell for cell in printed_rows(table)[0])
    row = parameters_frame([answered]).loc[WIDTH]
    assert row["at_bound"]
    assert row.isna()["std"]
    assert (row["high_95"] == math.inf) == (width > 0.0)
    of_friction = _identified(found(UPPER), None)
    assert of_friction.interval == [pytest.approx(UPPER - 2e-4), None]
    assert not any(isinstance(word, Estimate) for word in _value_cell(of_friction))

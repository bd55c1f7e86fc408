"""Places measured once each: a set of many different laws fits whatever moves the robot, and is no answer."""

from __future__ import annotations

import pytest

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.load_search_context import LoadSearchContext
from stiffcal.identification.identify import Settings, fit_problem
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.catalogue import built_in_effects
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import Place
from tests.laboratory.absolute_places import absolute_states
from tests.laboratory.effect_bench import bare_states, robot_chain

FOUR = ("joint-eccentricity", "cubic-stiffness", "periodic-stiffness", "bearing-tilt")


def candidates(*names: str) -> list[Candidate]:
    """Return effects, each at a joint of its own."""
    catalogue = built_in_effects()
    return [Candidate(catalogue[name], Place("joints", (k + 1,)), 2) for k, name in enumerate(names)]


def context(states: LoadStates) -> LoadSearchContext:
    robot = CompliantRobot(robot_chain(), ())
    return LoadSearchContext(states, fit_problem(states, robot), built_in_effects(), Settings())


@pytest.mark.parametrize(
    ("names", "mimics"),
    [
        (FOUR, True),
        (FOUR[:3], False),
        # one law at five joints is one law: the geometry of a robot, play of all its gears
        (("link-geometry",) * 5, False),
        (("joint-full",), False),
        (("joint-full", "joint-full"), True),
    ],
)
def test_more_laws_than_are_asked_for(names: tuple[str, ...], mimics: bool) -> None:
    places = context(absolute_states(robot_chain(), 12, 1))
    assert places.mimics_anything(candidates(*names)) is mimics


def test_loads_come_in_steps_that_laws_have_to_follow() -> None:
    assert not context(bare_states([0, 0, 1, 1])).mimics_anything(candidates(*FOUR))

"""What is named where one of several supported effects is undecided: a lesser one leaves the others named."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.decision import decide
from stiffcal.diagnosis.deletions import Rival
from stiffcal.diagnosis.document import diagnosis_result
from stiffcal.diagnosis.judge import Judgement
from stiffcal.diagnosis.search import search_missing
from stiffcal.diagnosis.search_results import MissingEffect, Search
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.model.catalogue import built_in_effects
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import Place
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

SUPPORTED = Judgement(fall=1.0, errors=9.0, p_value=0.0, possible=True)
OTHER, BESIDES = (Candidate(built_in_effects()["bearing-tilt"], Place("joints", (joint,)), 2) for joint in (4, 5))


def effect_at(joint: int, *rivals: Rival) -> MissingEffect:
    """Return a supported effect at a joint."""
    candidate = Candidate(built_in_effects()["bearing-tilt"], Place("joints", (joint,)), 2)
    return MissingEffect(candidate, (), SUPPORTED, rivals)


BY_A_POSE = (Rival(OTHER, 0.6, (3,)), Rival(BESIDES, 0.4, ()))
TOO_MANY = (Rival(OTHER, 0.3, ()), Rival(BESIDES, 0.2, ()))


def test_a_lesser_effect_that_a_pose_decides_leaves_the_others_named() -> None:
    first, second, third = effect_at(1), effect_at(2, *BY_A_POSE), effect_at(3)
    decision = decide((first, second, third))
    assert decision.named == (first, third)
    assert decision.undecided == ()
    assert decision.undecided_next == BY_A_POSE


@pytest.mark.parametrize("rivals", [BY_A_POSE, TOO_MANY])
def test_nothing_is_named_where_the_first_effect_is_undecided(rivals: tuple[Rival, ...]) -> None:
    decision = decide((effect_at(1, *rivals), effect_at(2)))
    assert decision.named == ()
    assert decision.undecided == rivals
    assert decision.undecided_next == ()


def test_a_lesser_effect_among_many_look_alikes_is_named() -> None:
    effects = (effect_at(1), effect_at(2, *TOO_MANY))
    assert decide(effects).named == effects
    assert decide(effects).undecided_next == ()


def test_all_are_named_where_none_is_undecided() -> None:
    effects = (effect_at(1), effect_at(2))
    assert decide(effects).named == effects
    assert decide(()).named == ()


@cache
def searched() -> tuple[LoadStates, Search]:
    """Search a campaign in which a bearing tilts."""
    robot = medium_robot()
    tilt = PlacedEffect(built_in_effects()["bearing-tilt"], Place("joints", (3,)), {"x": 6e-7, "y": 3e-7})
    states = played(
        replace(robot, placed=(*robot.placed, tilt)),
        runs=8,
        noise=Sigma(16e-6, 30e-6, 0.5, 0.1),
        load_scatter=0.03,
        seed=11,
    )
    catalogue = {"bearing-tilt": built_in_effects()["bearing-tilt"]}
    return states, search_missing(states, joint_springs(six_axes()), catalogue)


def test_the_answer_names_the_first_and_says_that_the_next_is_open() -> None:
    states, search = searched()
    assert search.undecided_next == ()
    plain = diagnosis_result(states, search)
    answer = diagnosis_result(states, replace(search, undecided_next=BY_A_POSE))
    assert [missing.effect for missing in answer.missing] == ["bearing-tilt"]
    assert answer.missing == plain.missing
    assert answer.undecided == []
    assert len(answer.summary) > len(plain.summary)

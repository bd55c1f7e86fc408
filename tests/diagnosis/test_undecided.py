"""What is named where one of several supported effects is undecided: a lesser one leaves the others named."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.decision import decide
from stiffcal.diagnosis.deletions import Rival
from stiffcal.diagnosis.judge import Judgement
from stiffcal.diagnosis.search_results import MissingEffect
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.judgement.document import diagnosis_result
from stiffcal.measurements.load_states import Sigma
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


@pytest.mark.long
def test_an_effect_that_has_less_than_half_of_its_group_is_undecided() -> None:
    """The tilt of a wrist joint shows a third of the noise: joints 4, 5 and 6 are not distinguished."""
    robot, tilt = medium_robot(), built_in_effects()["bearing-tilt"]
    hidden = PlacedEffect(tilt, Place("joints", (5,)), {"x": 1e-6, "y": 1e-6})
    states = played(replace(robot, placed=(*robot.placed, hidden)), runs=8, noise=Sigma(16e-6, 30e-6, 0.5, 0.1), seed=2)
    answer = diagnosis_result(diagnose_states(states, joint_springs(six_axes()), {"bearing-tilt": tilt}))
    (missing,) = answer.missing
    assert missing.firm is False
    assert missing.probability == pytest.approx(1.0, abs=0.01)
    assert missing.member_probability is not None
    assert missing.member_probability < 0.5
    assert [5] in [one.where.joints for one in answer.undecided]
    assert sum(one.share or 0.0 for one in answer.undecided) == pytest.approx(1.0, abs=0.06)
    assert [one.probability for one in answer.undecided] == [one.share for one in answer.undecided]
    assert "undecided" in answer.summary

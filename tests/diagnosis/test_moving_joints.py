"""Effects of moving joints are found in simulated logs, and nothing where there is nothing."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.judgement.diagnosed_rows import DiagnosedRows, diagnose_rows
from stiffcal.judgement.row_document import row_diagnosis
from stiffcal.model.catalogue.catalogue import find_effects
from tests.laboratory.hidden_friction import NOISE, Law, nothing, problem_of


def diagnosed(law: Law, joint: int = 1, temperature: bool = True, seed: int = 0) -> DiagnosedRows:
    return diagnose_rows(problem_of(law, joint, temperature, seed), find_effects())


def named(found: DiagnosedRows) -> set[str]:
    return {one.candidate.name for one in found.found}


@pytest.mark.parametrize("seed", range(3))
def test_nothing_is_named_where_nothing_is_missing(seed: int) -> None:
    found = diagnosed(nothing, seed=seed)
    assert named(found) == set()
    assert not found.unexplained
    assert found.adequate
    assert found.reading.p_nothing > 0.99


LAWS: dict[str, Law] = {
    "stribeck j1": lambda angle, velocity, warm: 8.0 * np.exp(-np.abs(velocity / 0.06)) * np.sign(velocity),
    "torque-ripple j1": lambda angle, velocity, warm: 2.0 * np.cos(12.0 * angle) - 1.0 * np.sin(12.0 * angle),
    "friction-temperature j1": lambda angle, velocity, warm: -0.3 * warm * np.sign(velocity) - 0.5 * warm * velocity,
    "friction-asymmetry j1": lambda angle, velocity, warm: 1.5 * np.sign(velocity) ** 2,
}


@pytest.mark.parametrize("name", sorted(LAWS))
def test_one_effect_is_named_alone_and_certain(name: str) -> None:
    found = diagnosed(LAWS[name])
    assert named(found) == {name}
    assert found.found[0].group.firm
    assert not found.unexplained
    assert found.after is not None
    assert found.after.adequate


def both(angle: Floats, velocity: Floats, warm: Floats) -> Floats:
    return LAWS["stribeck j1"](angle, velocity, warm) + LAWS["torque-ripple j1"](angle, velocity, warm)


def test_two_effects_are_both_named() -> None:
    found = diagnosed(both)
    assert named(found) == {"stribeck j1", "torque-ripple j1"}
    values = {parameter.name: parameter for parameter in found.last.fit.parameters}
    assert values["torque-ripple.j1.order"].value == 12.0
    for name, truth in (("stribeck.j1.stribeck", 8.0), ("stribeck.j1.velocity", 0.06), ("torque-ripple.j1.a", 2.0)):
        parameter = values[name]
        assert parameter.value is not None
        assert parameter.std is not None
        assert abs(parameter.value - truth) < 4.0 * parameter.std, name


def test_an_effect_of_the_model_is_as_probable_as_before_it_was_added() -> None:
    lacking = diagnosed(both)
    missing = {one.candidate.name: one.group.probability for one in lacking.found}
    model = {"stribeck": {"stribeck": 8.0, "velocity": 0.06, "exponent": 1.0}, "torque-ripple": {"order": 12.0}}
    whole = diagnose_rows(problem_of(both, added=model), find_effects())
    held = {one.candidate.name: one.group.probability for one in whole.held}
    assert whole.found == ()
    assert whole.superfluous == ()
    assert held == pytest.approx(missing, abs=0.02)


def test_where_the_model_has_no_friction_that_and_what_is_on_top_of_it_are_named() -> None:
    """The speed of a Stribeck term is sought with the friction refitted: next to the fit without it another is best."""
    found = diagnose_rows(problem_of(LAWS["stribeck j1"], with_friction=False), find_effects())
    assert [one.candidate.name for one in found.found] == ["joint-friction j1", "stribeck j1"]
    assert all(one.group.firm for one in found.found)
    assert not found.unexplained


def test_an_effect_that_the_model_holds_for_nothing_is_superfluous() -> None:
    model = {"stribeck": {"stribeck": 1.0, "velocity": 0.06, "exponent": 1.0}}
    found = diagnose_rows(problem_of(nothing, added=model), find_effects())
    assert [one.effect.name for one in found.superfluous] == ["stribeck"]


def test_what_no_effect_accounts_for_is_a_law_of_its_own_and_follows_the_angle() -> None:
    """Friction that swings with the angle and changes its sign with the direction is outside the catalogue."""
    found = diagnosed(lambda angle, velocity, warm: 5.0 * angle**2 * np.sign(velocity))
    assert found.unexplained
    assert [(law.place, law.follows) for law in found.reading.unlisted][:1] == [("joint 1", "its angle and direction")]
    assert not any(one.group.firm for one in found.found)


def test_passes_that_differ_each_in_its_own_way_are_no_effect() -> None:
    """Where speeds were not repeated, the friction of each pass is what several laws of speed would be."""
    found = diagnose_rows(problem_of(nothing, per_pass=1.5, seed=2), find_effects())
    assert not any(one.group.firm for one in found.found)
    assert found.unexplained
    assert found.reading.p_nothing < 0.1
    # passes that answer in ways of their own, and laws of no catalogue, say the same here
    assert found.reading.p_unknown > 0.9


def test_without_a_logged_temperature_its_effect_is_not_tried() -> None:
    found = diagnosed(LAWS["friction-temperature j1"], temperature=False)
    assert "friction-temperature" in {effect.effect for effect in found.not_tried}
    assert "friction-temperature j1" not in named(found)


def test_next_to_weight_a_constant_torque_is_not_tried() -> None:
    found = diagnosed(lambda angle, velocity, warm: 300.0 * np.cos(angle), joint=2)
    assert "friction-asymmetry" in {effect.effect for effect in found.not_tried}
    assert named(found) == set()
    assert not found.unexplained
    assert not found.judged.drift.drifts


def test_the_answer_has_torques_in_its_measure() -> None:
    answer = row_diagnosis(diagnosed(LAWS["stribeck j1"]))
    (missing,) = answer.missing
    assert (missing.effect, missing.firm) == ("stribeck", True)
    assert missing.probability is not None
    assert missing.probability > 0.99
    assert answer.p_nothing == pytest.approx(0.0, abs=1e-6)
    assert answer.excluded_sizes is None
    assert answer.rms.torque is not None
    assert answer.noise is not None
    assert answer.noise.torque is not None
    assert answer.heldout_rms_with_missing is not None
    assert answer.heldout_rms_with_missing.torque == pytest.approx(answer.noise.torque, rel=0.12)
    first = answer.findings[0]
    assert (first.effect, first.verdict, first.confidence) == ("stribeck", "supported", None)
    assert first.size_m is None
    assert first.size_Nm is not None
    assert first.size_Nm > 0.0


def test_where_nothing_is_found_the_answer_says_what_would_have_been() -> None:
    """Of the effect that shows least: a ripple of twice that size is found."""
    (excluded,) = row_diagnosis(diagnosed(nothing)).excluded_sizes or []
    assert excluded.where.joints == [1]
    assert excluded.size_m is None
    assert excluded.size_Nm is not None
    assert 0.02 * NOISE < excluded.size_Nm < NOISE
    size = 2.0 * np.sqrt(2.0) * excluded.size_Nm
    assert named(diagnosed(lambda angle, velocity, warm: size * np.cos(12.0 * angle))) == {"torque-ripple j1"}


@pytest.mark.parametrize("rises_once", [True, False])
def test_time_would_do_for_a_temperature_that_rises_once(rises_once: bool) -> None:
    problem = problem_of(LAWS["friction-temperature j1"], rises_once=rises_once)
    found = diagnose_rows(problem, find_effects())
    (missing,) = found.found
    assert missing.candidate.name == "friction-temperature j1"
    assert found.time_would_do(missing.candidate) is rises_once
    assert any("time explains it" in text for text in row_diagnosis(found).warnings) is rises_once


def test_of_many_rows_means_are_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stiffcal.judgement.rows.MOST_BINS", 120)
    found = diagnosed(both)
    assert len(found.judged.ground.space.data.run) <= 120
    assert named(found) == {"stribeck j1", "torque-ripple j1"}
    assert all(one.group.firm for one in found.found)
    assert not found.unexplained


def test_what_these_runs_cannot_show_is_not_called_superfluous() -> None:
    """Without a logged temperature nothing says whether friction follows it."""
    model = {"friction-temperature": {"coulomb_K": -0.3, "viscous_K": -0.5}}
    problem = problem_of(nothing, temperature=False, added=model)
    found = diagnose_rows(problem, find_effects())
    assert found.superfluous == ()
    assert found.held == ()
    assert found.judged.model == frozenset()

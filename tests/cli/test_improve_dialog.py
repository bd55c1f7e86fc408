"""What `improve` asks at a terminal: reason, expected error and look-alikes; each answer does what it says."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.cli.improve_dialog import ImproveDialog
from stiffcal.diagnosis.answers.results import LookAlike, ProposedEffect
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import EffectAt, Where
from stiffcal.results.improve_results import ImproveStep
from stiffcal.show.ladder import gain_in_words

JOINT = Where(joints=[4])
TILT, BEAM = EffectAt(effect="bearing-tilt", where=JOINT), EffectAt(effect="link-beam", where=Where(links=["swing"]))


def finding(effect: str, where: Where, after: float, verdict: str = "possible") -> Any:
    """Return a finding with an error after it."""
    evidence = SimpleNamespace(seen="REASON", means="MEANS", alike="", check="CHECK")
    return SimpleNamespace(
        effect=effect, where=where, verdict=verdict, explains=0.98, why="WHY", evidence=evidence, confidence=None,
        probability=0.98,        heldout_rms_before=Rms(1.33e-4, None), heldout_rms_after=Rms(after, None),
    )  # fmt: skip


def proposal(change: str = "add") -> Any:
    """Return the proposal of backlash at joint 4, which looks like a bearing's tilt."""
    findings = [
        finding("backlash", JOINT, 3.1e-5, "supported"),
        finding("link-beam", BEAM.where, 5.2e-5),
        finding("creep", JOINT, 1.33e-4, "rejected"),
    ]

    def finding_of(effect: Any) -> Any:
        return next((item for item in findings if (item.effect, item.where) == (effect.effect, effect.where)), None)

    alike = LookAlike(effect=TILT.effect, where=TILT.where, probability=0.25)
    effect = ProposedEffect(
        effect="backlash", where=JOINT, alternatives=[alike], probability=0.8, member_probability=0.75, firm=False
    )
    return SimpleNamespace(
        change=change,
        effect=effect,
        diagnosed=SimpleNamespace(findings=findings, finding_of=finding_of, explained_by=lambda one: 0.97),
    )


def decide(*typed: str, change: str = "add") -> tuple[Any, str]:
    """Return the decision of a user who types these words, and all that was shown."""
    answers, lines = list(typed), list[str]()
    decision = ImproveDialog(lines.append, lambda question, default: answers.pop(0) or default)(proposal(change))
    assert not answers
    return decision, "\n".join(lines)


@pytest.mark.parametrize(
    ("typed", "decision"),
    [("", "yes"), ("y", "yes"), ("Yes", "yes"), ("s", "skip"), ("q", "stop"), ("n", "stop"), ("no", "stop")],
)
def test_a_word_or_its_first_letter_decides(typed: str, decision: str) -> None:
    assert decide(typed)[0] == decision


def test_the_reason_the_expected_error_and_the_look_alikes_come_first() -> None:
    _, text = decide("y")
    for shown in ("backlash (joint 4)", "REASON", "0.133 mm", "0.0310 mm", "97 %", "bearing-tilt (joint 4) 20 %"):
        assert shown in text
    assert "probability: 60 %, not certain, of it or a look-alike 80 %" in text
    assert "MEANS" not in text


def test_details_then_the_same_question() -> None:
    decision, text = decide("d", "s")
    assert decision == "skip"
    assert "WHY" not in text
    assert "MEANS" in text
    assert "CHECK" in text


def test_another_effect_look_alikes_first_and_nothing_rejected() -> None:
    assert decide("o", "1")[0] == TILT
    decision, text = decide("o", "2")
    assert decision == BEAM
    assert "creep" not in text
    for back in ("0", "3", "x", "-1"):
        assert decide("o", back, "y")[0] == "yes"


def test_a_removal_has_no_look_alikes() -> None:
    decision, text = decide("o", "y", change="remove")
    assert decision == "yes"
    assert "look" not in text


def test_any_other_word_asks_again() -> None:
    assert decide("perhaps", "y")[0] == "yes"


@pytest.mark.parametrize(("before", "after", "says"), [(1.2e-4, 3e-5, True), (1.2e-4, 1.3e-4, False)])
def test_what_was_gained_stands_apart_from_the_verdict_on_the_rest(before: float, after: float, says: bool) -> None:
    steps = [
        ImproveStep(action="start", effect=None, where=Where(), heldout_rms=Rms(before, None), noise=None),
        ImproveStep(action="add", effect="backlash", where=JOINT, heldout_rms=Rms(after, None), noise=None),
    ]
    assert ("backlash" in gain_in_words(steps)) == says


def _step(action: Any, effect: str | None, error: Rms) -> ImproveStep:
    return ImproveStep(action=action, effect=effect, where=JOINT if effect else Where(), heldout_rms=error, noise=None)


def test_what_was_taken_out_again_is_no_gain() -> None:
    start, lower = Rms(1.2e-4, None), Rms(3e-5, None)
    steps = [_step("start", None, start), _step("add", "backlash", lower), _step("add", "creep", lower)]
    gain = gain_in_words([*steps, _step("remove", "backlash", lower)])
    assert "creep" in gain
    assert "backlash" not in gain
    assert gain_in_words([*steps[:2], _step("remove", "backlash", lower)]) == ""
    back = [*steps, _step("remove", "backlash", lower), _step("add", "backlash", lower)]
    assert "backlash" in gain_in_words(back)


@pytest.mark.parametrize(
    ("after", "shown"),
    [
        (Rms(1.3e-4, 1e-4), None),
        (Rms(3e-5, 3e-4), "from 0.120 mm to 0.0300 mm"),
        (Rms(3e-5, 1e-4), "from 0.120 mm, 0.200 mrad to 0.0300 mm, 0.100 mrad"),
    ],
)
def test_the_leading_measure_decides_what_was_gained(after: Rms, shown: str | None) -> None:
    gain = gain_in_words([_step("start", None, Rms(1.2e-4, 2e-4)), _step("add", "backlash", after)])
    assert gain == "" if shown is None else shown in gain

"""`plan --tell`: which effects are meant, and what the runs would settle."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from stiffcal.commands.plan import plan_campaign
from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.planning.campaign.rivals import named_rival
from tests.commands.plan.test_plan import LOAD, irb4400, with_plan

__all__ = ["irb4400"]  # the fixture
TWO = ("backlash j4", "two-slope j4")


@pytest.mark.parametrize(
    ("text", "effect", "kind", "place"),
    [
        ("backlash j4", "backlash", "joints", 4),
        ("backlash 4", "backlash", "joints", 4),
        ("link-beam swing", "link-beam", "links", "swing"),
        ("axis-coupling j3-j5", "axis-coupling", "pairs", [3, 5]),
    ],
)
def test_an_effect_and_its_place(text: str, effect: str, kind: str, place: object) -> None:
    rival = named_rival(text)
    assert rival.effect == effect
    assert dict(rival.where.items()) == {kind: [place]}


def test_an_effect_of_the_set_up_has_no_place() -> None:
    assert not dict(named_rival("seat-shift").where.items())


def test_runs_for_two_effects_load_in_both_senses(irb4400: Path) -> None:
    plan = plan_campaign(with_plan(irb4400, "runs = 6\n" + LOAD, 16), request=PlanRequest(rivals=TWO))
    assert plan.criterion == "rivals"
    assert [(entry.truth, entry.rival) for entry in plan.separations or []] == [TWO[::-1], TWO]
    for run in plan.runs:
        along = run.wrench[:, :3] @ run.wrench[3, :3]
        assert (along > 0.0).any()
        assert (along < 0.0).any()
    # the model's own parameters have their expected uncertainties all the same
    assert all(parameter.relative is not None for parameter in plan.parameters[:5])


def test_more_runs_separate_more(irb4400: Path) -> None:
    few, many = (
        plan_campaign(with_plan(irb4400, f"runs = {n}\n" + LOAD, 20), request=PlanRequest(rivals=TWO)).separations or []
        for n in (2, 8)
    )
    assert min(entry.chi_square for entry in many) > 2.0 * min(entry.chi_square for entry in few) > 0.0
    for entry in (*few, *many):
        assert entry.distinguished == (entry.chi_square >= entry.needed)


def test_what_stays_alike_is_a_warning(irb4400: Path) -> None:
    text = "runs = 2\n[noise]\ntranslation_m = 1e-3\n" + LOAD
    plan = plan_campaign(with_plan(irb4400, text, 16), request=PlanRequest(rivals=TWO))
    assert not any(entry.distinguished for entry in plan.separations or [])
    assert len([warning for warning in plan.warnings if all(name in warning for name in TWO)]) == 2


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("backlash j4 j5", FaultCode.OPTION_INVALID),
        ("", FaultCode.OPTION_INVALID),
        ("nothing j4", FaultCode.EFFECT_UNKNOWN),
        ("backlash j9", FaultCode.JOINT_UNKNOWN),
        ("backlash swing", FaultCode.PLACE_INVALID),
        ("backlash", FaultCode.PLACE_INVALID),
    ],
)
def test_a_wrong_rival_is_named(irb4400: Path, text: str, code: FaultCode) -> None:
    with pytest.raises(InputError) as raised:
        plan_campaign(with_plan(irb4400, LOAD), request=PlanRequest(rivals=("two-slope j4", text)))
    assert raised.value.code == code
    assert "\n" not in str(raised.value.faults[0])
    # `plan` has no option for a place
    assert not re.search(r"--(joints|links|all)", str(raised.value)) or code is FaultCode.JOINT_UNKNOWN


def test_look_alikes_of_a_diagnosis_that_names_none_are_refused(irb4400: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Nothing:
        missing: tuple[DiagnoseResult, ...] = ()
        undecided: tuple[DiagnoseResult, ...] = ()

    monkeypatch.setattr("stiffcal.commands.diagnose.diagnose_campaign", lambda *_: Nothing())
    with pytest.raises(InputError) as raised:
        plan_campaign(with_plan(irb4400, LOAD), request=PlanRequest(purpose="look-alikes"))
    assert raised.value.code == FaultCode.DATA_MISSING

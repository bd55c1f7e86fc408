"""Answers of searches that share no parameter become one."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stiffcal.diagnosis.answers.results import (
    DiagnoseResult,
    ExcludedSizeAt,
    ProposedEffect,
    SearchPace,
    UndecidedEffect,
    UnknownLaw,
    UntestableEffect,
)
from stiffcal.diagnosis.merging import PartialDiagnosis, merged_diagnosis
from stiffcal.diagnosis.scans.explained import Explained
from stiffcal.identification.readings.search_subject import SearchSubject
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import EffectAt, Where

MOTION = SearchSubject("motion", "Torque over motion", "at held-out speeds")
CLAMPED = SearchSubject("clamped", "Torque over angle", "in held-out data")
PACE = SearchPace(models=1, candidates=2, signatures=3, seconds=0.5, candidates_per_second=4.0)
EMPTY = DiagnoseResult(
    warnings=[], adequate=True, noise=Rms(None, None, torque=1.0), rms=Rms(None, None, torque=1.0), lack_of_fit=None,
    missing=[], could_be=[], findings=[], next_measurement=None, not_tried=[], unexplained=False, structure=[],
    heldout_rms_after_choosing=Rms(None, None, torque=1.0), parameters_with_missing=[], pace=PACE, summary="ok",
    superfluous=[], evidence=[], fit_id="", key="",
)  # fmt: skip


def proposed(name: str, joint: int) -> ProposedEffect:
    return ProposedEffect(effect=name, where=Where(joints=[joint]), alternatives=[])


def undecided(joint: int) -> DiagnoseResult:
    effect = UndecidedEffect(effect="stribeck", where=Where(joints=[joint]), share=0.5, deciding_runs=[])
    return replace(EMPTY, adequate=False, undecided=[effect])


def test_most_important_first() -> None:
    small = replace(EMPTY, adequate=False, missing=[proposed("stribeck", 1)])
    large = replace(EMPTY, adequate=False, missing=[proposed("torque-ripple", 2)], rms=Rms(None, None, torque=3.0))
    parts = [PartialDiagnosis(small, (0.2,), 300, (1,)), PartialDiagnosis(large, (2.0,), 100, (2,))]
    merged = merged_diagnosis(parts)
    assert [effect.effect for effect in merged.missing] == ["torque-ripple", "stribeck"]
    assert merged.adequate is False
    assert merged.rms.torque == ((300 * 1.0 + 100 * 9.0) / 400) ** 0.5
    assert merged.pace.candidates == 4


def test_what_is_undecided_in_one_search_stands_next_to_what_another_names() -> None:
    named = replace(EMPTY, adequate=False, missing=[proposed("stribeck", 1)])
    merged = merged_diagnosis([PartialDiagnosis(undecided(2), (), 10, (2,)), PartialDiagnosis(named, (1.0,), 10, (1,))])
    assert [effect.where.joints for effect in merged.undecided] == [[2]]
    assert len(merged.missing) == 1


def law(joint: int, p: float) -> UnknownLaw:
    return UnknownLaw(follows="time", where=Where(joints=[joint]), of=f"joint {joint}", probability=p, curve=None)


def excluded(joint: int) -> ExcludedSizeAt:
    return ExcludedSizeAt(
        where=Where(joints=[joint]), of=f"joint {joint}", size_m=None, size_Nm=0.1, effect="breakaway"
    )


def test_probabilities_of_searches_that_share_nothing_multiply() -> None:
    results = [
        replace(
            EMPTY, p_nothing=p, p_unknown=q, unknown=[law(joint, q)], excluded_sizes=[excluded(joint)],
            in_model=[proposed("stribeck", joint)], not_weighed=q,
        )
        for joint, p, q in ((1, 0.9, 0.1), (2, 0.8, 0.5))
    ]  # fmt: skip
    merged = merged_diagnosis([PartialDiagnosis(result, (), 1) for result in results])
    assert merged.p_nothing == pytest.approx(0.72)
    assert merged.p_unknown == pytest.approx(1.0 - 0.9 * 0.5)
    assert merged.not_weighed == pytest.approx(1.0 - 0.9 * 0.5)
    assert [law.of for law in merged.unknown or []] == ["joint 2", "joint 1"]
    assert [one.of for one in merged.excluded_sizes or []] == ["joint 1", "joint 2"]
    assert [one.where.joints for one in merged.in_model or []] == [[1], [2]]
    named = replace(results[1], adequate=False, missing=[proposed("stribeck", 2)], excluded_sizes=None)
    merged = merged_diagnosis([PartialDiagnosis(results[0], (), 1), PartialDiagnosis(named, (1.0,), 1)])
    assert merged.excluded_sizes is None


def test_adequate_where_all_are() -> None:
    unknown = replace(EMPTY, adequate=None, unexplained=None)
    assert merged_diagnosis([PartialDiagnosis(EMPTY, (), 1, (1,)), PartialDiagnosis(EMPTY, (), 1, (2,))]).adequate
    assert merged_diagnosis([PartialDiagnosis(EMPTY, (), 1), PartialDiagnosis(unknown, (), 1)]).adequate is None
    unexplained = replace(EMPTY, adequate=False, unexplained=True)
    assert merged_diagnosis([PartialDiagnosis(EMPTY, (), 1), PartialDiagnosis(unexplained, (), 1)]).unexplained


def test_joints_in_which_nothing_is_missing_share_a_sentence() -> None:
    # each search has words of its own, which are the same
    parts = [PartialDiagnosis(EMPTY, (), 1, (joint,), replace(MOTION)) for joint in (3, 1)]
    assert merged_diagnosis(parts).summary.count(".") == 1
    assert "1, 3" in merged_diagnosis(parts).summary


def test_an_effect_carries_the_search_that_found_it() -> None:
    """What shares no parameter can be added in one step; what several searches find of the set-up is one effect."""
    plate = ProposedEffect(effect="fixture-compliance", where=Where(), alternatives=[])
    results = [replace(EMPTY, adequate=False, missing=[proposed("backlash", joint), plate]) for joint in (2, 5)]
    parts = [
        PartialDiagnosis(result, (fall, 0.1), 10, (joint,), CLAMPED)
        for result, joint, fall in zip(results, (2, 5), (1.0, 3.0), strict=True)
    ]
    merged = merged_diagnosis(parts)
    names = [(effect.effect, effect.searched_in) for effect in merged.missing]
    assert names == [
        ("backlash", "clamped-j5"), ("backlash", "clamped-j2"), ("fixture-compliance", "clamped-j2"),
    ]  # fmt: skip
    assert merged_diagnosis(parts[:1]).missing[0].searched_in is None


def test_what_the_set_up_needs_anywhere_stays() -> None:
    plate, spring = (
        EffectAt(effect="fixture-compliance", where=Where()),
        EffectAt(effect="creep", where=Where(joints=[2])),
    )
    first = replace(EMPTY, superfluous=[plate, spring])
    assert merged_diagnosis([PartialDiagnosis(first, (), 1), PartialDiagnosis(EMPTY, (), 1)]).superfluous == [spring]
    both = merged_diagnosis(
        [PartialDiagnosis(first, (), 1), PartialDiagnosis(replace(EMPTY, superfluous=[plate]), (), 1)]
    )
    assert both.superfluous == [plate, spring]


def test_shares_count_by_what_is_avoidable() -> None:
    shares = (Explained(1.0, 0.9, 1.0, 300.0), Explained(0.5, 0.4, 0.6, 100.0))
    parts = [
        PartialDiagnosis(replace(EMPTY, explained_by_missing=0.0), (), 10, (k,), CLAMPED, share)
        for k, share in enumerate(shares, start=1)
    ]
    merged = merged_diagnosis(parts)
    assert merged.explained_by_missing == 0.875
    assert merged.explained_interval is not None
    assert merged.explained_interval[0] == 0.875 - ((0.75 * 0.1) ** 2 + (0.25 * 0.1) ** 2) ** 0.5


def test_what_one_search_tried_or_the_model_holds_is_not_called_untried() -> None:
    def lacking(*pairs: tuple[str, str]) -> list[UntestableEffect]:
        return [UntestableEffect(effect=effect, needs=needs) for effect, needs in pairs]

    clamped = lacking(("friction-load", "friction runs"), ("joint-friction", "friction runs"), ("creep", "times"))
    parts = [
        PartialDiagnosis(replace(EMPTY, not_tried=clamped), (), 1, (1,), CLAMPED),
        PartialDiagnosis(replace(EMPTY, not_tried=lacking(("friction-load", "masses"))), (), 1, (1,), MOTION),
    ]
    merged = merged_diagnosis(parts, in_model=["joint-friction"])
    assert merged.not_tried == lacking(("friction-load", "masses"), ("creep", "times"))

"""Thresholds: each judged by itself, in numbers that anybody can check by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from stiffcal.campaign.manifest.thresholds import Thresholds
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.validation.results import Verdict
from stiffcal.validation.thresholds import Baseline, judge
from stiffcal.wording import significant
from tests.laboratory.fits import parameter, validation_of

JOINTS = ("A1", "A2", "A3")
VALIDATION = validation_of(
    scheme="leave-one-pose-out",
    rms={"translation": 2e-4, "rotation": 3e-4},
    relative={"translation": 0.2, "rotation": None},
    noise={"translation": 1e-4, "rotation": 1e-4},
)


def compliance(joint: int, value: float | None, std: float = 1e-9, symbol: str = "c") -> IdentifiedParameter:
    return parameter(
        f"joint-compliance.j{joint}.{symbol}",
        value,
        std,
        where={"joints": [joint]},
        stiffness=1.0 / value if value else None,
        stiffness_std=None,
    )


def reported(
    limits: dict[str, Any], *parameters: IdentifiedParameter, before: tuple[IdentifiedParameter, ...] = ()
) -> list[Any]:
    baseline = Baseline("before", {earlier.name: earlier for earlier in before}) if before else None
    checks = judge(Thresholds(**limits), parameters, VALIDATION, JOINTS, baseline)
    return [(check.threshold, check.where, check.held) for check in checks]


@pytest.mark.parametrize(
    ("limits", "held"),
    [
        ({"max_rms_m": 2.1e-4}, True),
        ({"max_rms_m": 1.9e-4}, False),
        ({"max_rms_rad": 2.9e-4}, False),
        ({"max_relative": 0.21}, True),
        ({"max_relative": 0.19}, False),
        ({"max_over_noise": 2.1}, True),
        ({"max_over_noise": 1.9}, False),
    ],
)
def test_errors_in_held_out_poses(limits: dict[str, float], held: bool) -> None:
    assert reported(limits) == [(next(iter(limits)), "", held)]


def test_an_error_is_said_in_millimetres() -> None:
    (check,) = judge(Thresholds(max_rms_m=1e-4), [], VALIDATION, JOINTS, None)
    assert check.says == "rms in held-out poses 0.200 mm is above max_rms_m = 0.100 mm"
    answer = VALIDATION.judged(Verdict([check], {"max_rms_m": 1e-4}))
    assert (answer.passed, answer.failed, answer.thresholds) == (False, [check.says], {"max_rms_m": 1e-4})


def test_what_is_not_known_is_not_judged_and_does_not_fail() -> None:
    unknown = replace(VALIDATION, noise=None)
    checks = judge(Thresholds(max_over_noise=1.5), [], unknown, JOINTS, None)
    answer = VALIDATION.judged(Verdict(checks, {}))
    assert answer.passed is True
    assert answer.not_judged == ["error over noise is not known: max_over_noise = 1.50 cannot be judged"]


def test_least_stiffness_by_joint_and_for_the_rest() -> None:
    parameters = [compliance(1, 1e-6), compliance(2, 4e-6), compliance(3, None)]
    asked = {"min_stiffness": {"all": 5e5, "A2": 2e5}}
    assert reported(asked, *parameters) == [
        ("min_stiffness", "A1", True), ("min_stiffness", "A2", True), ("min_stiffness", "A3", None),
    ]  # fmt: skip
    assert reported({"min_stiffness": 5e5}, parameters[1]) == [("min_stiffness", "A2", False)]
    # a compliance of zero: no give was seen
    assert reported({"min_stiffness": 5e5}, compliance(1, 0.0)) == [("min_stiffness", "A1", True)]


def test_drift_fails_where_it_is_large_and_sure() -> None:
    before = (compliance(1, 1.0e-6), compliance(2, 1.0e-6), compliance(3, 1.0e-6, 2e-7))
    after = [compliance(1, 1.05e-6), compliance(2, 1.25e-6), compliance(3, 1.25e-6, 2e-7)]
    # A1 has changed surely but little; A2 surely and much; A3 as much, which here is chance: not known well enough
    assert reported({"max_drift": 0.1}, *after, before=before) == [
        ("max_drift", "A1", True), ("max_drift", "A2", False), ("max_drift", "A3", None),
    ]  # fmt: skip
    # without a limit every sure change counts, and chance does not
    assert [held for _, _, held in reported({}, *after, before=before)] == [False, False, True]
    assert [held for _, _, held in reported({"max_drift": {"A2": 0.3}}, *after, before=before)] == [False, True, True]


def test_how_sure_a_drift_is() -> None:
    """Two-sided normal probability of the change, times the number of joints."""
    before, after = compliance(1, 1.0e-6, 3e-8), compliance(1, 1.2e-6, 4e-8)
    baseline = Baseline("before", {before.name: before})
    (check,) = judge(Thresholds(), [after], VALIDATION, JOINTS, baseline)
    p = math.erfc(4.0 / math.sqrt(2.0))  # 0.2e-6 over √(3² + 4²)·1e-8
    assert f"p = {significant(p, 1)}" in check.says
    assert check.value == pytest.approx(1.0 / 1.2 - 1.0)


def test_a_baseline_without_these_joints_judges_none_of_them() -> None:
    other = compliance(1, 1e-6, symbol="other")
    assert {held for _, _, held in reported({}, compliance(1, 1e-6), before=(other,))} == {None}


def test_several_stiffnesses_of_a_joint_are_distinguished() -> None:
    parameters = [compliance(1, 1e-5), compliance(1, 1e-5, symbol="x")]
    assert [where for _, where, _ in reported({"min_stiffness": 5e5}, *parameters)] == [
        "A1 (joint-compliance.j1.c)", "A1 (joint-compliance.j1.x)",
    ]  # fmt: skip

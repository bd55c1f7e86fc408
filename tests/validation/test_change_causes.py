"""Wear and changes of the set-up are distinguished by what each shows in all parameters; doubts are named as such."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from stiffcal.arrays import Floats
from stiffcal.validation.change_causes import USUAL_CHANGE, Hypothesis, cause_of, grew, grown_since, held_to_residuals

VARIANCE = 1e-4 * np.eye(6)
"""1 % on the difference of the means of six relative parameters."""
TURNED = np.array([[0.02, -0.01, 0.03, 0.0, 0.02, -0.02]])
CAUSES = [
    *(Hypothesis(USUAL_CHANGE * np.eye(6)[[k]], joints=(k + 1,)) for k in range(6)),
    Hypothesis(np.full((1, 6), 0.02), effect="wrench-scale"),
    Hypothesis(TURNED, effect="wrench-frame"),
]


@pytest.mark.parametrize(
    ("change", "verdict", "joints", "effect"),
    [
        (0.1 * np.eye(6)[1], "wear", [2], ""),
        (-0.1 * np.eye(6)[1], "stiffened", [2], ""),
        (np.full(6, 0.05), "set-up", [], "wrench-scale"),
        (-3.0 * TURNED[0], "set-up", [], "wrench-frame"),
    ],
)
def test_each_cause_is_named_by_what_it_shows(change: Floats, verdict: str, joints: list[int], effect: str) -> None:
    cause = cause_of(change, VARIANCE, CAUSES, 7, misfit_grew=False)
    assert (cause.verdict, cause.since) == (verdict, 7)
    assert (cause.causes[0].joints, cause.causes[0].effect) == (joints, effect)
    assert cause.causes[0].p_value > 0.05


def test_what_no_cause_shows_is_unexplained() -> None:
    change = np.array([0.1, -0.1, 0.1, -0.1, 0.1, -0.1])
    assert cause_of(change, VARIANCE, CAUSES, 3, misfit_grew=False).verdict == "unexplained"


def test_two_causes_that_show_alike_are_not_decided() -> None:
    alike = [CAUSES[1], Hypothesis(0.02 * np.eye(6)[[1]], effect="tool-compliance")]
    cause = cause_of(0.1 * np.eye(6)[1], VARIANCE, alike, 3, misfit_grew=False)
    assert cause.verdict == "undecided"
    assert len(cause.causes) == 2


def test_joints_alone_are_not_named_where_the_residuals_have_grown() -> None:
    change = 0.1 * np.eye(6)[1]
    assert cause_of(change, VARIANCE, CAUSES, 3, misfit_grew=True).verdict == "unexplained"
    assert cause_of(np.full(6, 0.05), VARIANCE, CAUSES, 3, misfit_grew=True).verdict == "set-up"
    assert grew([1.0, 1.1, 0.9, 1.5, 1.4], 3)
    assert not grew([1.0, 1.1, 0.9, 1.05, 1.0], 3)
    assert not grew([1.0, 1.1, 0.9, 1.5, None], 3)
    # the chart dates a change a campaign too early or too late
    assert [grown_since([1.0, 1.1, 0.9, 1.5, 1.4], k) for k in (1, 2, 3, 4)] == [None, 3, 3, 3]
    assert grown_since([1.0, 1.1, 0.9, 1.05, 1.0], 3) is None


@pytest.mark.parametrize(
    ("set_up", "elsewhere", "verdict", "alike"),
    [
        ({"wrench-frame": 500.0}, {}, "set-up", []),
        ({"wrench-frame": 500.0}, {"bearing-tilt joint 2": 507.0}, "set-up", []),
        # 2 ln 20 = 5.99
        ({"wrench-frame": 500.0}, {"bearing-tilt joint 2": 505.0, "link-beam arm": 490.0}, "undecided", [1, 0]),
        ({"wrench-scale": 500.0}, {}, "unexplained", []),
        ({}, {"bearing-tilt joint 2": 505.0, "link-beam arm": 520.0}, "unexplained", [0]),
        ({}, {}, "unexplained", []),
    ],
)
def test_a_set_up_is_named_only_where_it_explains_the_grown_residuals_better_than_a_law_of_the_robot(
    set_up: dict[str, float], elsewhere: dict[str, float], verdict: str, alike: list[int]
) -> None:
    by_parameters = cause_of(-3.0 * TURNED[0], VARIANCE, CAUSES, 3, misfit_grew=True)
    assert by_parameters.verdict == "set-up"
    judged = held_to_residuals(by_parameters, set_up, elsewhere)
    assert judged.verdict == verdict
    assert judged.explains_residuals == [list(elsewhere)[number] for number in alike]


def test_probabilities_are_those_of_marginal_likelihoods() -> None:
    """Each cause's change is normal about zero, its sizes of three scales as probable: by scipy's densities."""
    change = np.array([0.01, 0.03, 0.015, 0.0, 0.02, -0.01])
    causes = [CAUSES[1], CAUSES[6], CAUSES[7], Hypothesis(USUAL_CHANGE * np.eye(6)[:2], joints=(1, 2))]
    likely = [
        sum(
            float(multivariate_normal.pdf(change, cov=VARIANCE + s**2 * cause.directions.T @ cause.directions))
            for s in (1.0, 3.0, 10.0)
        )
        for cause in causes
    ]
    likely[3] *= 0.1  # a second joint in the same month
    wanted = np.sort(np.array(likely) / np.sum(likely))[::-1]
    found = [cause.probability for cause in cause_of(change, VARIANCE, causes, 3, misfit_grew=False).causes]
    np.testing.assert_allclose(found, wanted[: len(found)], rtol=1e-9)
    assert len(found) >= 2

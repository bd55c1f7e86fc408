"""What moved by more than its interval, of stiffness too that has no upper limit."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stiffcal.identification.answers.before_after import (
    EstimatedParameter,
    estimated_parameters,
    values_before_and_after,
)
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.model.summary import Where
from stiffcal.results.value_words import value_in_model


def estimate(
    value: float | None, low: float | None = None, high: float | None = None, name: str = "joint-compliance.j4.c"
) -> EstimatedParameter:
    interval = None if low is None and high is None else [low, high]
    return EstimatedParameter(
        name=name, effect="joint-compliance", where=Where(joints=[4]), unit="N·m/rad", value=value, interval=interval
    )


@pytest.mark.parametrize(
    ("before", "after", "outside"),
    [
        (estimate(2.7e4, 2.6e4, 2.8e4), estimate(6.0e4, 5.9e4, 6.1e4), True),
        (estimate(2.7e4, 2.6e4, 2.8e4), estimate(2.75e4, 2.7e4, 2.8e4), False),
        (estimate(2.7e4, 2.6e4, 2.8e4), estimate(2.5e4, 2.0e4, 3.0e4), True),
        # Infinite stiffness: only its lower limit is known.
        (estimate(2.7e4, 2.6e4, 2.8e4), estimate(None, 9.0e4, None), True),
        (estimate(2.7e4, 2.6e4, None), estimate(None, 9.0e4, None), False),
        (estimate(2.7e4), estimate(6.0e4, 5.9e4, 6.1e4), True),
        (estimate(2.7e4), estimate(6.0e4), False),
        (estimate(None), estimate(None), False),
    ],
)
def test_moved_is_outside_the_interval_before(
    before: EstimatedParameter, after: EstimatedParameter, outside: bool
) -> None:
    (moved,) = values_before_and_after([before], [after])
    assert moved.outside_interval is outside


def test_new_and_gone_parameters_have_one_side() -> None:
    new, gone = estimate(1.0, 0.9, 1.1, name="backlash.j4.width"), estimate(2.0, 1.9, 2.1, name="two-slope.j4.c")
    both = estimate(2.0, 1.9, 2.1)
    values = values_before_and_after([both, gone], [both, new])
    assert [(value.name, value.before is None, value.after is None) for value in values] == [
        ("joint-compliance.j4.c", False, False),
        ("backlash.j4.width", True, False),
        ("two-slope.j4.c", False, True),
    ]
    assert not any(value.outside_interval for value in values)
    assert values[1].relative is None
    assert values[0].relative == 0.0


@pytest.mark.parametrize("bounded", [(True, False), (False, True), (True, True)])
def test_a_value_at_the_limit_of_its_range_has_no_relative_change(bounded: tuple[bool, bool]) -> None:
    pair = [replace(estimate(2.0, 2.0), at_bound=bounded[0]), replace(estimate(3.0, 2.9, 3.1), at_bound=bounded[1])]
    (moved,) = values_before_and_after(pair[:1], pair[1:])
    assert moved.relative is None


def test_the_limit_of_a_range_is_known_of_an_identified_parameter() -> None:
    width = IdentifiedParameter(
        name="backlash.j4.width", effect="backlash", where=Where(joints=[4]), value=1e-2, std=None,
        interval=[1e-2, None], unit="rad", fixed=False, identifiable=True, at_bound=True,
    )  # fmt: skip
    (parameter,) = estimated_parameters([width])
    assert parameter.at_bound
    (value,) = values_before_and_after([parameter], [parameter])
    assert value.after is not None
    assert value.after.at_bound
    text = value_in_model(value.after, value.quantity.usual)
    assert "±" not in text
    assert text.endswith(", at its limit")


def test_a_compliance_is_compared_as_stiffness() -> None:
    compliance = IdentifiedParameter(
        name="joint-compliance.j4.c", effect="joint-compliance", where=Where(joints=[4]), value=2e-5, std=1e-7,
        interval=[1.98e-5, 2.02e-5], unit="rad/(N·m)", fixed=False, identifiable=True, stiffness=5e4,
        stiffness_std=250.0, stiffness_interval=[4.95e4, 5.05e4],
    )  # fmt: skip
    (parameter,) = estimated_parameters([compliance])
    assert (parameter.unit, parameter.value, parameter.interval) == ("N·m/rad", 5e4, [4.95e4, 5.05e4])
    (value,) = values_before_and_after([parameter], [parameter])
    assert value.after is not None
    assert (value.after.value, value.after.interval) == (5e4, [4.95e4, 5.05e4])

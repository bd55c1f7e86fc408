"""The significance of a parameter's change between two fits."""

from __future__ import annotations

import math

import pytest

from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.model.summary import Where
from stiffcal.validation.change import change_of


def parameter(value: float, std: float, from_geometry: float | None = None) -> IdentifiedParameter:
    return IdentifiedParameter(
        name="joint-compliance.j2.c", effect="joint-compliance", where=Where(joints=[2]), value=value, std=std,
        interval=None, unit="rad/(N·m)", fixed=False, identifiable=True, from_geometry=from_geometry,
    )  # fmt: skip


def test_what_the_geometry_leaves_open_is_the_same_before_and_after() -> None:
    """Of 5 and √(4² / 0.5), 64 % and half of the variances are the geometry's: 3 and 4 remain, 5 together."""
    change = change_of(parameter(100.0, 5.0, 0.64), parameter(110.0, 4.0 * math.sqrt(2.0), 0.5))
    assert change.std == pytest.approx(5.0)
    assert change.p_value == pytest.approx(math.erfc(2.0 / math.sqrt(2.0)))
    assert change.relative == pytest.approx(0.1)


def test_without_a_geometry_all_of_the_uncertainty_counts() -> None:
    assert change_of(parameter(100.0, 3.0), parameter(90.0, 4.0)).std == pytest.approx(5.0)

"""What a fit reports of a parameter."""

from __future__ import annotations

import pytest
from scipy.special import stdtrit

from stiffcal.estimation.parameters import MANY_DEGREES, student_95


@pytest.mark.parametrize("dof", [1, 30, MANY_DEGREES, MANY_DEGREES + 1, 10**6])
def test_quantiles_of_student_are_right_to_the_last_digits(dof: int) -> None:
    assert student_95(dof) == pytest.approx(float(stdtrit(dof, 0.975)), rel=1e-11)

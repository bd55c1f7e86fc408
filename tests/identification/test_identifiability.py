"""Combinations that the data determine where the parameters alone are not known."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.identification.identifiability import check_identifiability
from stiffcal.identification.least_squares import triangular


@pytest.mark.parametrize("ratio", [0.25, -0.25])
def test_the_combination_of_two_proportional_regressors_is_the_one_that_they_share(ratio: float) -> None:
    """a x₁ + r a x₂ = a (x₁ + r x₂): the data know the sum in the parameters' own units."""
    rng = np.random.default_rng(2)
    shared, other = rng.normal(size=(2, 40))
    rows = np.column_stack([shared, ratio * shared, other])
    found = check_identifiability(triangular(rows), ("a", "b", "c"), np.full(3, np.inf))
    assert found.identifiable.tolist() == [False, False, True]
    (ambiguity,) = found.ambiguities
    assert ambiguity.names == ("a", "b")
    assert ambiguity.coefficients == pytest.approx((1.0, ratio), rel=1e-9)

"""Combinations that the data determine where the parameters alone are not known."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.estimation.identifiability import check_identifiability
from stiffcal.estimation.triangular import triangular
from stiffcal.estimation.unknowns import Unknowns


@pytest.mark.parametrize("ratio", [0.25, -0.25])
def test_the_combination_of_two_proportional_regressors_is_the_one_that_they_share(ratio: float) -> None:
    """a x₁ + r a x₂ = a (x₁ + r x₂): the data know the sum in the parameters' own units."""
    rng = np.random.default_rng(2)
    shared, other = rng.normal(size=(2, 40))
    rows = np.column_stack([shared, ratio * shared, other])
    found = check_identifiability(triangular(rows), Unknowns.plain(("a", "b", "c")))
    assert found.identifiable.tolist() == [False, False, True]
    (ambiguity,) = found.ambiguities
    assert ambiguity.names == ("a", "b")
    assert ambiguity.coefficients == pytest.approx((1.0, ratio), rel=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_what_is_held_does_not_depend_on_the_order_of_the_entries(seed: int) -> None:
    """Two dependent sets that share a parameter: either could be held for both."""
    rng = np.random.default_rng(seed)
    first, second, third, other = rng.normal(size=(4, 60))
    columns = {
        "joint-compliance.j2.c": first, "bearing-tilt.j2.x": second, "bearing-tilt.j10.x": first - second,
        "link-beam.swing.EI2": third, "link-springs.swing.c": second + 2.0 * third, "backlash.j4.width": other,
    }  # fmt: skip
    held = set()
    for _ in range(6):
        names = tuple(np.array(list(columns))[rng.permutation(6)].tolist())
        factor = triangular(np.column_stack([columns[name] for name in names]))
        found = check_identifiability(factor, Unknowns.plain(names))
        held.add(frozenset(name for name, out in zip(names, found.left_at_neutral, strict=True) if out))
    assert held == {frozenset({"bearing-tilt.j10.x", "link-springs.swing.c"})}

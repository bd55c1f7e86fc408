"""Least squares within bounds, against scipy's non-negative one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from stiffcal.bounded_least_squares import least_squares_within


@pytest.mark.parametrize("seed", range(200))
def test_as_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = int(rng.integers(1, 20)), int(rng.integers(1, 9))
    design, wanted = rng.standard_normal((m, n)), rng.standard_normal(m)
    if seed % 3 == 0 and n > 1:  # two columns of one direction, nearly
        design[:, 1] = design[:, 0] * (1.0 + 1e-9 * rng.standard_normal())
    if seed % 5 == 0:
        design[:, -1] = 0.0
    if seed % 7 == 0:
        wanted = -np.abs(design).sum(axis=1)
    expected, left = nnls(design, wanted)
    found, _ = least_squares_within(design, wanted, np.zeros(n), np.full(n, np.inf))
    remains = float(np.linalg.norm(design @ found - wanted))
    assert (found >= 0.0).all()
    assert remains == pytest.approx(left, abs=1e-10)
    if m >= n and np.linalg.cond(design) < 1e6:
        np.testing.assert_allclose(found, expected, atol=1e-8)


def test_nothing_to_find() -> None:
    none = np.zeros(0)
    assert least_squares_within(np.zeros((3, 0)), np.ones(3), none, none)[0].shape == (0,)
    found, at_bound = least_squares_within(np.eye(2), np.zeros(2), np.zeros(2), np.full(2, np.inf))
    assert (found == 0.0).all()
    assert not at_bound.any()

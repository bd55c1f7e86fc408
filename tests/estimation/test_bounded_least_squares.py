"""Least squares within bounds, against scipy's non-negative one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear, nnls

from stiffcal.errors import InputError
from stiffcal.estimation.bounded_least_squares import least_squares_within


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


@pytest.mark.parametrize("seed", [6735, 7464, 7610, 10604, 11186, 12209, 12697])
def test_columns_alike_to_rounding_are_not_exchanged_without_end(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(3, 25)), int(rng.integers(3, 30))
    rank = int(rng.integers(1, min(n, m) + 1))
    design = rng.standard_normal((m, rank)) @ rng.standard_normal((rank, n))
    design += 10.0 ** -rng.uniform(9, 17) * rng.standard_normal((m, n))
    if rng.random() < 0.5:
        design = design * 10.0 ** rng.uniform(-6, 6, n)
    if rng.random() < 0.3:
        design = np.linalg.qr(design)[1]
    wanted = rng.standard_normal(len(design))
    if rng.random() < 0.5:
        wanted = design @ np.maximum(rng.standard_normal(n), 0.0)
    most = rng.random(n) * 10.0 ** rng.uniform(-8, 8, n) if rng.random() < 0.5 else np.full(n, np.inf)
    found, _ = least_squares_within(design, wanted, np.zeros(n), most)
    assert ((found >= 0.0) & (found <= most)).all()
    # where the sum of squares could still fall, it is by directions that the data see as good as not
    pull = (design / np.linalg.norm(design, axis=0)).T @ (wanted - design @ found)
    left = np.where(found <= 0.0, pull, np.where(found >= most, -pull, np.abs(pull)))
    assert left.max() < 1e-3 * np.linalg.norm(wanted)


def test_numbers_whose_squares_no_computer_holds_are_one_line() -> None:
    with pytest.raises(InputError, match="overflow"):
        least_squares_within(np.full((3, 2), 1e200), np.ones(3), np.zeros(2), np.ones(2))


@pytest.mark.parametrize("seed", range(30))
def test_independent_columns_are_solved_from_the_minimum_without_bounds(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of scipy's solver the same minimum, in a few solves: of 27 unknowns at their bounds each took one before."""
    rng = np.random.default_rng(seed)
    design, wanted = rng.standard_normal((60, 27)), rng.standard_normal(60)
    lower, upper = np.where(rng.random(27) < 0.7, 0.0, -np.inf), np.where(rng.random(27) < 0.3, 0.05, np.inf)
    expected = lsq_linear(design, wanted, (lower, upper), method="bvls", tol=1e-14).x
    solve, solved = np.linalg.lstsq, []

    def counted(*arguments: Any, **options: Any) -> Any:
        solved.append(1)
        return solve(*arguments, **options)

    monkeypatch.setattr(np.linalg, "lstsq", counted)
    found, at_bound = least_squares_within(design, wanted, lower, upper, independent=True)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert ((found == lower) | (found == upper)).tolist() == at_bound.tolist()
    assert len(solved) <= 15

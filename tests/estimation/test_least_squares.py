"""The blockwise solver against plain least squares on the whole matrix."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.estimation.triangular import Reduced, TriangularFactor, triangular
from stiffcal.identification.derivatives.observation import Evaluation, Observations, observe
from stiffcal.identification.fitting.least_squares import reduce_blocks
from stiffcal.identification.noise.reading_noise import Noise, Whitening, covariance, whiten
from tests.laboratory.simulated_states import medium_robot, played


def blocks_of(data: Observations, columns: np.ndarray, size: int) -> list[Evaluation]:
    """Cut columns into blocks between runs of ``size`` states."""
    predicted = np.zeros_like(data.measured)
    starts = range(0, data.n_states, size)
    return [
        Evaluation(slice(i, i + size), predicted[:, i : i + size], columns[:, :, i : i + size], None) for i in starts
    ]


@pytest.mark.parametrize("correlated", [False, True])
def test_blocks_and_eliminated_offsets_equal_the_whole_problem(correlated: bool) -> None:
    """Same minimum, same sum of squares, same degrees of freedom as generalised least squares with offset columns."""
    rng = np.random.default_rng(2)
    data = observe(played(medium_robot(), runs=3), medium_robot().chain)
    m, n = data.measured.shape
    per_run = n // 3
    columns = rng.normal(size=(4, m, n))
    noise = Noise(1e-5, 3e-5, 0.7 if correlated else 0.0, 0.2 if correlated else 0.0, "manifest", np.inf)
    sensitivity = rng.normal(size=(m, 6, n)) * 1e-5
    whitening = whiten(noise, data, sensitivity)
    reduced = reduce_blocks(blocks_of(data, columns, per_run), data, whitening)

    sigma = covariance(noise, data, sensitivity if correlated else None)
    rows, right = [], []
    for i in range(n):
        whitener = np.linalg.inv(np.linalg.cholesky(sigma[:, :, i]))
        offsets = np.zeros((m, 3 * m))
        offsets[:, m * data.run[i] : m * (data.run[i] + 1)] = np.eye(m)
        rows.append(whitener @ np.hstack([columns[:, :, i].T, offsets]))
        right.append(whitener @ data.measured[:, i])
    matrix, target = np.vstack(rows), np.concatenate(right)
    solution, squares, *_ = np.linalg.lstsq(matrix, target, rcond=None)
    assert np.allclose(reduced.solve(), solution[:4], rtol=1e-9, atol=1e-12 * np.max(np.abs(solution[:4])))
    assert reduced.cost(reduced.solve()) == pytest.approx(float(squares[0]), rel=1e-9)
    assert reduced.dof == m * n - 3 * m


def test_unmeasured_components_carry_no_weight() -> None:
    """A masked component neither pulls nor counts."""
    data = observe(played(medium_robot(), runs=2), medium_robot().chain)
    measured_mask = data.measured_mask.copy()
    measured_mask[1, ::3] = False
    whitening: Whitening = whiten(
        Noise(1e-5, 1e-5, 1.0, 1.0, "manifest", np.inf), _masked(data, measured_mask), _lever(data)
    )
    assert whitening.lower is not None
    assert not whitening.lower[1, :, ::3].any()
    assert not whitening.lower[:, 1, ::3].any()


def _masked(data: Observations, measured_mask: np.ndarray) -> Observations:
    from dataclasses import replace

    return replace(data, measured_mask=measured_mask)


def _lever(data: Observations) -> np.ndarray:
    return np.full((len(data.measured), 6, data.n_states), 1e-6)


def test_bounds_hold() -> None:
    """The bounded minimum is the best point inside the bounds."""
    reduced = Reduced(np.array([[1.0, 0.8], [0.0, 0.6]]), np.array([0.2, -0.9]), 0.0, 2)
    solution, active = reduced.solve_bounded(np.zeros(2), np.full(2, np.inf))
    assert active.tolist() == [False, True]
    assert solution[1] == 0.0
    grid = np.linspace(0.0, 1.0, 101)
    assert reduced.cost(solution) <= min(reduced.cost(np.array([x, y])) for x in grid for y in grid) + 1e-9


@pytest.mark.parametrize("seed", range(20))
def test_no_better_point_within_bounds(seed: int) -> None:
    """What pulls at the minimum is zero inside, and outwards at a bound; also where columns are sums of others."""
    rng = np.random.default_rng(seed)
    p = int(rng.integers(2, 15))
    matrix = rng.normal(size=(30, p))
    matrix[:, 1] = 2.0 * matrix[:, 0] if seed % 3 == 0 else matrix[:, 1]
    factor = triangular(np.column_stack([matrix, 3.0 * rng.normal(size=30)]))
    lower = np.where(rng.random(p) < 0.3, -np.inf, -0.3 * rng.random(p))
    upper = np.where(rng.random(p) < 0.5, np.inf, 0.3 * rng.random(p))
    found, at_bound = Reduced(factor[:p, :p], factor[:p, p], 0.0, 0).solve_bounded(lower, upper)
    assert np.all((lower <= found) & (found <= upper))
    pull = factor[:p, :p].T @ (factor[:p, p] - factor[:p, :p] @ found)
    assert np.abs(pull[~at_bound]).max(initial=0.0) < 1e-11
    assert np.all(pull[found <= lower] < 1e-11)
    assert np.all(pull[found >= upper] > -1e-11)


@pytest.mark.parametrize("close", [0.0, 1e-7, 1.0])
@pytest.mark.parametrize("scale", [1.0, 1e5])
def test_factor_of_many_blocks_is_that_of_the_whole(close: float, scale: float) -> None:
    """Also with columns that are sums of others, to rounding or nearly, and with later rows of another size."""
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(7, 4000)) * np.logspace(-6, 3, 7)[:, None]
    rows[3] = rows[1] - 1e3 * rows[0] + close * rows[3]
    rows[:, 2000:] *= scale
    blocks = TriangularFactor()
    for start in range(0, 4000, 250):
        blocks.add(rows[:, start : start + 250])
    found, whole = blocks.whole(), triangular(rows.T)
    length = np.linalg.norm(whole, axis=0)
    unit, wanted = found / length, whole / length
    np.testing.assert_allclose(unit.T @ unit, wanted.T @ wanted, rtol=0, atol=1e-13)
    if close:
        np.testing.assert_allclose(np.abs(np.diagonal(unit)), np.abs(np.diagonal(wanted)), rtol=1e-7)

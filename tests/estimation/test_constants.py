"""Free constants taken out: what generalised least squares with a column for each constant leaves."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.estimation.constants import StretchConstants, orthonormal, stretches, without_constants

RUNS = np.repeat([0, 1, 2, 3], [4, 1, 4, 6])
CARRY = np.array([True, True, False, True])


def drawn(correlated: bool) -> tuple[StretchConstants, Floats, Floats]:
    """Return constants, (k, m, n) readings and (m, m, n) factors; the second component of the last run was not read."""
    rng = np.random.default_rng(7)
    m, n = 3, len(RUNS)
    scale = rng.uniform(0.5, 2.0, (m, n))
    scale[1, RUNS == 3] = 0.0
    lower = np.zeros((m, m, n))
    lower[range(m), range(m)] = scale
    if correlated:
        lower[2, 0], lower[1, 0] = rng.normal(size=n), rng.normal(size=n) * (RUNS != 3)
    stack = rng.normal(size=(2, m, n)) * (scale > 0.0)
    return StretchConstants(stretches(RUNS), CARRY, scale, lower if correlated else None), stack, lower


def white(lower: Floats, stack: Floats) -> Floats:
    return np.asarray(np.einsum("abn,...bn->...an", lower, stack))


def columns(lower: Floats) -> Floats:
    """Return (R m, m, n) whitened columns of the constants of the runs that carry some."""
    m, n = lower.shape[1:]
    made = [np.where(run == RUNS, np.eye(m)[c][:, None], 0.0) for run in np.flatnonzero(CARRY) for c in range(m)]
    return white(lower, np.array(made)).reshape(-1, m * n)


@pytest.mark.parametrize("correlated", [False, True])
def test_rows_and_readings_without_constants(correlated: bool) -> None:
    constants, stack, lower = drawn(correlated)
    of_constants = columns(lower)
    flat = white(lower, stack).reshape(len(stack), -1)
    # judge: numpy's least squares with one column per constant
    found, *_ = np.linalg.lstsq(of_constants.T, flat.T, rcond=None)
    expected = flat - found.T @ of_constants
    np.testing.assert_allclose(constants.rows(white(lower, stack)).reshape(len(stack), -1), expected, atol=1e-13)
    centred = constants.centred(stack, white(lower, stack))
    np.testing.assert_allclose(white(lower, centred).reshape(len(stack), -1), expected, atol=1e-13)
    assert np.array_equal(centred[:, :, RUNS == 2], stack[:, :, RUNS == 2])
    assert constants.n_free == np.linalg.matrix_rank(of_constants) == 3 * 3 - 1


def test_a_constant_that_no_row_shows() -> None:
    unit = np.array([[1.0, 0.0], [1.0, 0.0]])
    basis, constants = orthonormal(unit)
    np.testing.assert_allclose(unit @ constants, basis)
    np.testing.assert_allclose(without_constants(np.array([[1.0, 3.0]]), unit), [[-1.0, 1.0]], atol=1e-15)
    assert not without_constants(np.zeros((1, 2)), np.zeros((2, 1))).any()

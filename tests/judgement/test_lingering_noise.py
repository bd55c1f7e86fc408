"""Noise that lingers: its covariance is that of a first-order process, and it costs nothing where noise is white."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.fft import dct
from scipy.linalg import toeplitz
from scipy.stats import multivariate_normal

from stiffcal.arrays import Floats
from stiffcal.judgement.discrepancy import Discrepancy
from stiffcal.judgement.ground_of_rows import RowData, WeightedRows
from stiffcal.judgement.lingering_noise import LingeringNoise
from stiffcal.judgement.numbers import LINGERS

N = 60


def of_one_joint(order: np.ndarray | None = None) -> LingeringNoise:
    """Return noise of so many readings of one joint, in an order."""
    space = WeightedRows(RowData(np.zeros(N, dtype=np.int64)), np.ones(N))
    return LingeringNoise.of(space, np.zeros(N, dtype=np.int64), np.arange(N) if order is None else order)


def log_density(noise: LingeringNoise, left: float, rows: Floats) -> float:
    """Return the log density of readings (r,) of unit variance, but for what all densities have."""
    inverse = noise.taken_out(rows[None], noise.weights(left))[0]
    return float(-0.5 * noise.log_determinant(left) - 0.5 * rows @ inverse)


@pytest.mark.parametrize("number", range(len(LINGERS)))
def test_the_inverse_is_that_of_the_covariance_along_cosines(number: int) -> None:
    """A reading alone in its run, the last, scatters as any other."""
    group = np.repeat([0, 1, 2], [20, 39, 1])
    space = WeightedRows(RowData(group), np.ones(N))
    noise, left, unit = LingeringNoise.of(space, group, np.arange(N)), LINGERS[number], np.eye(N)
    covariance = np.eye(N)
    for own in (slice(0, 20), slice(20, 59)):
        n = own.stop - own.start
        waves = dct(np.eye(n), norm="ortho", axis=0)
        variance = (1.0 - left**2) / (1.0 + left**2 - 2.0 * left * np.cos(np.pi * np.arange(n) / n))
        covariance[own, own] = (waves.T * variance) @ waves
    weights = noise.weights(left)
    inverse = noise.taken_out(unit, weights)
    assert inverse @ covariance == pytest.approx(np.eye(N), abs=1e-9)
    assert np.linalg.slogdet(inverse)[1] == pytest.approx(-noise.log_determinant(left))
    assert noise.leverage(weights) == pytest.approx(1.0 - np.diag(inverse))
    along = noise.along(unit)
    assert noise.products(unit, along, unit, along, unit)[number] == pytest.approx(np.eye(N) - inverse)


def test_next_to_what_lasts_in_runs_the_covariance_is_that_of_both() -> None:
    """V = (1 + Z Zᵀ)^½ N (1 + Z Zᵀ)^½, N of the noise that lingers, Z of what lasts."""
    rng = np.random.default_rng(3)
    group = np.arange(N) // 20
    space = WeightedRows(RowData(group), np.ones(N))
    lasting = Discrepancy.of_lasting(space, rng.normal(size=(2, 1, N)), group)
    noise = LingeringNoise.of(space, group, np.arange(N), lasting)
    weights, constant = noise.weights(0.6), lasting.weights(1.0)
    alone = LingeringNoise.of(space, group, np.arange(N))
    of_noise = np.linalg.inv(alone.taken_out(np.eye(N), weights))
    values, axes = np.linalg.eigh(np.linalg.inv(lasting.taken_out(np.eye(N), constant)))
    root = (axes * np.sqrt(values)) @ axes.T
    inverse = noise.taken_out(np.eye(N), weights, lasting.taken_out(np.eye(N), constant))
    assert inverse == pytest.approx(np.linalg.inv(root @ of_noise @ root), abs=1e-9)
    assert noise.leverage(weights) + lasting.leverage(constant) == pytest.approx(1.0 - np.diag(inverse))


@pytest.mark.parametrize("left", LINGERS)
def test_readings_are_as_probable_as_of_a_first_order_process(left: float) -> None:
    """But for a run's ends: over 200 runs the log density is that of the process to a nat, and the right share wins."""
    rng = np.random.default_rng(7)
    exact = toeplitz(left ** np.arange(N))
    noise, process = of_one_joint(), multivariate_normal(np.zeros(N), exact)
    drawn = process.rvs(200, random_state=rng)
    own = np.array([log_density(noise, left, one) for one in drawn])
    right = process.logpdf(drawn) + 0.5 * N * np.log(2.0 * np.pi)
    assert np.mean(own - right) == pytest.approx(0.0, abs=1.0)
    others = [np.mean([log_density(noise, each, one) for one in drawn]) for each in LINGERS]
    assert LINGERS[int(np.argmax(others))] == left


def test_readings_follow_each_other_in_the_order_in_which_they_were_taken() -> None:
    rng = np.random.default_rng(5)
    order = rng.permutation(N)
    rows = rng.normal(size=N)
    shuffled = np.empty(N)
    shuffled[order] = rows
    assert log_density(of_one_joint(order), 0.5, shuffled) == pytest.approx(log_density(of_one_joint(), 0.5, rows))


def test_what_a_constant_has_taken_out_is_in_no_direction() -> None:
    class Centred(WeightedRows):
        """Rows whose mean a constant takes out."""

        @property
        def free(self) -> Floats:
            return np.full((1, N), 1.0 - 1.0 / N)

    noise = LingeringNoise.of(
        Centred(RowData(np.zeros(N, dtype=np.int64)), np.ones(N)), np.zeros(N, dtype=np.int64), np.arange(N)
    )
    assert len(noise.cosine) == N - 1
    assert len(of_one_joint().cosine) == N

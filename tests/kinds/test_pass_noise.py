"""The noise of torque readings from neighbouring samples of a pass."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.kinds.friction.fitting.pass_noise import pass_noise

PASSES, SAMPLES = 40, 112


def noisy(correlation: float, seed: int = 1) -> Floats:
    """Return (PASSES · SAMPLES,) noise of unit variance, neighbours correlated."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=(PASSES, SAMPLES))
    for k in range(1, SAMPLES):
        noise[:, k] = correlation * noise[:, k - 1] + np.sqrt(1.0 - correlation**2) * noise[:, k]
    return noise.ravel()


READING = np.repeat(np.arange(PASSES), SAMPLES)
LEVEL = READING // 4
ONE = np.ones(PASSES * SAMPLES)


def test_white_noise() -> None:
    # 40 · 9 windows with 8 degrees of freedom each: 1.3 % standard error
    noise = pass_noise(3.0 * noisy(0.0), READING, LEVEL, ONE)
    assert noise is not None
    assert noise.correlation == 0.0
    np.testing.assert_allclose(noise.sigma, 3.0, rtol=0.05)
    np.testing.assert_allclose(noise.of_mean(np.array([1, 4, 100])), [1.0, 0.5, 0.1])


def test_what_changes_slowly_within_and_between_passes_is_no_noise() -> None:
    slow = 20.0 * np.sin(np.arange(PASSES * SAMPLES) / 40.0) + 50.0 * np.repeat(np.sin(np.arange(PASSES)), SAMPLES)
    noise = pass_noise(noisy(0.0) + slow, READING, LEVEL, ONE)
    assert noise is not None
    np.testing.assert_allclose(noise.sigma, 1.0, rtol=0.05)


@pytest.mark.parametrize("correlation", [0.3, 0.5])
def test_correlated_noise_makes_means_less_certain(correlation: float) -> None:
    found = [pass_noise(noisy(correlation, seed), READING, LEVEL, ONE) for seed in range(10)]
    scale = [noise.sigma[0] * noise.of_mean(np.array([9]))[0] for noise in found if noise is not None]
    truth = np.std([noisy(correlation, seed)[:SAMPLES][:108].reshape(-1, 9).mean(axis=1) for seed in range(400)])
    assert len(scale) == 10
    assert float(np.mean(scale)) == pytest.approx(float(truth), rel=0.15)


def test_means_of_many_samples_and_of_few_share_one_noise() -> None:
    weight = np.where(LEVEL < 5, 9.0, 1.0)
    noise = pass_noise(noisy(0.0) / np.sqrt(weight), READING, LEVEL, weight)
    assert noise is not None
    np.testing.assert_allclose(noise.sigma * np.sqrt(weight), 1.0, rtol=0.05)


def test_speeds_have_noise_of_their_own_where_they_differ() -> None:
    noise = pass_noise(noisy(0.0) * np.where(LEVEL < 5, 1.0, 2.0), READING, LEVEL, ONE)
    assert noise is not None
    np.testing.assert_allclose(noise.sigma[LEVEL < 5], 1.0, rtol=0.25)
    np.testing.assert_allclose(noise.sigma[LEVEL >= 5], 2.0, rtol=0.25)


def test_copies_and_short_passes_show_no_noise() -> None:
    assert pass_noise(np.ones(96), np.repeat(np.arange(8), 12), np.zeros(96, dtype=np.int64), np.ones(96)) is None
    assert pass_noise(noisy(0.0)[:40], np.repeat(np.arange(8), 5), np.zeros(40, dtype=np.int64), np.ones(40)) is None

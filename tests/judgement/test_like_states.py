"""Like states of a sweep scatter by the noise alone: what a model leaves that is smooth has no part in it."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.judgement.like_states import Sweep, _passed, _places, _shrunk
from stiffcal.judgement.numbers import WORTH_OF_NEIGHBOURS

CYCLES, STATES, NOISE = 6, 600, 4e-6


def sweep() -> Sweep:
    """Return a run of cycles, each to and fro by 3 mrad."""
    angle = 3e-3 * np.sin(np.linspace(0.0, 2.0 * np.pi * CYCLES, STATES))
    angle = angle + NOISE * np.random.default_rng(5).standard_normal(STATES)
    passed = _passed(angle)
    return Sweep(0, 0, np.arange(STATES), passed, angle, _places(passed, STATES))


@pytest.mark.parametrize("left", [0.0, 0.1, -0.3])
def test_what_a_model_leaves_has_no_part_in_the_noise(left: float) -> None:
    """A play of which a share is left, a hundred noises: the noise is known to its own standard error, 6 %."""
    run = sweep()
    rng = np.random.default_rng(6)
    residual = left * 2e-3 * np.tanh(run.angle / 5e-4) + NOISE * rng.standard_normal(STATES)
    square = float(np.mean(run.scatter(residual, np.full(STATES, NOISE**2))))
    # a mean of so many squares, of which two are worth one, is known to 8 % (three standard errors: 25 %)
    assert square == pytest.approx(1.0, rel=0.25)


def test_places_hold_each_state_once_in_its_own_sense() -> None:
    run = sweep()
    assert np.all(run.places.sum(axis=0) == 1.0)
    forward = np.zeros(STATES)
    forward[run.passed[0]] = 1.0
    share = (run.places @ forward) / run.places.sum(axis=1)
    assert set(share.tolist()) == {0.0, 1.0}
    # as many states as there are cycles, one more or less
    assert np.all(np.abs(run.places.sum(axis=1) - CYCLES) <= 1.0)


def variances(spread: float, seed: int = 8) -> Floats:
    """Return logarithms of mean squares of eight runs whose noise differs by chance, and by a factor besides."""
    rng = np.random.default_rng(seed)
    chance = np.log(rng.chisquare(WORTH_OF_NEIGHBOURS * 300, size=8) / (WORTH_OF_NEIGHBOURS * 300))
    return np.asarray(chance + spread * np.linspace(-1.0, 1.0, 8))


def test_runs_that_differ_by_chance_have_one_noise() -> None:
    """Where chance alone makes them differ by more than expected some is left: a tenth of the scatter, of all."""
    every = [variances(0.0, seed) for seed in range(200)]
    left = sum(float(np.var(_shrunk(logs, np.full(8, 300)))) for logs in every)
    assert left < 0.2 * sum(float(np.var(logs)) for logs in every)


def test_a_run_that_is_quieter_keeps_its_own_noise() -> None:
    wide = variances(1.5)
    np.testing.assert_allclose(_shrunk(wide, np.full(8, 300)), wide, atol=0.05)

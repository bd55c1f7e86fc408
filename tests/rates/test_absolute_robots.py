"""Drawn campaigns of absolute places are what their class says."""

from __future__ import annotations

import numpy as np
import pytest

from tests.rates.absolute_robots import NOISE, draw_absolute, oracle_of
from tests.rates.scoring import judge_campaign
from tests.rates.workers import Job, one_campaign

WANDERING = Job(20261133, "absolute outside", 42, "balance", "", ())
"""A campaign of `make rates SEED=20261133` in which the target wanders."""


def test_draws_differ_by_seed_and_repeat() -> None:
    first, again, other = (draw_absolute("absolute 1x", np.random.default_rng(seed), 1) for seed in (5, 5, 6))
    np.testing.assert_array_equal(first.states.position, again.states.position)
    assert np.abs(first.states.position - other.states.position).max() > 0.1


@pytest.mark.parametrize("number", [0, 1, 2, 3])
def test_the_true_effects_leave_the_noise(number: int) -> None:
    """The finite balance that made the readings and the fit agree: 200 to 500 readings, 4 standard deviations."""
    fit = oracle_of(draw_absolute("absolute 3x", np.random.default_rng([7, number]), number))
    assert fit.last_step is None
    assert fit.reduced_chi2 == pytest.approx(1.0, abs=0.4)


def test_without_the_hidden_effect_more_than_noise_is_left() -> None:
    campaign = draw_absolute("absolute 3x", np.random.default_rng([7, 1]), 1)
    assert campaign.noise == NOISE
    verdict = judge_campaign(campaign)
    # three times the noise, and the noise
    assert verdict.before == pytest.approx(np.sqrt(10.0), rel=0.5)
    assert verdict.outcome == "right"


@pytest.mark.practice
def test_what_is_left_next_to_a_wrong_effect_is_no_noise() -> None:
    """A target that wanders looks like a drift in part; the rest, twice the noise, follows nothing."""
    verdict = one_campaign(WANDERING)
    assert "wander" in verdict.hidden
    assert verdict.unexplained
    assert not verdict.firm_wrong

"""Tails of the noise: the evidence against an integral by brute force, and what squares are worth next to them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import norm
from scipy.stats import t as student

from stiffcal.arrays import Floats
from stiffcal.judgement.discrepancy import Discrepancy
from stiffcal.judgement.evidence import MemberColumns, SetEvidence
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import NO_DISCREPANCY, NORMAL, TAILS
from stiffcal.judgement.reading import read_off
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.states import judge_states
from stiffcal.judgement.tails import Readings, log_gains, tails_of
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.calibration.stress.classes import draw_stress

N, SIZE = 40, 2.0
NO_POSES = Discrepancy((), N, (), np.zeros(0))


def drawn(dof: float, count: int, seed: int) -> Floats:
    """Return noise of unit variance."""
    rng = np.random.default_rng(seed)
    if np.isinf(dof):
        return rng.normal(size=count)
    return np.asarray(rng.standard_t(dof, size=count) * np.sqrt(1.0 - 2.0 / dof))


def by_brute_force(y: Floats, column: Floats | None) -> float:
    """Return the log density of y, the coefficient of a column of known size integrated."""
    grid = np.linspace(-6.0, 6.0, 4001)
    left = y[None] if column is None else y - grid[:, None] * column
    before = 0.0 if column is None else norm(0.0, SIZE).logpdf(grid) + np.log(grid[1] - grid[0])
    each = [np.log(NORMAL) + logsumexp(norm.logpdf(left).sum(axis=1) + before)]
    for dof in TAILS:
        scale = np.sqrt(1.0 - 2.0 / dof)
        share = np.log((1.0 - NORMAL) / len(TAILS))
        each.append(share + logsumexp(student(dof, scale=scale).logpdf(left).sum(axis=1) + before))
    return float(logsumexp(each))


@pytest.mark.parametrize("dof", [np.inf, 5.0, 3.0])
@pytest.mark.parametrize("size", [0.0, 0.4, 1.5])
def test_odds_are_those_of_brute_force(dof: float, size: float) -> None:
    """Normal noise alone is wrong by nats where a reading is far off."""
    for seed in range(8):
        column = np.random.default_rng(seed).normal(size=N)
        y = drawn(dof, N, 100 + seed) + size * column
        member = MemberColumns(column[None], np.zeros(1, dtype=np.bool_), np.array([SIZE]), np.ones(1))
        shared = Shared(np.zeros((0, N)), np.zeros((0, 1)), [(NO_POSES, 1.0 - NO_DISCREPANCY)])
        evidence = SetEvidence.of(
            Readings(shared, y, np.ones(N), np.zeros(N, dtype=np.int64)), [member], NoiseScale(float(N), np.inf)
        )
        expected = by_brute_force(y, column) - by_brute_force(y, None)
        assert evidence.of_set([0]) - evidence.of_set([]) == pytest.approx(expected, abs=0.15)


@pytest.mark.parametrize("dof", [np.inf, 10.0, 3.0])
def test_a_weighted_square_is_as_large_as_the_variance_and_varies_as_stated(dof: float) -> None:
    noise = 3.0 * drawn(dof, 40_000, 7)
    found = tails_of(noise, np.ones(len(noise)), np.zeros(len(noise), dtype=np.int64), 0.0)
    tail = max(found, key=lambda one: found[one])
    assert tail.dof == dof
    square = noise**2 * tail.weights(noise**2, np.zeros(len(noise), dtype=np.int64)) / tail.variance[0]
    assert square.mean() == pytest.approx(1.0, abs=1e-3)
    assert square.var() == pytest.approx(2.0 / tail.worth, rel=0.05)
    assert tail.variance[0] == pytest.approx(9.0, rel=0.05)


def test_kinds_of_readings_have_scales_of_their_own() -> None:
    """Translations of half the noise that is stated and rotations of twice that are no tails."""
    kind = np.repeat([0, 1], 3000)
    noise = np.where(kind == 0, 0.5, 2.0) * drawn(np.inf, 6000, 3)
    found = tails_of(noise, np.ones(6000), kind, 0.0)
    tail = max(found, key=lambda one: found[one])
    assert np.isinf(tail.dof)
    assert tail.variance[0] == pytest.approx(0.25, rel=0.1)
    assert tail.variance[1] == pytest.approx(4.0, rel=0.1)
    assert log_gains(noise[None], np.ones((1, 6000)), kind, 0.0)[0] > 1000.0


@pytest.mark.long
@pytest.mark.parametrize("number", [16, 18])
def test_a_far_reading_of_noise_with_tails_is_no_step(number: int) -> None:
    """Runs of three states, nothing hidden: next to normal noise a step in time was certain."""
    campaign = draw_stress("broken-heavy-tails", 2, number)
    found = read_off(judge_states(campaign.states, campaign.model, built_in_effects()))
    assert campaign.hidden == ()
    assert found.groups == ()
    assert all(off.state is not None for off, _ in found.doubted)
    assert not found.unexplained

"""The evidence of sets against integrals by brute force, and what must not change it."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from stiffcal.arrays import Floats
from stiffcal.judgement.discrepancy import AlikeRuns, Discrepancy
from stiffcal.judgement.evidence import MemberColumns, SetEvidence
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import DISCREPANCIES, NO_DISCREPANCY, WAVES
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.tails import Readings

N, RUNS = 24, 4
EXACTLY = NoiseScale(float(N - 2), np.inf)


def of_poses(rng: np.random.Generator) -> Discrepancy:
    """Return a discrepancy of four poses with two directions each."""
    bases, _ = np.linalg.qr(rng.normal(size=(RUNS, N // RUNS, 2)))
    alike = AlikeRuns(np.arange(RUNS), np.arange(N).reshape(RUNS, -1), bases, np.arange(2 * RUNS).reshape(RUNS, 2))
    return Discrepancy(tuple(range(RUNS)), N, [alike], rng.uniform(0.5, 2.0, 2 * RUNS))


def member(rng: np.random.Generator, count: int, bounded: bool = False) -> MemberColumns:
    sizes = np.array([0.5, 2.0])
    alone = 0.4 if count == 3 else 0.0
    return MemberColumns(rng.normal(size=(count, N)), np.full(count, bounded), sizes, np.array([0.3, 0.7]), alone)


def kinds(discrepancy: Discrepancy) -> list[tuple[Discrepancy, float]]:
    """Return it as the only kind."""
    return [(discrepancy, 1.0 - NO_DISCREPANCY)]


def read(common: Floats, discrepancy: Discrepancy, y: Floats) -> Readings:
    """Return readings of one kind, none of which runs' constants take a part of."""
    shared = Shared(common, np.zeros((0, len(common) + 1)), kinds(discrepancy))
    return Readings(shared, y, np.ones(N), np.zeros(N, dtype=np.int64))


def covariance_of(discrepancy: Discrepancy, size: float) -> Floats:
    result = np.eye(N)
    for place, basis, variance in discrepancy.of_run:
        result[np.ix_(place, place)] += size**2 * (basis * variance) @ basis.T
    return result


def sizes_of(one: MemberColumns) -> list[tuple[Floats, float]]:
    """Return the sizes of a member's coefficients, each with its probability: all alike, or one alone."""
    count = len(one.rows)
    found = [(size * np.ones(count), (1.0 - one.alone) * w) for size, w in zip(one.sizes, one.weights, strict=True)]
    if one.alone:
        found += [
            (size * axis, one.alone * w / count)
            for axis in np.eye(count)
            for size, w in zip(one.sizes, one.weights, strict=True)
        ]
    return found


def by_brute_force(
    common: Floats, wide: float, y: Floats, chosen: list[MemberColumns], discrepancy: Discrepancy
) -> float:
    """Return the log density of y, coefficients of ``common`` with a prior so wide that it is flat."""
    total = []
    each = (1.0 - NO_DISCREPANCY) / len(DISCREPANCIES)
    for size, weight in [(0.0, NO_DISCREPANCY), *((size, each) for size in DISCREPANCIES)]:
        plain = covariance_of(discrepancy, size) + wide**2 * common.T @ common
        for grid in product(*(sizes_of(one) for one in chosen)):
            whole, log_weight = plain.copy(), np.log(weight)
            for (scale, share), one in zip(grid, chosen, strict=True):
                whole += (one.rows.T * scale**2) @ one.rows
                log_weight += np.log(share)
            total.append(log_weight + multivariate_normal(np.zeros(N), whole).logpdf(y))
    return float(logsumexp(total))


@pytest.fixture
def drawn() -> tuple[Floats, Floats, list[MemberColumns], Discrepancy]:
    rng = np.random.default_rng(5)
    members = [member(rng, 1), member(rng, 2), member(rng, 3)]
    y = rng.normal(size=N) + 1.5 * members[0].rows[0]
    return rng.normal(size=(2, N)), y, members, of_poses(rng)


def test_ratios_are_those_of_brute_force(drawn: tuple[Floats, Floats, list[MemberColumns], Discrepancy]) -> None:
    common, y, members, discrepancy = drawn
    evidence = SetEvidence.of(read(common, discrepancy, y), members, EXACTLY)
    none = by_brute_force(common, 1e4, y, [], discrepancy)
    for number, one in enumerate(members):
        expected = by_brute_force(common, 1e4, y, [one], discrepancy) - none
        assert evidence.normal([number]) - evidence.normal([]) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("known", [0.0, 4.0])
def test_a_scale_of_the_noise_that_is_not_known_is_integrated(
    known: float, drawn: tuple[Floats, Floats, list[MemberColumns], Discrepancy]
) -> None:
    """By sums over it: log-uniform, or about one with so many degrees of freedom; each reading counts once."""
    common, y, members, discrepancy = drawn
    log_scale = np.linspace(-4.0, 4.0, 801)
    prior = -0.5 * known * (2.0 * log_scale + np.exp(-2.0 * log_scale))
    flat = np.linalg.qr(common.T, mode="complete")[0][:, len(common) :]

    def integrated(rows: Floats, sizes: Floats, weights: Floats) -> float:
        found = []
        for tau, share in [
            (0.0, NO_DISCREPANCY),
            *((tau, (1.0 - NO_DISCREPANCY) / len(DISCREPANCIES)) for tau in DISCREPANCIES),
        ]:
            for size, weight in zip(sizes, weights, strict=True):
                whole = flat.T @ (covariance_of(discrepancy, tau) + size**2 * rows.T @ rows) @ flat
                square = float(y @ flat @ np.linalg.solve(whole, flat.T @ y))
                density = prior - 0.5 * np.exp(-2.0 * log_scale) * square - log_scale * len(whole)
                found.append(logsumexp(density) - 0.5 * np.linalg.slogdet(whole)[1] + np.log(share * weight))
        return float(logsumexp(found))

    evidence = SetEvidence.of(read(common, discrepancy, y), members, NoiseScale(float(N - 2), known))
    none = integrated(np.zeros((1, N)), np.ones(1), np.ones(1))
    expected = integrated(members[0].rows, members[0].sizes, members[0].weights) - none
    assert evidence.normal([0]) - evidence.normal([]) == pytest.approx(expected, abs=1e-4)


def test_several_members_are_summed_about_their_best_sizes(
    drawn: tuple[Floats, Floats, list[MemberColumns], Discrepancy],
) -> None:
    """The sum over all combinations is approached by one line per member: exact where sizes do not depend on others."""
    common, y, members, discrepancy = drawn
    evidence = SetEvidence.of(read(common, discrepancy, y), members, EXACTLY)
    none = by_brute_force(common, 1e4, y, [], discrepancy)
    expected = by_brute_force(common, 1e4, y, members[:2], discrepancy) - none
    assert evidence.normal([0, 1]) - evidence.normal([]) == pytest.approx(expected, abs=0.05)


def test_a_coefficient_that_cannot_be_negative_counts_by_its_probability(
    drawn: tuple[Floats, Floats, list[MemberColumns], Discrepancy],
) -> None:
    """By importance: the share of free draws of the coefficient that are positive, over a half."""
    common, y, members, discrepancy = drawn
    free = members[0]
    bounded = MemberColumns(free.rows, np.ones(1, dtype=np.bool_), free.sizes[:1], np.ones(1))
    plain = MemberColumns(free.rows, free.bounded, free.sizes[:1], np.ones(1))
    y = y - 1.4 * free.rows[0]
    evidence = SetEvidence.of(read(common, discrepancy, y), [plain, bounded], EXACTLY)
    precision = evidence.inner.own[0][0, 0, 0] + 1.0 / free.sizes[0] ** 2
    rng = np.random.default_rng(1)
    draws = evidence.inner.target[0][0, 0] / precision + rng.normal(size=400_000) / np.sqrt(precision)
    share = float(np.mean(draws > 0.0))
    gain = evidence.best_sizes([1])[0][0] - evidence.best_sizes([0])[0][0]
    error = np.sqrt((1.0 - share) / share / 400_000)
    assert gain == pytest.approx(np.log(2.0 * share), abs=5.0 * error)


@pytest.mark.parametrize("known", [0.0, 4.0, np.inf])
def test_units_of_common_columns_and_of_coefficients_change_nothing(
    known: float, drawn: tuple[Floats, Floats, list[MemberColumns], Discrepancy]
) -> None:
    common, y, members, discrepancy = drawn
    noise = NoiseScale(float(N - 2), known)
    mixed = np.array([[1e3, 2e3], [0.0, 1e-4]]) @ common
    in_other_unit = [replace(one, rows=1e3 * one.rows, sizes=1e-3 * one.sizes) for one in members]
    one = SetEvidence.of(read(common, discrepancy, y), members, noise)
    other = SetEvidence.of(read(mixed, discrepancy, y), in_other_unit, noise)
    change = [evidence.of_set([0, 2]) - evidence.of_set([]) for evidence in (one, other)]
    assert change[0] == pytest.approx(change[1], abs=1e-6)


def test_conditional_products_are_those_of_the_larger_set(
    drawn: tuple[Floats, Floats, list[MemberColumns], Discrepancy],
) -> None:
    common, y, members, discrepancy = drawn
    fixed = [MemberColumns(one.rows, one.bounded, one.sizes[:1], np.ones(1)) for one in members]
    evidence = SetEvidence.of(read(common, discrepancy, y), fixed, EXACTLY)
    size = np.full(len(fixed[0].rows), fixed[0].sizes[0])
    for t in range(1 + len(DISCREPANCIES)):
        left = evidence.inner.given([0], size, t)
        gain = evidence.sizes_next_to([2], left[2])[0] - evidence.sizes_next_to([], left[2])[0]
        direct = (evidence.best_sizes([0, 2])[0] - evidence.best_sizes([0])[0])[t]
        assert gain[0] == pytest.approx(direct, abs=1e-9)


def test_the_grid_of_discrepancies_is_fine_enough_for_a_wander() -> None:
    """On a grid of ratio 2.9 a linear drift gained five nats where the wander's size lay between two of its points."""
    readings, components = 60, 3
    waves = np.arange(1, WAVES + 1)
    variance = np.repeat(0.5 * readings / waves**2 / np.sum(0.5 / waves**2), components)

    def density(wander: float, grid: Floats) -> float:
        """Return the log of the mean density that readings with a wander have in the mean of its logarithm."""
        along, assumed = 1.0 + wander**2 * variance, 1.0 + grid[:, None] ** 2 * variance
        each = -0.5 * np.sum(np.log(assumed) + along / assumed, axis=1)
        return float(np.logaddexp.reduce(each) - np.log(len(grid)))

    dense = np.geomspace(DISCREPANCIES[0], DISCREPANCIES[-1], 2001)
    off = [density(wander, DISCREPANCIES) - density(wander, dense) for wander in np.geomspace(0.2, 5.0, 60)]
    assert np.ptp(off) < 0.25

"""Small problems drawn from the very priors: what is stated with 30 % has to be true in 30 %.

Linear, with sets small enough that all of them are weighed: members with a size from the cells of their grid, a
discrepancy from those of its own, noise of known scale, with tails or without.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.judgement.discrepancy import AlikeRuns, Discrepancy
from stiffcal.judgement.evidence import MemberColumns, SetEvidence
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import ALONE, DISCREPANCIES, NO_DISCREPANCY, NORMAL, TAILS
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.tails import Readings

MEMBERS, RUNS, PER_RUN, COMMON = 4, 6, 5, 2
ODDS = 0.5
SIZES = np.geomspace(0.15, 1.5, 5)
WEIGHTS = np.full(len(SIZES), 1.0 / len(SIZES))


@dataclass(frozen=True)
class Stated:
    """A probability that was stated of a member, and whether it was drawn."""

    probability: float
    drawn: bool


def drawn_and_judged(seed: int, count: int) -> list[Stated]:
    """Return what is stated of all members of so many problems."""
    rng = np.random.default_rng(seed)
    return [one for _ in range(count) for one in _problem(rng)]


def _problem(rng: np.random.Generator) -> list[Stated]:
    n = RUNS * PER_RUN
    discrepancy = _discrepancy(rng)
    members = [_member(rng.normal(size=(int(rng.integers(1, 4)), n)), rng.uniform() < 0.3) for _ in range(MEMBERS)]
    present = rng.uniform(size=MEMBERS) < ODDS / (1.0 + ODDS)
    y = _noise(rng, n)
    tau = 0.0 if rng.uniform() < NO_DISCREPANCY else _of_cell(rng, DISCREPANCIES)
    for place, basis, variance in discrepancy.of_run:
        y[place] += tau * basis @ (np.sqrt(variance) * rng.normal(size=len(variance)))
    for one, is_present in zip(members, present, strict=True):
        if is_present:
            alone = rng.uniform() < one.alone
            pattern = one.patterns[rng.integers(1, len(one.patterns)) if alone else 0]
            coefficients = _of_cell(rng, one.sizes) * pattern * rng.normal(size=len(one.rows))
            y += np.where(one.bounded, np.abs(coefficients), coefficients) @ one.rows
    common = rng.normal(size=(COMMON, n))
    y += rng.normal(size=COMMON) @ common * 100.0
    shared = Shared(common, np.zeros((0, COMMON + 1)), [(discrepancy, 1.0 - NO_DISCREPANCY)])
    evidence = SetEvidence.of(
        Readings(shared, y, np.ones(n), np.zeros(n, dtype=np.int64)), members, NoiseScale(float(n - COMMON), np.inf)
    )
    sets = [chosen for k in range(MEMBERS + 1) for chosen in combinations(range(MEMBERS), k)]
    logs = np.array([evidence.of_set(chosen) + len(chosen) * np.log(ODDS) for chosen in sets])
    p = np.exp(logs - np.logaddexp.reduce(logs))
    return [
        Stated(float(sum(p[k] for k, chosen in enumerate(sets) if number in chosen)), bool(present[number]))
        for number in range(MEMBERS)
    ]


def _of_cell(rng: np.random.Generator, grid: Floats) -> float:
    """Draw a size that one of an even geometric grid stands for, all alike."""
    half = 0.5 * np.log(grid[1] / grid[0])
    return float(np.exp(rng.uniform(np.log(grid[0]) - half, np.log(grid[-1]) + half)))


def _member(rows: Floats, bounded: bool) -> MemberColumns:
    return MemberColumns(rows, np.full(len(rows), bounded), SIZES, WEIGHTS, ALONE if len(rows) > 1 else 0.0)


def _noise(rng: np.random.Generator, count: int) -> Floats:
    """Return noise of unit variance, normal or with tails."""
    if rng.uniform() < NORMAL:
        return rng.normal(size=count)
    dof = float(rng.choice(TAILS))
    return np.asarray(rng.standard_t(dof, size=count) * np.sqrt(1.0 - 2.0 / dof))


def _discrepancy(rng: np.random.Generator) -> Discrepancy:
    bases, _ = np.linalg.qr(rng.normal(size=(RUNS, PER_RUN, 2)))
    place, at = np.arange(RUNS * PER_RUN).reshape(RUNS, PER_RUN), np.arange(2 * RUNS).reshape(RUNS, 2)
    alike = AlikeRuns(np.arange(RUNS), place, bases, at)
    return Discrepancy(tuple(range(RUNS)), RUNS * PER_RUN, [alike], rng.uniform(0.5, 2.0, 2 * RUNS))


def bins(stated: list[Stated], edges: Floats) -> list[tuple[float, int, int]]:
    """Return per bin the mean that was stated, how many were drawn, and of how many."""
    found = []
    for low, high in pairwise(edges):
        own = [one for one in stated if low <= one.probability < high]
        if own:
            mean = float(np.mean([one.probability for one in own]))
            found.append((mean, sum(one.drawn for one in own), len(own)))
    return found


def worst(stated: list[Stated], edges: Floats) -> float:
    """Return by how many standard errors the worst bin is off."""
    return max(abs(_error(mean, drawn, of)) for mean, drawn, of in bins(stated, edges))


def _error(mean: float, drawn: int, of: int) -> float:
    """Return by how many standard errors so many drawn are more than was stated."""
    return float((drawn - mean * of) / max(np.sqrt(of * mean * (1.0 - mean)), 1.0))


EDGES = np.array([0.0, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95, 0.99, 1.0 + 1e-9])


def table(stated: list[Stated]) -> str:
    """Return the reliability as text."""
    lines = ["stated      true      of   standard errors"]
    for mean, drawn, of in bins(stated, EDGES):
        lines.append(f"{mean:6.3f}  {drawn / of:8.3f}{of:>8}   {_error(mean, drawn, of):+.1f}")
    return "\n".join(lines)

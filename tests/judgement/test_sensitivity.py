"""Priors taken three times larger and smaller: odds move by exactly that, and what is far behind stays there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from stiffcal.judgement.discrepancy import AlikeRuns, Discrepancy
from stiffcal.judgement.evidence import MemberColumns, SetEvidence
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.members import Member
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import DISCREPANCIES, NO_DISCREPANCY, PRIOR_FACTOR
from stiffcal.judgement.priors import MemberKind, Share
from stiffcal.judgement.sensitivity import varied
from stiffcal.judgement.sets import WeighedSets
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.tails import Readings

N = 24
EFFECT, UNLISTED, RUN = (0,), (1,), (2,)


@pytest.fixture
def judged() -> Judged:
    """Return sets of an effect, an unlisted law and a run that is off, each alone."""
    rng = np.random.default_rng(3)
    basis, _ = np.linalg.qr(rng.normal(size=(N, 4)))
    first = np.zeros((1, 1), dtype=np.int64)
    whole = AlikeRuns(first[0], np.arange(N)[None], basis[None, :, 3:], first)
    poses, wander, lingering = (Discrepancy((0,), N, [whole], np.ones(1)) for _ in range(3))
    y = 4.0 * basis[:, 0] + 3.5 * basis[:, 1] + 3.0 * basis[:, 2]
    kinds = [MemberKind.EFFECT, MemberKind.UNLISTED, MemberKind.MISTAKE]
    members = []
    for k, kind in enumerate(kinds):
        columns = MemberColumns(basis[:, [k]].T, np.zeros(1, dtype=np.bool_), np.array([1.0, 4.0]), np.ones(2))
        members.append(Member(kind.value, Share(f"place {k}", "", kind, False), None, {}, 0.0, columns, -3.0))
    none = (1.0 - NO_DISCREPANCY) / 3
    shared = Shared(np.zeros((0, N)), np.zeros((0, 1)), ((poses, none), (wander, none), (lingering, none)))
    evidence = SetEvidence.of(
        Readings(shared, y, np.ones(N), np.zeros(N, dtype=np.int64)),
        [one.columns for one in members],
        NoiseScale(float(N), 4.0),
    )
    weighed = WeighedSets(members, evidence)
    for key in ((), EFFECT, UNLISTED, RUN):
        weighed.weigh(key)
    ground = SimpleNamespace(shared=shared, of_loads=poses, of_time=wander, lingering=lingering, alike=None)
    return cast("Judged", SimpleNamespace(weighed=weighed, members=members, ground=ground))


def odds(sets: dict[tuple[int, ...], float], key: tuple[int, ...]) -> float:
    return sets[key] / sets[()]


def test_odds_move_by_the_factor(judged: Judged) -> None:
    plain = judged.weighed.probabilities()
    more = [dict(one.sets) for one in varied(judged)]
    laws, unlisted, mistakes = more[:3]
    assert odds(laws, EFFECT) == pytest.approx(PRIOR_FACTOR * odds(plain, EFFECT))
    assert odds(laws, UNLISTED) == pytest.approx(PRIOR_FACTOR * odds(plain, UNLISTED))
    assert odds(laws, RUN) == pytest.approx(odds(plain, RUN))
    assert odds(unlisted, EFFECT) == pytest.approx(odds(plain, EFFECT))
    assert odds(unlisted, UNLISTED) == pytest.approx(PRIOR_FACTOR * odds(plain, UNLISTED))
    assert odds(mistakes, RUN) == pytest.approx(PRIOR_FACTOR * odds(plain, RUN))


def test_every_prior_is_varied_both_ways(judged: Judged) -> None:
    """Four odds, three discrepancies, two typical sizes and how well stated noise is known; larger, then smaller."""
    every = [one.sets for one in varied(judged)]
    assert len(every) == 2 * (4 + 3 + 2 + 1)
    assert all(sum(sets.values()) == pytest.approx(1.0) for sets in every)
    assert len(DISCREPANCIES) > 1


def test_a_size_far_from_typical_costs_what_its_prior_says(judged: Judged) -> None:
    """With sizes a third as large the effect of four noises is less probable, the run as probable as before."""
    smaller = [dict(one.sets) for one in varied(judged)][10 + 7]
    plain = judged.weighed.probabilities()
    assert odds(smaller, EFFECT) < 0.9 * odds(plain, EFFECT)
    assert odds(smaller, RUN) == pytest.approx(odds(plain, RUN))

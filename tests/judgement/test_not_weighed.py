"""What was not weighed: its share is about what is stated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.errors import Progress, no_progress
from stiffcal.judgement.evidence import MemberColumns, SetEvidence
from stiffcal.judgement.inner_products import InnerProducts
from stiffcal.judgement.members import Member
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.priors import MemberKind, Share
from stiffcal.judgement.sets import WeighedSets, search_sets
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.tails import Readings

MEMBERS, READINGS = 40, 60


@pytest.fixture(scope="module")
def weighed() -> WeighedSets:
    """Return sets of effects of which one is there, and the others are as probable as one of 40."""
    return searched(1.0)


def searched(size: float, progress: Progress = no_progress) -> WeighedSets:
    """Return sets about readings with one effect, of this size."""
    rng = np.random.default_rng(6)
    columns = [
        MemberColumns(rng.normal(size=(1, READINGS)), np.zeros(1, dtype=np.bool_), np.array([0.3, 1.0]), np.ones(2))
        for _ in range(MEMBERS)
    ]
    y = rng.normal(size=READINGS) + size * columns[3].rows[0]
    members = [
        Member(f"effect {k}", Share(f"place {k}", "", MemberKind.EFFECT, False), None, {}, 0.0, one, -np.log(MEMBERS))
        for k, one in enumerate(columns)
    ]
    shared = Shared(np.zeros((0, READINGS)), np.zeros((0, 1)), [])
    readings = Readings(shared, y, np.ones(READINGS), np.zeros(READINGS, dtype=np.int64))
    return search_sets(
        members, SetEvidence.of(readings, columns, NoiseScale(float(READINGS), np.inf)), progress=progress
    )


def test_sets_that_were_not_weighed_have_what_is_stated(weighed: WeighedSets) -> None:
    assert weighed.best == (3,)
    everything = replace(weighed, log=dict(weighed.log), by_discrepancy=dict(weighed.by_discrepancy))
    for key in combinations(range(MEMBERS), 2):
        everything.weigh(key)
    p = everything.probabilities()
    left = sum(value for key, value in p.items() if key not in weighed.log)
    assert left > 0.01
    assert weighed.not_weighed == pytest.approx(left, rel=0.05)


def test_what_was_weighed_is_not_counted(weighed: WeighedSets) -> None:
    """With all additions to the enlarged sets weighed nothing is left but the growth of the others."""
    assert replace(weighed, beyond=dict.fromkeys(weighed.log, 0.0)).not_weighed == 0.0


def test_tails_are_not_asked_for_of_sets_that_are_out_of_reach(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, gains = list[Sequence[int]](), Readings.gains

    def counted(readings: Readings, inner: InnerProducts, chosen: Sequence[int], *more: Any) -> Floats:
        asked.append(chosen)
        return gains(readings, inner, chosen, *more)

    shown = list[tuple[str, float | None]]()
    monkeypatch.setattr(Readings, "gains", counted)
    assert searched(10.0, lambda text, share: shown.append((text, share))).best == (3,)
    assert asked
    assert all(3 in chosen for chosen in asked)
    # what is weighed is shown, n of m, and how much of it is done
    assert [text for text, _ in shown if f" of {MEMBERS + 2}" in text]
    assert [share for _, share in shown] == sorted(share for _, share in shown if share is not None)

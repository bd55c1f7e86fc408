"""One effect that makes what two of the model make is more probable, and still not missing (the bundled kr240)."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.judgement.discrepancy import AlikeRuns, Discrepancy
from stiffcal.judgement.evidence import Key, MemberColumns, SetEvidence
from stiffcal.judgement.found import _what_the_model_has_first
from stiffcal.judgement.members import Member
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import NAMED, NO_DISCREPANCY
from stiffcal.judgement.priors import MemberKind, Share
from stiffcal.judgement.reading import _next_to_model
from stiffcal.judgement.sets import WeighedSets
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.tails import Readings

N = 24
BASIS, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(N, 4)))
TILT_1, TILT_2, BEAM = 0, 1, 2


def judged_of(beam: Floats, y: Floats) -> Any:
    """Return what a judgement of two tilts, which the model has, and a beam that it has not is read off."""
    first = np.zeros((1, 1), dtype=np.int64)
    whole = AlikeRuns(first[0], np.arange(N)[None], BASIS[None, :, 3:], first)
    shared = Shared(
        np.zeros((0, N)), np.zeros((0, 1)), ((Discrepancy((0,), N, [whole], np.ones(1)), 1 - NO_DISCREPANCY),)
    )
    members = []
    for name, column, log_prior in (("tilt 1", BASIS[:, 0], -5.4), ("tilt 2", BASIS[:, 1], -5.4), ("beam", beam, -4.0)):
        columns = MemberColumns(column[None], np.zeros(1, dtype=np.bool_), np.array([1.0, 4.0, 16.0]), np.ones(3))
        share = Share(name, "", MemberKind.EFFECT, False)
        members.append(Member(name, share, None, {}, 0.0, columns, log_prior))
    readings = Readings(shared, y, np.ones(N), np.zeros(N, dtype=np.int64))
    evidence = SetEvidence.of(readings, [one.columns for one in members], NoiseScale(float(N), np.inf))
    weighed = WeighedSets(members, evidence)
    for key in ((TILT_1, TILT_2), (BEAM,), (TILT_1, BEAM), (TILT_2, BEAM)):
        weighed.weigh(key)
    return SimpleNamespace(weighed=weighed, members=members, model=frozenset({"tilt 1", "tilt 2"}))


def next_to_model(judged: Any) -> tuple[float, float]:
    """Return the beam's probability by all sets, and next to all that the model has."""
    sets: dict[Key, float] = judged.weighed.probabilities()
    names = {key: frozenset(judged.members[i].name for i in key) for key in sets}
    beam = sum(value for key, value in sets.items() if BEAM in key)
    return beam, _next_to_model(judged, {"beam"}, sets, names, (TILT_1, TILT_2))


def test_what_two_effects_of_the_model_make_is_not_missing() -> None:
    probability, beyond = next_to_model(
        judged_of((BASIS[:, 0] + BASIS[:, 1]) / np.sqrt(2.0), 10.0 * BASIS.T[:2].sum(0))
    )
    assert probability > 0.95
    assert beyond < NAMED


def test_what_they_do_not_make_is() -> None:
    beam = BASIS[:, :3].sum(axis=1) / np.sqrt(3.0)
    probability, beyond = next_to_model(judged_of(beam, 12.0 * beam))
    assert probability > 0.95
    assert beyond > 0.95


@pytest.mark.parametrize(("lacking", "first"), [(True, "beam"), (False, "tilt 1")])
def test_what_the_model_has_comes_first_where_nothing_is_missing(lacking: bool, first: str) -> None:
    ranked = [("beam", 0.97), ("springs", 0.02), ("tilt 1", 0.01)]
    found = _what_the_model_has_first(ranked, {"tilt 1"}, lacking)
    assert found[0][0] == first
    assert sorted(found) == sorted(ranked)

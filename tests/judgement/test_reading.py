"""What is read off probabilities of sets."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.judgement import reading
from stiffcal.judgement.checks import Check
from stiffcal.judgement.discrepancy import AlikeRuns, Discrepancy
from stiffcal.judgement.evidence import Key, MemberColumns, SetEvidence
from stiffcal.judgement.ground import CheckKind
from stiffcal.judgement.members import Member
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import CHANCE, DISCREPANCIES, FIRM, SCATTERS, SHOWS, STILL_FIRM
from stiffcal.judgement.priors import MemberKind, Share
from stiffcal.judgement.reading import _left, _present, _shares, read_off
from stiffcal.judgement.sets import WeighedSets
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.tails import Readings


def test_a_group_without_any_set_has_no_shares() -> None:
    """Without the discrepancy the sets with an effect may have no probability at all; that ended with exit 3."""
    names: dict[Key, frozenset[str]] = {(0,): frozenset({"creep j1"}), (1,): frozenset({"backlash j1"})}
    assert _shares({"creep j1"}, {(0,): 0.0, (1,): 1.0}, names) == {}
    assert _shares({"creep j1"}, {(0,): 0.2, (1,): 0.8}, names) == {"creep j1": 1.0}


def test_an_effect_has_one_probability_in_its_group_and_by_itself() -> None:
    """By the rule for conditional probabilities: one in all sets was named with 95 % next to one in few."""
    sets: dict[Key, float] = {(0,): 0.5, (0, 1): 0.1, (1, 2): 0.2, (2,): 0.2}
    names: dict[Key, frozenset[str]] = {key: frozenset("abc"[i] for i in key) for key in sets}
    shares = _shares({"a", "b"}, sets, names)
    assert shares == {"a": pytest.approx(0.6 / 0.8), "b": pytest.approx(0.3 / 0.8)}
    assert _shares({"a", "b"}, {(0,): 0.9, (0, 1): 0.1}, names)["a"] == 1.0


def test_what_may_be_there_besides_is_nothing_in_its_place() -> None:
    """Two of three sweeps of a bench were not certain of a play, as a drift next to it had one set in ten."""
    names: dict[Key, frozenset[str]] = {
        (0,): frozenset({"backlash j1"}),
        (0, 1): frozenset({"backlash j1", "encoder-drift j1"}),
        (1,): frozenset({"encoder-drift j1"}),
    }
    own = {"backlash j1", "encoder-drift j1"}
    shares = _shares(own, {(0,): 0.86, (0, 1): 0.1, (1,): 0.04}, names)
    assert shares == pytest.approx({"backlash j1": 0.96, "encoder-drift j1": 0.14})


@pytest.mark.parametrize("absolute", [False, True])
def test_a_discrepancy_shows_by_its_rms_over_all_readings(absolute: bool) -> None:
    """Half of the noise and more, or as much as an effect; the scatter of absolute places from the noise on."""
    size = SCATTERS if absolute else SHOWS
    of_loads, of_time = (SimpleNamespace(variance=np.full(50, 0.5), runs=(0,)) for _ in range(2))
    where = {id(of_loads): 1, id(of_time): 1 + len(DISCREPANCIES)}
    shared = SimpleNamespace(numbers_of=lambda one: [where[id(one)] + k for k in range(len(DISCREPANCIES))])
    space = SimpleNamespace(data=SimpleNamespace(absolute=np.full(9, absolute)))
    ground = SimpleNamespace(of_loads=of_loads, of_time=of_time, shared=shared, space=space)
    noise = SimpleNamespace(noise=SimpleNamespace(dof=100.0))

    def left(one: SimpleNamespace, number: int, least: float) -> float:
        of_discrepancy = np.eye(1 + 2 * len(DISCREPANCIES))[where[id(one)] + number]
        weighed = SimpleNamespace(of_discrepancy=lambda: of_discrepancy, evidence=noise)
        judged: Any = SimpleNamespace(ground=ground, weighed=weighed)
        return _left(judged, least)

    for one, least in ((of_loads, size), (of_time, SHOWS)):
        # of a hundred readings fifty directions are moved, by half the variance of the discrepancy
        first = int(np.argmax(least <= DISCREPANCIES / 2.0))
        assert [left(one, k, 0.0) for k in (first - 1, first)] == [0.0, 1.0]
        assert left(one, first, DISCREPANCIES[first]) == 1.0
        assert left(one, first, 1.01 * DISCREPANCIES[first]) == 0.0


def test_the_present_model_has_the_shapes_that_were_weighed() -> None:
    """Of shapes that a fit makes alike one stands for all, and the others are in no set; that ended with exit 3."""
    members = [SimpleNamespace(name=name) for name in ("backlash j2", "backlash j2", "backlash j2", "bearing-tilt j2")]
    names: dict[Key, frozenset[str]] = {(k,): frozenset({members[k].name}) for k in (1, 2, 3)}
    log = {(1,): -3.0, (2,): -2.0, (3,): -5.0}
    model = frozenset({"backlash j2", "bearing-tilt j2"})
    judged: Any = SimpleNamespace(members=members, model=model, weighed=SimpleNamespace(log=log))
    assert _present(judged, names) == (2, 3)


N = 24
PLAY, SPRINGS, LAW = 0, 1, 2


def judged_of(
    effect: float, law: float = 0.0, *, shared: float = 0.0, poses_differ: float = 0.0, wander: float = 0.0,
    settled: float = 1.0, at_bound: bool = False, n_runs: int = 1,
) -> Any:  # fmt: skip
    """Return what is read off: a play of so many noises, next to springs of a link and a law of no catalogue.

    Parameters
    ----------
    shared : the part of the play in the law.
    """
    rng = np.random.default_rng(3)
    basis, _ = np.linalg.qr(rng.normal(size=(N, N)))
    alike = [
        AlikeRuns(
            np.zeros(1, dtype=np.int64), np.arange(N)[None], basis[None, :, k : k + 1], np.zeros((1, 1), dtype=np.int64)
        )
        for k in (3, 4)
    ]
    of_poses, of_time = (Discrepancy(tuple(range(n_runs)), N, [one], np.ones(1)) for one in alike)
    common = Shared(np.zeros((0, N)), np.zeros((0, 1)), ((of_poses, 0.2), (of_time, 0.2)))
    kinds = (MemberKind.EFFECT, MemberKind.EFFECT, MemberKind.UNLISTED)
    members = []
    for k, (name, kind) in enumerate(zip(("play j1", "springs arm", "joint 2: its angle"), kinds, strict=True)):
        made = basis[:, k] if k != LAW else shared * basis[:, PLAY] + np.sqrt(1.0 - shared**2) * basis[:, LAW]
        columns = MemberColumns(made[None], np.zeros(1, dtype=np.bool_), np.array([1.0, 4.0, 16.0]), np.ones(3))
        share = Share(name, name, kind, True)
        members.append(Member(name, share, None, {}, 0.0, columns, -3.0, settled=settled))
    y = basis[:, :5] @ [effect, 0.0, law, poses_differ, wander] + basis[:, 5:] @ rng.normal(size=N - 5)
    readings = Readings(common, y, np.ones(N), np.zeros(N, dtype=np.int64))
    weighed = WeighedSets(
        members, SetEvidence.of(readings, [one.columns for one in members], NoiseScale(float(N), np.inf))
    )
    for key in ((), (PLAY,), (SPRINGS,), (LAW,), (PLAY, LAW), (PLAY, SPRINGS)):
        weighed.weigh(key)
    space = SimpleNamespace(data=SimpleNamespace(absolute=np.zeros(N, dtype=np.bool_)))
    ground = SimpleNamespace(
        shared=common,
        of_loads=of_poses,
        of_time=of_time,
        lingering=None,
        alike=None,
        louder=None,
        of_noise=[0],
        space=space,
    )
    return SimpleNamespace(
        weighed=weighed, members=members, ground=ground, best=[members[i] for i in weighed.best], model=frozenset(),
        aside={}, at_bound=at_bound, noise_number=0,
    )  # fmt: skip


NO_CHANCE = Check(CheckKind.TRANSLATION, 4.0, 0.1 * CHANCE)


@pytest.mark.parametrize(
    ("judged", "checks", "named", "firm", "unexplained"),
    [
        (judged_of(0.0), (), False, False, False),
        (judged_of(0.0), (NO_CHANCE,), False, False, True),
        (judged_of(3.6), (), True, False, False),
        (judged_of(12.0), (), True, True, False),
        (judged_of(12.0), (NO_CHANCE,), True, False, True),
        (judged_of(12.0, law=12.0), (), True, False, True),
        (judged_of(12.0, law=2.9), (), True, True, False),
        (judged_of(12.0, law=2.9, shared=0.8), (), True, False, False),
        (judged_of(12.0, poses_differ=40.0), (), True, False, True),
        (judged_of(12.0, at_bound=True), (), True, False, False),
        (judged_of(12.0, settled=0.9), (), True, False, False),
        (judged_of(0.0, law=12.0), (), False, False, True),
    ],
    ids=[
        "nothing",
        "nothing and a check fails",
        "probable",
        "firm",
        "check fails",
        "next to a law",
        "a law may be there",
        "a law may be in its place",
        "poses differ as much",
        "at its bound",
        "order not known",
        "a law",
    ],
)
def test_what_is_named_and_what_is_firm(
    judged: Any, checks: tuple[Check, ...], named: bool, firm: bool, unexplained: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A group from a half on; firm from 0.95 on, where no check fails and next to no law of no catalogue."""
    monkeypatch.setattr(reading, "checks_of", lambda judged: checks)
    found = read_off(judged)
    assert [group.members[0][0] for group in found.groups] == ["play j1"] * named
    assert [group.firm for group in found.groups] == [firm] * named
    assert found.unexplained is unexplained
    # what is left by the present model is noise where nothing shows
    assert (found.p_nothing > 0.95) is (not named and found.p_unknown < 0.5)
    assert found.adequate is (not named and not unexplained)
    assert set(found.probability) == {"play j1", "springs arm"}
    assert not unexplained or checks or found.unlisted or found.discrepancy


@pytest.mark.parametrize("doubted", ["prior", "discrepancy", ""])
def test_a_name_that_hangs_on_a_prior_or_on_the_discrepancy_is_not_firm(
    doubted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reading, "checks_of", lambda judged: ())
    judged = judged_of(12.0)
    springs = 1.0 - STILL_FIRM + 0.01 if doubted == "prior" else 1.0 - FIRM + 0.01
    less = dict.fromkeys(judged.weighed.log, 0.0) | {(PLAY,): 1.0 - springs, (SPRINGS,): springs}
    if doubted == "prior":
        monkeypatch.setattr(reading, "varied", lambda judged: [SimpleNamespace(sets=less)])
    elif doubted:
        monkeypatch.setattr(WeighedSets, "given_discrepancy", lambda weighed, numbers: less)
    assert [group.firm for group in read_off(judged).groups] == [not doubted]


@pytest.mark.parametrize("in_time", [False, True])
def test_a_scatter_that_follows_nothing_is_found_with_its_size(in_time: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "checks_of", lambda judged: ())
    size = 20.0
    found = read_off(judged_of(0.0, wander=size) if in_time else judged_of(0.0, poses_differ=size))
    assert found.unexplained
    assert found.unlisted == ()
    assert found.discrepancy is not None
    assert found.discrepancy.in_time is in_time
    # along one direction of 24 readings, as far as the grid's sizes go
    assert 0.3 * size < found.discrepancy.size * np.sqrt(N) < 1.5 * size
    assert read_off(judged_of(0.0)).discrepancy is None
    # of a spreadsheet each row is a run: nothing wanders in its course
    shown = read_off(judged_of(0.0, wander=size, n_runs=N)).discrepancy
    assert shown is not None
    assert not shown.in_time

"""What is read off the distribution over sets: groups of effects that the data do not tell apart, how sure they are."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.judgement.checks import Check, checks_of
from stiffcal.judgement.evidence import Key
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.numbers import (
    ALIKE,
    DISCREPANCIES,
    DOUBT,
    FIRM,
    LEAST_LIKELY,
    NAMED,
    SCATTERS,
    SHARED,
    SHOWS,
    STILL_FIRM,
)
from stiffcal.judgement.priors import MemberKind
from stiffcal.judgement.rows_off import Off
from stiffcal.judgement.sensitivity import varied
from stiffcal.judgement.settings_off import SettingOff

T = TypeVar("T")


@dataclass(frozen=True)
class AlikeEffects:
    """Effects of which one is missing, as far as the data tell them apart."""

    probability: float
    """That some of them is missing."""
    members: tuple[tuple[str, float], ...]
    """Name and probability of each, given that some of the group is missing; largest first. Two of them may be."""
    effects: float
    """Probability that some of its effects is missing: the others are mistakes."""
    firm: bool
    """Whether the first of them is named without doubt."""
    size: float
    """Rms over all readings of what its leading effect makes in the best set, in noises."""
    next_to_model: float
    """Probability of those that the model does not have next to all that it has; 1 where it has the first of them."""


@dataclass(frozen=True)
class WrongSetting:
    """A setting that is probably wrong."""

    setting: SettingOff
    """Which."""
    probability: float
    """That it is wrong."""
    alike: tuple[str, ...]
    """Names of effects that make what it makes."""


@dataclass(frozen=True)
class UnlistedFound:
    """A law that nobody has written down, and is probably there."""

    place: str
    """As `Share.place`."""
    follows: str
    """What it follows."""
    probability: float
    """That it is there."""


@dataclass(frozen=True)
class ShownDiscrepancy:
    """A discrepancy that shows: what differs from pose to pose, or in the course of runs, and follows no law."""

    in_time: bool
    """Whether it is a wander in the course of runs; else each pose has a way of its own, or a run is a single state."""
    probability: float
    """That it shows."""
    size: float
    """Rms over all readings at its most probable size, in noises."""


@dataclass(frozen=True)
class WhatIsMissing:
    """What is missing, how probable, and whether something is that nobody has written down."""

    groups: tuple[AlikeEffects, ...]
    """Those with a probability of a half and more."""
    doubted: tuple[tuple[Off, float], ...]
    """Runs and states that are off, with a probability of a half and more."""
    p_nothing: float
    """Probability that nothing shows more than half of the noise."""
    p_unknown: float
    """Probability of laws that nobody has written down, a discrepancy of the poses that shows among them."""
    checks: tuple[Check, ...]
    """Of the best set."""
    probability: Mapping[str, float]
    """Of each effect at its place, by ``effect place``, that it is there."""
    settings: tuple[WrongSetting, ...]
    """Settings that are wrong, with a probability of a half and more."""
    not_weighed: float
    """Share that sets which were not weighed have of all, as far as members gain next to those that were."""
    unlisted: tuple[UnlistedFound, ...]
    """Laws that nobody has written down with a probability of `DOUBT` and more, the most probable first."""
    discrepancy: ShownDiscrepancy | None = None
    """The one of poses, or in time, that probably shows; None where neither does."""

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that the best set does not pass."""
        return tuple(check for check in self.checks if check.failed)

    @property
    def adequate(self) -> bool:
        """Whether what is left by the model under test is noise: nothing shows more than half of it."""
        return self.p_nothing >= FIRM and not self.failed

    @property
    def unexplained(self) -> bool:
        """Whether something is probably missing that is none of the effects."""
        return self.p_unknown >= NAMED or bool(self.failed)


def read_off(judged: Judged) -> WhatIsMissing:
    """Return what a distribution says."""
    weighed, members = judged.weighed, judged.members
    sets, straight = weighed.probabilities(), weighed.given_discrepancy(judged.ground.of_noise)
    names = {key: frozenset(members[i].name for i in key) for key in sets}
    checks = checks_of(judged)
    of_no_catalogue = {key: frozenset(i for i in key if members[i].kind is MemberKind.UNLISTED) for key in sets}
    unlisted = min(sum(sets[key] for key, laws in of_no_catalogue.items() if laws), 1.0)
    # what is left shows that no hypothesis describes the readings: how they compare is then no certainty; nor is it
    # next to a law that nobody has written down, which is no more than near to what it stands for
    doubtful = any(check.failed for check in checks) or unlisted >= NAMED
    model = _present(judged, names)
    groups, taken = [], set[str]()
    every: list[Mapping[Key, float]] = []
    listed = {one.name for one in members if one.kind is MemberKind.EFFECT}
    included = _sums({key: names[key] & listed for key in sets}, sets)
    best = weighed.best
    order = [members[i].name for i in best if members[i].kind is MemberKind.EFFECT]
    order += sorted((name for name in included if name not in order), key=lambda name: -included[name])
    able = {one.name for one in members if one.kind is not MemberKind.UNLISTED}
    for leader in order:
        if leader in taken:
            continue
        if sum(value for key, value in sets.items() if names[key] & (able - taken)) < NAMED:
            # no group of what is left reaches it
            break
        own = _alike(judged, leader, sets, names) - taken
        p = sum(value for key, value in sets.items() if names[key] & own)
        if p < NAMED:
            continue
        shares = _shares(own, sets, names)
        # of equal ones the first by name, not by the order in which sets were weighed
        first = max(sorted(shares), key=lambda name: shares[name])
        new = 1.0 if first in judged.model else _next_to_model(judged, own - judged.model, sets, names, model)
        size = _size_of(judged, leader, sets, names)
        sure = min(new, _sure(first, own, sets, names), _sure(first, own, straight, names)) >= FIRM
        settled = all(one.settled >= FIRM for one in judged.best if one.name == leader)
        firm = (
            sure
            and settled
            and not doubtful
            and not judged.at_bound
            and _left(judged, size) < NAMED
            and _unlisted_in_place(judged, leader, sets, names, of_no_catalogue) < DOUBT
        )
        if firm:
            every = every or [one.sets for one in varied(judged)]
            firm = all(_sure(first, own, one, names) >= STILL_FIRM for one in every)
        taken |= own
        ranked = sorted(shares.items(), key=lambda item: (-item[1], item[0]))
        effects = sum(value for key, value in sets.items() if names[key] & own & listed)
        groups.append(AlikeEffects(min(p, 1.0), tuple(ranked), min(effects, 1.0), firm, size, new))
    off = _sums({key: frozenset(one for i in key for one in members[i].off) for key in sets}, sets)
    shows = _left(judged)
    small = sum(value for key, value in sets.items() if value > LEAST_LIKELY and _change(judged, key, model) < SHOWS)
    laws = _sums({key: frozenset(members[i].name for i in own) for key, own in of_no_catalogue.items()}, sets)
    wrong = _sums({key: frozenset(one for i in key if (one := members[i].setting) is not None) for key in sets}, sets)
    share_of = {one.name: one.share for one in members}
    probable = sorted((item for item in laws.items() if item[1] >= DOUBT), key=lambda item: -item[1])
    off |= judged.aside
    if judged.ground.louder is not None:
        off[Off(judged.ground.louder.run)] += judged.louder
    doubted = tuple((one, min(p, 1.0)) for one, p in sorted(off.items(), key=str) if p >= NAMED)
    return WhatIsMissing(
        tuple(groups),
        doubted,
        float(max(small * (1.0 - shows), 0.0)),
        float(1.0 - (1.0 - unlisted) * (1.0 - shows)),
        checks,
        {name: min(p, 1.0) for name, p in included.items()},
        tuple(
            WrongSetting(one, min(p, 1.0), tuple(sorted(_alike(judged, one.label, sets, names) & listed)))
            for one, p in sorted(wrong.items(), key=lambda item: -item[1])
            if p >= NAMED
        ),
        weighed.not_weighed,
        tuple(UnlistedFound(share_of[name].place, share_of[name].family, min(p, 1.0)) for name, p in probable),
        next((one for one in _shown(judged) if one.probability >= NAMED), None),
    )


def _sums(names: Mapping[Key, frozenset[T]], sets: Mapping[Key, float]) -> dict[T, float]:
    """Return the probability of each name: that of all sets with it, of those that are given."""
    found: dict[T, float] = defaultdict(float)
    for key, own in names.items():
        for name in own:
            found[name] += sets[key]
    return found


def _alike(judged: Judged, leader: str, sets: dict[Key, float], names: dict[Key, frozenset[str]]) -> set[str]:
    """Return the members of the leader's group: effects at its place, and what else makes what it makes.

    Mistakes too: a step of the target in a run is what a new zero of the force sensor does there.
    """
    members = judged.members
    key = max((key for key in sets if leader in names[key]), key=lambda k: sets[k])
    number = next(i for i in key if members[i].name == leader)
    taken = {members[i].name for i in judged.weighed.best} - {leader}
    own = members[number].share
    signal = _signal(judged, key, number)
    found = {leader}
    for i, one in enumerate(members):
        if one.kind is MemberKind.UNLISTED or one.name in taken:
            continue
        there = own.of_part and one.share.place == own.place and one.kind is MemberKind.EFFECT
        if there or _share(judged, signal, i) >= ALIKE**2:
            found.add(one.name)
    return found


def _next_to_model(
    judged: Judged, own: set[str], sets: Mapping[Key, float], names: Mapping[Key, frozenset[str]], model: Key
) -> float:
    """Return the probability of effects next to all that the model under test has, and what else their best set has.

    One effect may be more probable than two of the model that together make the same: it is there in their place, and
    the model lacks nothing. 1 where the best set with the effects has all of the model, or they exclude some of it.

    Parameters
    ----------
    own : names of effects that are alike, none of them in the model. model : the set of what that has.
    """
    weighed, members = judged.weighed, judged.members
    best = max((key for key in sets if names[key] & own), key=lambda key: sets[key])
    if judged.model <= names[best]:
        return 1.0
    whole = list(model)
    for number in best:
        if members[number].name not in judged.model and weighed.may_join(number, tuple(whole)):
            whole.append(number)
    without = [number for number in whole if members[number].name not in own]
    if len(without) == len(whole):
        return 1.0
    more, less = (
        weighed.evidence.of_set(sorted(key)) + sum(members[i].log_prior for i in key) for key in (whole, without)
    )
    return float(np.exp(-np.logaddexp(0.0, less - more)))


def _sure(name: str, own: set[str], sets: Mapping[Key, float], names: Mapping[Key, frozenset[str]]) -> float:
    """Return the probability of a group, or of a name in it where that is less."""
    return min(sum(value for key, value in sets.items() if names[key] & own), _shares(own, sets, names).get(name, 0.0))


def _shares(own: set[str], sets: Mapping[Key, float], names: Mapping[Key, frozenset[str]]) -> dict[str, float]:
    """Return the probability of each of a group's members, given that some of the group is there."""
    found = _sums({key: names[key] & frozenset(own) for key in sets}, sets)
    whole = sum(value for key, value in sets.items() if names[key] & own)
    # without the discrepancy no set with any of them may be left
    return {name: min(value / whole, 1.0) for name, value in found.items()} if whole > 0.0 else {}


@dataclass(frozen=True)
class _Signal:
    """What a member makes in a set."""

    discrepancy: int
    """Of the set, the best …"""
    number: int
    """… the member …"""
    coefficients: Floats
    """… and those (q,) of its columns."""


def _signal(judged: Judged, key: Key, number: int) -> _Signal:
    """Return what a member makes in a set, at the best sizes."""
    evidence = judged.weighed.evidence
    best, solution = evidence.coefficients(key)
    first = sum(len(evidence.members[i].rows) for i in key[: key.index(number)])
    return _Signal(best, number, solution[first : first + len(evidence.members[number].rows)])


def _share(judged: Judged, signal: _Signal, other: int) -> float:
    """Return the share of a member's squares, as it is in a set, that another's columns can make."""
    inner, t = judged.weighed.evidence.inner, signal.discrepancy
    whole = float(signal.coefficients @ inner.own[signal.number][t] @ signal.coefficients)
    across = inner.across(signal.number, t)[other] @ signal.coefficients
    own = inner.own[other][t]
    own = own + 1e-9 * np.trace(own) / len(own) * np.eye(len(own)) + 1e-300 * np.eye(len(own))
    return float(across @ np.linalg.solve(own, across)) / max(whole, 1e-300)


def _left(judged: Judged, size: float = 0.0) -> float:
    """Return the probability that poses answer in ways of their own, or wander, so that it shows.

    By its rms over all readings, as an effect does: what is less than half of the noise is as good as nothing, of the
    scatter between absolute places what is less than the noise.

    Parameters
    ----------
    size : of the discrepancy, in noises; a smaller one does not count.
    """
    return sum(one.probability for one in _shown(judged, size))


def _shown(judged: Judged, size: float = 0.0) -> Iterator[ShownDiscrepancy]:
    """Give how probable it is that each discrepancy shows, and how large it is; as of `_left`."""
    ground, of_discrepancy = judged.ground, judged.weighed.of_discrepancy()
    scatters = SCATTERS if ground.space.data.absolute.all() else SHOWS
    for one, least in ((ground.of_loads, scatters), (ground.of_time, SHOWS)):
        shown = DISCREPANCIES * np.sqrt(one.variance.sum() / judged.weighed.evidence.noise.dof)
        counted = of_discrepancy[ground.shared.numbers_of(one)] * ((shown >= least) & (size <= DISCREPANCIES))
        largest = float(shown[np.argmax(counted)])
        wanders = one is ground.of_time and len(one.runs) < len(ground.space.data.absolute)
        yield ShownDiscrepancy(wanders, float(counted.sum()), largest)


def _unlisted_in_place(
    judged: Judged,
    leader: str,
    sets: Mapping[Key, float],
    names: Mapping[Key, frozenset[str]],
    laws: Mapping[Key, frozenset[int]],
) -> float:
    """Return the largest probability of an unlisted law that shows, and can make half of what the leader makes.

    One that shows less than half of the noise next to the leader leaves its name as it is.

    Parameters
    ----------
    laws : the unlisted laws of each set.
    """
    key = max((key for key in sets if leader in names[key]), key=lambda k: sets[k])
    number = next(i for i in key if judged.members[i].name == leader)
    signal = _signal(judged, key, number)
    shown = {
        key: frozenset(i for i in own if _size_in(judged, key, i) >= SHOWS)
        for key, own in laws.items()
        if sets[key] > LEAST_LIKELY
    }
    probable = _sums(shown, sets)
    return max((p for i, p in probable.items() if p >= DOUBT and _share(judged, signal, i) >= SHARED), default=0.0)


def _size_of(judged: Judged, leader: str, sets: dict[Key, float], names: dict[Key, frozenset[str]]) -> float:
    """Return the rms over all readings of what a member makes in the most probable set with it, in noises."""
    key = max((key for key in sets if leader in names[key]), key=lambda k: sets[k])
    return _size_in(judged, key, next(i for i in key if judged.members[i].name == leader))


def _size_in(judged: Judged, key: Key, number: int) -> float:
    """Return the rms over all readings of what a member makes in a set, in noises."""
    coefficients = _signal(judged, key, number).coefficients
    return _rms(judged, judged.weighed.evidence.inner.own[number], coefficients)


def _present(judged: Judged, names: Mapping[Key, frozenset[str]]) -> Key:
    """Return the set of the effects that the model under test has, in the shapes that are best for it."""
    log = judged.weighed.log
    own = [key for key in names if names[key] == judged.model]
    if own:
        return max(own, key=lambda key: log[key])
    # a shape that ends as another does after a fit is in no set
    numbers = [number for number in range(len(judged.members)) if (number,) in log]
    shapes = [[number for number in numbers if judged.members[number].name == name] for name in judged.model]
    return tuple(sorted(max(each, key=lambda number: log[(number,)]) for each in shapes if each))


def _change(judged: Judged, key: Key, model: Key) -> float:
    """Return the rms over all readings by which two sets differ, in noises."""
    evidence = judged.weighed.evidence
    _, solution = evidence.coefficients(key)
    _, less = evidence.coefficients(model)
    both = sorted({*key, *model})
    change = [np.zeros(len(evidence.members[i].rows)) for i in both]
    for chosen, sign, values in ((key, 1.0, solution), (model, -1.0, less)):
        ends = np.cumsum([len(evidence.members[i].rows) for i in chosen])
        for i, own in zip(chosen, np.split(values, ends[:-1]), strict=False):
            change[both.index(i)] += sign * own
    return _rms(judged, evidence.inner.of_set(both).gram, np.concatenate([np.zeros(0), *change]))


def _rms(judged: Judged, gram: Floats, coefficients: Floats) -> float:
    """Return the rms over all readings, in noises, of columns with coefficients (q,); gram is (t, q, q)."""
    square = float(coefficients @ gram[judged.noise_number] @ coefficients)
    return float(np.sqrt(max(square, 0.0) / judged.weighed.evidence.noise.dof))

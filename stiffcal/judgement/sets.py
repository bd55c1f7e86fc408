"""The sets of members that are worth weighing, found from the best so far by adding, dropping and exchanging one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Progress, no_progress
from stiffcal.judgement.evidence import Key, SetEvidence
from stiffcal.judgement.members import Member
from stiffcal.judgement.numbers import (
    CLOSE,
    FEWER,
    MOST_EXPANDED,
    MOST_NEW_EFFECTS,
    MOST_NEW_LAWS,
    MOST_NEW_MISTAKES,
    MOST_NEW_ROWS,
    MOST_NEW_SETTINGS,
    MOST_NEW_SETUPS,
    OF_SINGLES,
    OUT_OF_REACH,
    WITHIN,
)
from stiffcal.judgement.priors import MemberKind

MOST_NEW = {
    MemberKind.EFFECT: MOST_NEW_EFFECTS,
    MemberKind.UNLISTED: MOST_NEW_LAWS,
    MemberKind.MISTAKE: MOST_NEW_MISTAKES,
    MemberKind.ROW: MOST_NEW_ROWS,
    MemberKind.SETUP: MOST_NEW_SETUPS,
    MemberKind.SETTING: MOST_NEW_SETTINGS,
}
"""Members of a set beyond those of the model: columns are straight lines, and next to what is large others bend."""


@dataclass
class WeighedSets:
    """Sets with the logarithm of evidence times prior odds."""

    members: Sequence[Member]
    """All of them."""
    evidence: SetEvidence
    """About one model."""
    log: dict[Key, float] = field(default_factory=dict)
    """Per set, members by number in order."""
    by_discrepancy: dict[Key, Floats] = field(default_factory=dict)
    """(t,) the same for each discrepancy."""
    beyond: dict[Key, float] = field(default_factory=dict)
    """Of enlarged sets the odds of one member more, of those that were not weighed, as far as they gain next to it."""
    best_normal: tuple[float, Floats] = (-np.inf, np.zeros(1))
    """Largest weight so far for normal noise, and (t,) what tails of the noise add to that."""

    def weigh(self, chosen: Iterable[int]) -> float:
        """Return the log weight of a set, found once."""
        key = tuple(sorted(chosen))
        if key not in self.log:
            (value, sizes), normal = self.evidence.best_sizes(key), self.of_normal_noise(key)
            if normal > self.best_normal[0] - OUT_OF_REACH:
                tails = self.evidence.tails(key, value, sizes)
            else:
                tails = self.best_normal[1]
            self.best_normal = max(self.best_normal, (normal, tails), key=lambda one: one[0])
            self.by_discrepancy[key] = self.evidence.over_cells(value + tails) + self._prior(key)
            self.log[key] = float(np.logaddexp.reduce(self.by_discrepancy[key]))
        return self.log[key]

    def of_normal_noise(self, key: Key) -> float:
        """Return the log weight of a set, members in order, for normal noise."""
        return self.evidence.normal(key) + self._prior(key)

    def _prior(self, key: Key) -> float:
        return float(sum(self.members[i].log_prior for i in key))

    @property
    def best(self) -> Key:
        """The set of the largest weight."""
        return max(self.log, key=lambda key: self.log[key])

    def probabilities(self) -> dict[Key, float]:
        """Return the probability of each set that was weighed, all others left out."""
        return normalised(self.log)

    @property
    def not_weighed(self) -> float:
        """Share that sets which were not weighed have of all, as far as members gain next to those that were.

        Sets that were not enlarged are taken to grow as the best one does.
        """
        p, best = self.probabilities(), self.best
        more = sum(value for key, value in p.items() if len(key) == len(best) + 1 and set(best) < set(key))
        growth = more / max(p[best], 1e-300) + self.beyond.get(best, 0.0)
        left = sum(value * self.beyond.get(key, growth) for key, value in p.items())
        return left / (1.0 + left)

    def given_discrepancy(self, numbers: Sequence[int]) -> dict[Key, float]:
        """Return the same where every hypothesis has one of some discrepancies of the grid, by their positions."""
        return normalised(
            {key: float(np.logaddexp.reduce(values[numbers])) for key, values in self.by_discrepancy.items()}
        )

    def of_discrepancy(self) -> Floats:
        """Return (t,) the probability of each discrepancy."""
        whole = np.logaddexp.reduce(np.array(list(self.by_discrepancy.values())), axis=0)
        return np.asarray(np.exp(whole - np.logaddexp.reduce(whole)))

    def may_join(self, number: int, chosen: Key) -> bool:
        """Return whether a member can be in a set with others: not in two shapes, nor with what it excludes."""
        new = self.members[number]
        return all(_together(new, self.members[i]) for i in chosen)


def normalised(log: Mapping[Key, float]) -> dict[Key, float]:
    """Return probabilities of sets from the logarithms of their weights."""
    values = np.array(list(log.values()))
    return dict(zip(log, np.exp(values - np.logaddexp.reduce(values)).tolist(), strict=True))


def _together(one: Member, other: Member) -> bool:
    if one.name == other.name:
        return False
    if one.candidate is None or other.candidate is None or one.candidate.place != other.candidate.place:
        return True
    a, b = one.candidate.effect, other.candidate.effect
    return not (a.name in (*b.excludes, *b.includes) or b.name in (*a.excludes, *a.includes))


def search_sets(
    members: Sequence[Member],
    evidence: SetEvidence,
    present: Key = (),
    most_off: int = MOST_NEW[MemberKind.MISTAKE],
    progress: Progress = no_progress,
) -> WeighedSets:
    """Weigh the empty set, all single members, and sets about the best ones.

    Parameters
    ----------
    present : members that the model about which columns are has already: of others a set has `MOST_NEW` at most.
    most_off : mistakes of runs in a set: most runs have to agree.
    progress : receives each member, and each set that is enlarged.
    """
    most = {**MOST_NEW, MemberKind.MISTAKE: min(most_off, MOST_NEW[MemberKind.MISTAKE])}
    found = WeighedSets(members, evidence)
    first: list[Key] = [(), *((number,) for number in range(len(members))), tuple(sorted(present))]
    first += [tuple(sorted(i for i in present if i != left)) for left in present]
    # the best first: of sets out of its reach the tails are not asked for
    for done, one in enumerate(sorted(first, key=found.of_normal_noise, reverse=True)):
        progress(f"comparing with the data: {done + 1} of {len(first)}", OF_SINGLES * done / len(first))
        found.weigh(one)
    expanded: set[Key] = {()}
    while len(expanded) < MOST_EXPANDED and (key := _next(found, expanded)) is not None:
        expanded.add(key)
        progress(f"comparing combinations: {len(found.log)}", 1.0 - (1.0 - OF_SINGLES) * FEWER ** len(expanded))
        able = [i for i in range(len(members)) if i not in key and _room(found, i, key, present, most)]
        for number in _most_promising(found, key, able):
            found.weigh((*key, number))
    return found


def _next(found: WeighedSets, expanded: set[Key]) -> Key | None:
    """Return the set to enlarge: the best, it without each of its members, then the nearest; None: enough."""
    best = found.best
    if best not in expanded:
        return best
    for left in best:
        key = tuple(i for i in best if i != left)
        if key not in expanded:
            found.weigh(key)
            return key
    near = [key for key, value in found.log.items() if key not in expanded and value > found.log[best] - WITHIN]
    return max(near, key=lambda k: found.log[k]) if near else None


def _room(found: WeighedSets, number: int, key: Key, present: Key, most: Mapping[MemberKind, int]) -> bool:
    """Return whether a set may have one member more."""
    kind = found.members[number].kind
    new = sum(found.members[i].kind is kind for i in key if i not in present)
    return new < most[kind] and found.may_join(number, key)


def _most_promising(found: WeighedSets, key: Key, able: Sequence[int]) -> list[int]:
    """Return those of some members that gain most next to a set, its own at their best sizes and discrepancy.

    What the others gain counts as not weighed.
    """
    gains = {i: value + found.members[i].log_prior for i, value in found.evidence.next_to(key, able).items()}
    ranked = sorted(able, key=lambda i: -gains[i])
    found.beyond[key] = float(np.exp(np.logaddexp.reduce([gains[i] for i in ranked[CLOSE:]], initial=-np.inf)))
    return ranked[:CLOSE]

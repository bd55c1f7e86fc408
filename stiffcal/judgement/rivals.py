"""The nearest rivals of the best set, each refitted on the balanced robot and weighed about its own fit.

About the fit of one set the others are straight lines from there: by what they bend they would be less probable than
they are, and thousands of readings make certainty of that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from stiffcal.identification.fit import Fit
from stiffcal.judgement.ground import Ground, columns_of
from stiffcal.judgement.members import Member
from stiffcal.judgement.priors import MemberKind, RobotScale
from stiffcal.judgement.sets import Key, WeighedSets
from stiffcal.model.no_balance import NoBalanceError

NEAR = 12.0
"""Nats behind the best set up to which a rival is refitted."""
MOST_REFITS = 8
"""Rivals that are refitted."""


def rivals_of(weighed: WeighedSets) -> list[tuple[int, int]]:
    """Return the nearest rivals: a member of the best set by number, and the effect in its place."""
    best, members = set(weighed.best), weighed.members
    top = weighed.log[weighed.best]
    found = []
    for key, value in weighed.log.items():
        left, new = best - set(key), set(key) - best
        if len(left) == len(new) == 1 and value > top - NEAR:
            old, other = left.pop(), new.pop()
            kinds = {members[old].kind, members[other].kind}
            if kinds == {MemberKind.EFFECT} and members[old].name != members[other].name:
                found.append((value, old, other))
    return [(old, other) for _, old, other in sorted(found, reverse=True)[:MOST_REFITS]]


def with_rivals_refitted(
    weighed: WeighedSets,
    scale: RobotScale,
    fitted: Callable[[list[Member]], Fit],
    ground_of: Callable[[Fit], Ground],
) -> WeighedSets:
    """Return the sets with what the nearest rivals gain about fits of their own.

    Parameters
    ----------
    scale : of the robot.
    fitted : fits the model with some members.
    ground_of : returns what members are compared about, under the weights of the best set.
    """
    best, gains = weighed.best, dict[tuple[int, int], float]()
    for old, other in rivals_of(weighed):
        key = tuple(sorted({*best, other} - {old}))
        try:
            fit = fitted([weighed.members[i] for i in key])
            gains[old, other] = _about_its_own(weighed, key, ground_of(fit), scale) - weighed.log[key]
        except (NoBalanceError, ArithmeticError, np.linalg.LinAlgError):
            continue
    changed = {key: sum(_gains_in(key, gains)) for key in weighed.log}
    return replace(
        weighed,
        log={key: value + changed[key] for key, value in weighed.log.items()},
        by_discrepancy={key: value + changed[key] for key, value in weighed.by_discrepancy.items()},
    )


def _gains_in(key: Key, gains: dict[tuple[int, int], float]) -> Iterator[float]:
    """Give what each rival in a set gains where that of the best set is not in it."""
    for (old, other), gain in gains.items():
        if other in key and old not in key:
            yield gain


def _about_its_own(weighed: WeighedSets, key: Key, ground: Ground, scale: RobotScale) -> float:
    """Return the log weight of a set about its own fit."""
    placed = {f"{one.effect.name} {one.place.label}": one for one in ground.present}
    columns = []
    for i in key:
        member = weighed.members[i]
        if member.kind is MemberKind.EFFECT:
            one = placed[member.name]
            regressor = ground.state.regressor(one.effect, one.place, one.shape())
            columns.append(columns_of(ground, regressor, scale))
        else:
            columns.append(member.columns)
    prior = sum(weighed.members[i].log_prior for i in key)
    return ground.evidence(columns).of_set(range(len(columns))) + prior

"""The nearest rivals of a set, each refitted on the balanced robot and weighed about its own fit.

About the fit of one set the others are straight lines from there: by what they bend they would be less probable than
they are, and thousands of readings make certainty of that. So each is weighed about its own fit, by the density of the
same readings: the wrench's noise acts with the slope of each model, in the weights and in their determinant.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeVar

import numpy as np

from stiffcal.errors import InputError
from stiffcal.judgement.evidence import Key, MemberColumns
from stiffcal.judgement.ground import Ground, columns_of
from stiffcal.judgement.members import Member, model_of
from stiffcal.judgement.numbers import MOST_REFITS, RIVALS_WITHIN
from stiffcal.judgement.priors import MemberKind, UsualSizes
from stiffcal.judgement.sets import WeighedSets
from stiffcal.judgement.settings_off import SettingOff
from stiffcal.judgement.shapes import log_share_of
from stiffcal.model.effect import ParameterRole

G = TypeVar("G", bound=Ground)

_EXPLAINED_OTHERWISE = (MemberKind.EFFECT, MemberKind.UNLISTED)

Rival = tuple[int, int | None]
"""A member of the set by number, and the effect in its place; None: it is left out."""


def rivals_of(weighed: WeighedSets, own: Key) -> list[Rival]:
    """Return the nearest rivals of the set about whose fit all are weighed, nearest first."""
    best, members = set(own), weighed.members
    top = weighed.log[weighed.best]
    found: list[tuple[float, Rival]] = []
    for key, value in weighed.log.items():
        left, new = best - set(key), set(key) - best
        if len(left) != 1 or len(new) > 1 or value < top - RIVALS_WITHIN:
            continue
        old, other = left.pop(), new.pop() if new else None
        law = members[old]
        if other is None:
            comparable = law.kind is MemberKind.EFFECT
        else:
            # what a law of no catalogue explains an effect may, once its shape and the forms of the others are fitted
            comparable = members[other].kind is MemberKind.EFFECT and law.kind in _EXPLAINED_OTHERWISE
            comparable &= law.name != members[other].name
        if comparable:
            found.append((value, (old, other)))
    return [rival for _, rival in sorted(found, key=lambda one: -one[0])[:MOST_REFITS]]


def bent_without(weighed: WeighedSets, own: Key) -> list[int]:
    """Return the effects of the set without which the others may explain all, in other shapes.

    Straight lines say nothing of that: a band of play that is refitted may be what a second slope stood for.
    """
    members = weighed.members
    effects = [i for i in own if members[i].kind is MemberKind.EFFECT]
    return [i for i in effects if any(_has_shape(members[k]) for k in effects if k != i)]


def _has_shape(member: Member) -> bool:
    """Return whether an effect has a shape that a fit changes."""
    effect = None if member.candidate is None else member.candidate.effect
    return effect is not None and any(
        spec.role is ParameterRole.NONLINEAR and not spec.discrete for spec in effect.parameters
    )


def no_setting(ground: Ground, setting: SettingOff) -> None:
    """Return the columns of a changed setting where nothing is set: none."""


def with_rivals_refitted(
    weighed: WeighedSets,
    own: Key,
    about: Ground,
    scale: UsualSizes,
    ground_of: Callable[[list[Member]], G],
    set_otherwise: Callable[[G, SettingOff], MemberColumns | None] = no_setting,
) -> WeighedSets:
    """Return the sets with what the nearest rivals gain about fits of their own.

    Parameters
    ----------
    own : the set about whose fit all are weighed. about : what they are weighed about.
    scale : of the robot.
    ground_of : fits the model with some members, runs that are off left out, and returns what members are compared
        about, with the noise of the best set carried through its own model.
    set_otherwise : returns the columns of a setting that is changed.
    """
    gains, refitted, again = dict[Rival, float](), set[tuple[frozenset[str], frozenset[int]]](), set[Key]()
    near = rivals_of(weighed, own)
    far = [(old, None) for old in bent_without(weighed, own) if (old, None) not in near]
    for old, other in (*near, *far):
        key = tuple(sorted((*_without(own, old), *([] if other is None else [other]))))
        members = [weighed.members[i] for i in key]
        model = model_of(members), frozenset(i for i in key if weighed.members[i].candidate is None)
        if model in refitted:
            again.add(key)
            continue
        try:
            there = ground_of(members)
            value = _about_own_fit(weighed, key, there, scale, set_otherwise)
        except (InputError, ArithmeticError, np.linalg.LinAlgError):
            continue
        gains[old, other] = value + there.log_weights - about.log_weights - weighed.weigh(key)
        refitted.add(model)
    # what the others gain in other shapes is theirs alone: one more effect may have stood for it on straight lines
    together = {_without(own, old): gains.pop((old, None), 0.0) for old, _ in far}
    # a fit ends in the same shape from any: the first stands for all
    changed = {key: together.get(key, 0.0) + _gain_of(key, gains) for key in weighed.log if key not in again}
    return replace(
        weighed,
        log={key: weighed.log[key] + change for key, change in changed.items()},
        by_discrepancy={key: weighed.by_discrepancy[key] + change for key, change in changed.items()},
    )


def _without(own: Key, old: int) -> Key:
    return tuple(i for i in own if i != old)


def _gain_of(key: Key, gains: Mapping[Rival, float]) -> float:
    """Return what a set gains: for each member of the set that it lacks what its own rival there gains."""
    total = 0.0
    for old in {old for old, _ in gains} - set(key):
        inside = [gain for (left, other), gain in gains.items() if left == old and other in key]
        total += sum(inside) if inside else gains.get((old, None), 0.0)
    return total


def _about_own_fit(
    weighed: WeighedSets,
    key: Key,
    ground: G,
    scale: UsualSizes,
    set_otherwise: Callable[[G, SettingOff], MemberColumns | None],
) -> float:
    """Return the log weight of a set about its own fit."""
    placed = {f"{one.effect.name} {one.place.label}": one for one in ground.present}
    columns = []
    prior = sum(weighed.members[i].log_prior for i in key)
    for i in key:
        member = weighed.members[i]
        if member.candidate is not None:
            # a spring may be part of a whole form of another law, which every hypothesis then has
            if (one := placed.get(member.name)) is None:
                continue
            prior += log_share_of(ground, member.candidate, one, scale) - member.log_share
            regressor = ground.state.regressor(one.effect, one.place, one.shape())
            columns.append(columns_of(ground, regressor, scale))
        elif member.setting is not None:
            columns.append(set_otherwise(ground, member.setting) or member.columns)
        else:
            columns.append(member.columns)
    return ground.evidence(columns).of_set(range(len(columns))) + prior

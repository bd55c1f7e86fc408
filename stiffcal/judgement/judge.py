"""One distribution over what may be missing from a model, whatever was measured, and what is read off it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Generic, NamedTuple, Protocol, Self, TypeVar

import numpy as np

from stiffcal.diagnosis.scans.drift import Drift
from stiffcal.diagnosis.scans.scan import KnownNoise
from stiffcal.errors import InputError, Progress, no_progress, part_of
from stiffcal.estimation.parameters import Parameter
from stiffcal.judgement.evidence import Key, SetEvidence
from stiffcal.judgement.ground import Ground
from stiffcal.judgement.members import Member, model_of, orders_of
from stiffcal.judgement.numbers import INSTEAD, MODELS, OF_CANDIDATES, SET_ASIDE, TO_JUDGE
from stiffcal.judgement.priors import COMMON, MemberKind
from stiffcal.judgement.rows_off import Off
from stiffcal.judgement.sets import WeighedSets, search_sets
from stiffcal.mistakes.states.mistake import StateMistake
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect


class JudgedFit(Protocol):
    """A fit of any kind of readings, as far as a judgement asks for it."""

    @property
    def robot(self) -> CompliantRobot:
        """The model with the estimated values."""

    @property
    def parameters(self) -> Sequence[Parameter]:
        """What was found of each parameter."""

    @property
    def noise(self) -> KnownNoise | None:
        """Of the readings; None where it is not known."""


@dataclass(frozen=True)
class Judged:
    """Sets of members with their probabilities about the best model."""

    weighed: WeighedSets
    """Of all sets."""
    fit: JudgedFit
    """Of the model with the best set, runs that are off left out."""
    ground: Ground
    """About which they were weighed."""
    chosen: frozenset[str]
    """Names of the effects with which the fit was made …"""
    own: Key
    """… and the set of them, with the unlisted laws of the best set."""
    rounds: int
    """Models about which members were compared."""
    model: frozenset[str] = frozenset()
    """Names of the effects of the model under test."""
    aside: Mapping[Off, float] = field(default_factory=dict)
    """Runs and states that took no part, as they are off, with the probability of that about the last model."""
    explained: Mapping[Off, tuple[str, ...]] = field(default_factory=dict)
    """Of these the effects that explained them nearly as well before they were set aside …"""
    mistakes: Mapping[Off, StateMistake] = field(default_factory=dict)
    """… and the mistake inside a run that is more probable than all else that may be wrong with it."""

    @property
    def louder(self) -> float:
        """Probability that `Ground.louder` scatters more than the other runs; 0 where none is compared."""
        ground = self.ground
        return float(self.weighed.of_discrepancy()[ground.shared.numbers_of(ground.louder)].sum())

    @property
    def noise_number(self) -> int:
        """Position in the grid of discrepancies of the most probable one at which all that is left is noise."""
        return max(self.ground.of_noise, key=lambda number: self.weighed.of_discrepancy()[number])

    @property
    def at_bound(self) -> bool:
        """Whether an effect of the best set ends at the largest size that it can have: it is not what is missing."""
        own = {(placed.effect.name, placed.place) for placed in self.ground.present}
        return any(
            parameter.at_bound
            and parameter.value is not None
            and np.isfinite(parameter.value)
            and parameter.value != parameter.spec.neutral
            for parameter in self.fit.parameters
            if (parameter.effect, parameter.place) in own
        )

    @cached_property
    def drift(self) -> Drift:
        """What the best model leaves in the course of runs."""
        return self.ground.drift

    @property
    def members(self) -> Sequence[Member]:
        """All members."""
        return self.weighed.members

    @property
    def best(self) -> list[Member]:
        """The members of the best set."""
        return [self.members[i] for i in self.weighed.best]

    @property
    def names_of_best(self) -> frozenset[str]:
        """Names of the effects in the best set."""
        return _names(self.best)

    @property
    def settled(self) -> bool:
        """Whether the best set about the last model is that model's."""
        return self.names_of_best == self.chosen


class AskedAgain(NamedTuple):
    """What was set aside, asked again about the last model."""

    probability: Mapping[Off, float]
    """That it is off."""
    mistakes: Mapping[Off, StateMistake]
    """As `Judged.mistakes`."""


F = TypeVar("F", bound=JudgedFit)


class JudgedReadings(ABC, Generic[F]):
    """What all models of one judgement share: readings of one kind, and what may be missing from a model of them."""

    def judged_effects(self, robot: CompliantRobot) -> list[PlacedEffect]:
        """Return the effects of a model that are judged like those that are not in it."""
        return [placed for placed in robot.placed if is_member(placed)]

    @abstractmethod
    def about(self, fit: F) -> Self:
        """Return it prepared with another fit: the robot is as large and as loaded as in the runs that took part."""

    @abstractmethod
    def without(self, names: frozenset[str]) -> Self:
        """Return it without some effects."""

    @abstractmethod
    def fit(self, chosen: Sequence[Member], aside: frozenset[Off]) -> F:
        """Return the fit of the model with some members; what is off takes no part.

        Raises
        ------
        InputError : there is no such model: the robot has no equilibrium, or the fit does not settle.
        """

    @abstractmethod
    def judged(self, fit: F, chosen: frozenset[str], number: int, progress: Progress = no_progress) -> Judged:
        """Weigh sets about a model."""

    @abstractmethod
    def with_rivals(self, judged: Judged, fit: F, aside: frozenset[Off]) -> Judged:
        """Return a judgement with the nearest rivals of its set refitted, what is off left out."""

    def next_to(self, fit: F) -> JudgedReadings[F]:
        """Return it with the noise that the readings show next to a model."""
        return self

    def asked_again(self, judged: Judged, fit: F, aside: frozenset[Off]) -> AskedAgain:
        """Return of all that was set aside how probable it is that it is off, about the last model, and how."""
        return AskedAgain({}, {})


def judge(campaign: JudgedReadings[F], fit: F, progress: Progress = no_progress) -> Judged:
    """Compare all sets of members that are worth it.

    Parameters
    ----------
    campaign : the readings. fit : of the present model to them.
    progress : receives a description of each step.
    """
    present = campaign.judged_effects(fit.robot)
    model = chosen = frozenset(name_of(placed) for placed in present)
    aside = frozenset[Off]()
    explained = dict[Off, tuple[str, ...]]()
    tried = {(orders_of((name_of(one), one.effect, one.values) for one in present), aside)}
    for number in range(1, MODELS + 1):
        within = part_of(progress, *(TO_JUDGE * (1.0 - 0.5**done) for done in (number - 1, number)))
        judged = replace(campaign.judged(fit, chosen, number, within), model=model)
        effects, without = _next_model(judged, aside)
        if (model_of(effects), without) in tried:
            judged = campaign.with_rivals(judged, fit, aside)
            effects, without = _next_model(judged, aside)
        if (model_of(effects), without) in tried:
            again = campaign.asked_again(judged, fit, aside)
            judged = replace(judged, aside=again.probability, mistakes=again.mistakes)
            without = frozenset(off for off, p in judged.aside.items() if p >= SET_ASIDE)
        if (model_of(effects), without) in tried:
            break
        explained |= {off: _instead_of(off, judged.weighed) for off in without - aside}
        try:
            fit = campaign.fit(effects, without)
        except (InputError, ArithmeticError):
            # a law without which, or with which, the robot has no equilibrium explains nothing
            new = _names(effects) - chosen
            if not new:
                break
            campaign = campaign.without(new)
            judged = replace(campaign.judged(fit, chosen, number, within), model=model)
            continue
        campaign = campaign.about(fit) if without != aside else campaign.next_to(fit)
        chosen, aside = _names(effects), without
        tried.add((model_of(effects), aside))
        if number < MODELS:
            # in a large campaign there is room for the columns about one model
            del judged, effects
    return replace(judged, explained=explained)


def weighed_about(
    members: Sequence[Member],
    evidence: SetEvidence,
    chosen: frozenset[str],
    most_off: int = 0,
    progress: Progress = no_progress,
) -> tuple[WeighedSets, Key]:
    """Return the sets about a model, and the set of what it has, with the unlisted laws of the best set.

    Parameters
    ----------
    members : all of them. evidence : of their columns. chosen : names of the effects with which the fit was made.
    most_off : mistakes of runs in a set. progress : of one model; from `OF_CANDIDATES` on.
    """
    start = tuple(
        i
        for i, one in enumerate(members)
        if len(one.columns.present) and (one.name in chosen or one.setting is not None)
    )
    weighed = search_sets(members, evidence, start, most_off, part_of(progress, OF_CANDIDATES, 1.0))
    unlisted = [i for i in weighed.best if members[i].kind is MemberKind.UNLISTED]
    own = tuple(sorted({*start, *unlisted}))
    weighed.weigh(own)
    return weighed, own


def _instead_of(off: Off, weighed: WeighedSets) -> tuple[str, ...]:
    """Return effects of which sets nearly as probable as the best have one in place of what is off."""
    members, best = weighed.members, set(weighed.best)
    top = weighed.log[weighed.best]
    names = {
        members[i].name: value
        for key, value in sorted(weighed.log.items(), key=lambda item: item[1])
        if value > top - INSTEAD and not any(off in members[i].off for i in key)
        for i in key
        if i not in best and members[i].kind is MemberKind.EFFECT
    }
    return tuple(sorted(names, key=lambda name: -names[name]))


def _next_model(judged: Judged, aside: frozenset[Off]) -> tuple[list[Member], frozenset[Off]]:
    """Return the effects of the model that is fitted next, and the runs that take no part in it.

    A run in another unit spoils the fit that all columns are about, and what was prepared with it is of another robot:
    it is set aside first, and effects are compared anew.
    """
    off = {off for one in judged.best for off in one.off}
    effects = [
        one
        for one in judged.best
        if one.kind is MemberKind.SETTING or (one.kind is MemberKind.EFFECT and (not off or one.name in judged.chosen))
    ]
    return effects, aside | off


def _names(members: Sequence[Member]) -> frozenset[str]:
    """Return the names of the effects among members."""
    return frozenset(one.name for one in members if one.kind is MemberKind.EFFECT)


def is_member(placed: PlacedEffect) -> bool:
    """Return whether an effect of the model under test is judged like those that are not in it."""
    return placed.effect.name not in COMMON and not placed.effect.general


def name_of(placed: PlacedEffect) -> str:
    """Return ``effect place``."""
    return f"{placed.effect.name} {placed.place.label}"

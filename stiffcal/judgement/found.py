"""What is read off a distribution as an answer: effects to add, those that the model has, and those it has for nothing.

Which effects are missing is read off the distribution over sets. The held-out error, which a person watches falling,
chooses nothing: it is found afterwards, for the present model with each candidate and with all that is missing.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from stiffcal.diagnosis.answers.results import UntestableEffect
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.diagnosis.scans.explained import Explained, explained_share
from stiffcal.diagnosis.scans.lack_of_fit import LackOfFit, lack_of_fit
from stiffcal.diagnosis.scans.scan import Scan, Trial
from stiffcal.judgement.excluded import ExcludedSize, excluded_sizes
from stiffcal.judgement.forms import replaced
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.numbers import ALTERNATIVES, NAMED
from stiffcal.judgement.priors import MemberKind
from stiffcal.judgement.reading import AlikeEffects, WhatIsMissing
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect


@dataclass(frozen=True)
class FoundEffect:
    """An effect to add."""

    candidate: Candidate
    """The most probable effect of its group …"""
    shape: Mapping[str, float]
    """… with the values of its shape parameters in the best set."""
    alternatives: tuple[tuple[Candidate, float], ...]
    """The others with their probabilities, given that one of the group is missing; largest first."""
    group: AlikeEffects
    """Effects of which one is missing."""
    share: float
    """Probability of the effect, given that one of the group is missing."""
    form: Mapping[str, float] = field(default_factory=dict)
    """Values by symbol of the form of the law that fits best; empty where it is the catalogue's."""

    @property
    def decided(self) -> bool:
        """Whether it is more probable than all others of its group together: of two that may both be there none is."""
        return self.share >= sum(share for name, share in self.group.members if name != self.candidate.name)


@dataclass(frozen=True)
class Diagnosed(ABC):
    """What is missing from a model of readings of one kind."""

    judged: Judged
    """The distribution over sets."""
    reading: WhatIsMissing
    """What it says."""
    first: Scan
    """The present model, with each effect at each place as an addition; without what is off."""
    last: Scan
    """The same data with all that is missing in the model; the same scan where nothing is."""
    found: tuple[FoundEffect, ...]
    """Effects to add, the largest first."""
    held: tuple[FoundEffect, ...]
    """Effects that the model has and that are there, the largest first."""
    superfluous: tuple[PlacedEffect, ...]
    """Effects of the model that are probably not there."""
    not_tried: tuple[UntestableEffect, ...]
    """Effects that these data cannot test."""
    seconds: float
    """Spent on all of it."""

    @property
    @abstractmethod
    def measured_in(self) -> str:
        """By what something would show, in words: "poses and loads"."""

    @property
    @abstractmethod
    def more(self) -> str:
        """Of what more would decide, in words: "poses"."""

    @property
    @abstractmethod
    def differ_between(self) -> str:
        """Between what readings that follow no law differ, in words: "pose to pose"."""

    @abstractmethod
    def run_in_words(self, run: int) -> str:
        """Return a run by its number, in words."""

    @property
    def noise_known(self) -> bool:
        """Whether the noise is known, and so what adequate means."""
        return self.first.fit.noise is not None

    @property
    def adequate(self) -> bool | None:
        """Whether what is left is noise; None where the noise is not known, and where too little shows that it is."""
        if not self.noise_known:
            return None
        if self.found or self.reading.settings or self.reading.unexplained or self.reading.p_nothing < NAMED:
            return False
        return True if self.reading.adequate else None

    @property
    def unexplained(self) -> bool | None:
        """Whether something is left that no effect explains; None where nothing shows it and no noise is known."""
        return self.reading.unexplained or (False if self.noise_known else None)

    @cached_property
    def before(self) -> LackOfFit | None:
        """The present model's residuals against the noise; None where it is not known."""
        return lack_of_fit(self.first.fit, self.first)

    @cached_property
    def after(self) -> LackOfFit | None:
        """The same with all that is missing."""
        return lack_of_fit(self.last.fit, self.last)

    @cached_property
    def explained(self) -> Explained | None:
        """Share of the avoidable error that goes with what is missing; None where nothing is."""
        if not self.found and not self.reading.settings:
            return None
        return explained_share(self.first, self.last, self.before_in_last_noise, self.after)

    @property
    def before_in_last_noise(self) -> LackOfFit | None:
        """The present model's residuals against the noise of the last: what is missing swells that of its own."""
        return self.before

    @cached_property
    def excluded(self) -> tuple[ExcludedSize, ...]:
        """How large something would have been found, place by place."""
        return excluded_sizes(self.judged)

    @property
    def n_members(self) -> tuple[int, int]:
        """Number of effects at places that were compared, and of these with every shape."""
        effects = [one for one in self.judged.members if one.kind is MemberKind.EFFECT]
        return len({one.name for one in effects}), len(effects)

    def trial_of(self, candidate: Candidate) -> Trial | None:
        """Return a candidate as an addition to the present model; None where it does not show there."""
        return next((trial for trial in self.first.trials if trial.candidate.name == candidate.name), None)


def named_effects(judged: Judged, reading: WhatIsMissing, catalogue: Mapping[str, Effect]) -> tuple[FoundEffect, ...]:
    """Return the leading effects of all groups, the largest first."""
    candidates = {one.name: one.candidate for one in judged.members if one.candidate is not None}
    found = []
    for group in reading.groups:
        effects = [(name, share) for name, share in group.members if name in candidates]
        if not effects or group.effects < NAMED:
            # a mistake of the data is more probable: that is among the suspects
            continue
        lacking = group.next_to_model >= NAMED
        (leader, share), *others = _what_the_model_has_first(effects, judged.model, lacking)
        if not lacking and leader not in judged.model:
            # it is there in the place of effects of the model that together make the same
            continue
        alternatives = tuple((candidates[name], p) for name, p in _as_far_as_needed(share, others))
        candidate, shape = candidates[leader], _shape_of(judged, leader)
        usual = catalogue[candidate.effect.name].at(candidate.place, judged.fit.robot.chain)
        form = {} if candidate.effect.parameters == usual.parameters else shape
        found.append(FoundEffect(candidate, shape, alternatives, group, share, form))
    return tuple(sorted(found, key=lambda one: -one.group.size))


def with_all(robot: CompliantRobot, added: Sequence[FoundEffect], best: CompliantRobot) -> CompliantRobot:
    """Return the present model with what is missing, in the form and from the values of the best model."""
    held = {(placed.effect.name, placed.place): placed for placed in best.placed}
    for one in added:
        effect, place = one.candidate.effect, one.candidate.place
        new = held.get((effect.name, place), PlacedEffect(effect, place, dict(one.shape)))
        robot = replaced(robot, new)
    return robot


def _shape_of(judged: Judged, name: str) -> Mapping[str, float]:
    """Return the shape that a member has in the most probable set with it."""
    log, members = judged.weighed.log, judged.members
    key = max((key for key in log if any(members[i].name == name for i in key)), key=lambda key: log[key])
    return next(members[i].shape for i in key if members[i].name == name)


def _as_far_as_needed(reached: float, others: Sequence[tuple[str, float]]) -> list[tuple[str, float]]:
    """Return the first of the others, until they and the leader together have `ALTERNATIVES` of the group."""
    listed = []
    for name, share in others:
        if reached >= ALTERNATIVES:
            break
        listed.append((name, share))
        reached += share
    return listed


def _what_the_model_has_first(
    effects: Sequence[tuple[str, float]], model: Collection[str], lacking: bool
) -> Sequence[tuple[str, float]]:
    """Return a group with an effect of the model in front where nothing distinguishes it from the most probable one.

    The model lacks nothing then: adding the other would make the one that it has superfluous. So it is where the others
    are not probable next to all that the model has.
    """
    (_, share), *others = effects
    near = (effects[0], *_as_far_as_needed(share, others)) if lacking else effects
    own = [one for one in near if one[0] in model][:1]
    return [*own, *(one for one in effects if one not in own)]


def superfluous_effects(judged: Judged, reading: WhatIsMissing, robot: CompliantRobot) -> tuple[PlacedEffect, ...]:
    """Return effects of the model that are probably not there, nor one that is alike and not in the model either."""
    held = {f"{placed.effect.name} {placed.place.label}": placed for placed in robot.placed}
    lacking = [group for group in reading.groups if group.members[0][0] not in judged.model]
    groups = [{name for name, _ in group.members} for group in lacking]
    unneeded = [
        name
        for name in judged.model
        if reading.probability.get(name, 0.0) < NAMED and not any(name in group for group in groups)
    ]
    return tuple(held[name] for name in sorted(unneeded) if name in held)

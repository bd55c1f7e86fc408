"""One distribution over what may be missing from a model of load states, and what is read off it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.candidates import Candidate, list_candidates
from stiffcal.diagnosis.geometry_nuisance import GeometryNuisance
from stiffcal.identification.fit import Fit
from stiffcal.identification.identify import Settings, fit_observations, fit_problem
from stiffcal.identification.noise import Noise
from stiffcal.identification.observation import Observations
from stiffcal.identification.regressors import Linearised
from stiffcal.identification.weights import residual_noise
from stiffcal.judgement.discrepancy import Discrepancy, LouderRun
from stiffcal.judgement.evidence import NoiseScale
from stiffcal.judgement.ground import Ground, columns_of
from stiffcal.judgement.members import Member, list_members, off_columns, unlisted_columns
from stiffcal.judgement.priors import (
    ALONE,
    COMMON,
    DISCREPANCIES,
    DOUBTED_RUN,
    OF_LOADS,
    OF_TIME,
    STATED_NOISE_DOF,
    MemberKind,
    RobotScale,
    log_odds_of_doubt,
)
from stiffcal.judgement.rivals import with_rivals_refitted
from stiffcal.judgement.rows_off import Off, off_mask, rows_off
from stiffcal.judgement.sets import Key, WeighedSets, search_sets
from stiffcal.judgement.settings_off import settings_off
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.unlisted import UnlistedLaw, unlisted_laws
from stiffcal.judgement.weight import WeightOfLinks, shown
from stiffcal.judgement.within_run import mistakes_in_runs
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, ParameterRole, Place
from stiffcal.model.no_balance import NoBalanceError

ROUNDS = 6
"""Models about which the members are compared, at most."""
SET_ASIDE = 0.5
"""Probability of being off from which on a run takes no part."""


@dataclass(frozen=True)
class Judged:
    """Sets of members with their probabilities about the best model."""

    weighed: WeighedSets
    """Of all sets."""
    fit: Fit
    """Of the model with the best set, runs that are off left out."""
    ground: Ground
    """About which they were weighed."""
    chosen: frozenset[str]
    """Names of the effects with which the fit was made …"""
    own: Key
    """… and the set of them, with the unlisted laws of the best set."""
    rounds: int
    """Models about which members were compared."""
    aside: Mapping[Off, float] = field(default_factory=dict)
    """Runs and states that took no part, as they are off, with the probability of that about the last model."""

    @property
    def louder(self) -> float:
        """Probability that `Ground.louder` scatters more than the other runs; 0 where none is compared."""
        return float(self.weighed.of_discrepancy()[1 + 2 * len(DISCREPANCIES) :].sum())

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


def judge_states(
    states: LoadStates, robot: CompliantRobot, catalogue: Mapping[str, Effect], settings: Settings | None = None
) -> Judged:
    """Compare all sets of members that are worth it.

    Parameters
    ----------
    states : the campaign's load states.
    robot : the present model, with or without values.
    catalogue : effects by name.
    """
    settings = settings or Settings()
    fit = fit_observations(fit_problem(states, robot), robot, settings)
    campaign = _Campaign.of(states, robot, fit, catalogue, settings)
    chosen = frozenset(_name_of(placed) for placed in fit.robot.placed if _is_member(placed))
    aside = frozenset[Off]()
    tried = {(chosen, aside)}
    for number in range(1, ROUNDS + 1):
        judged = campaign.judged(fit, chosen, number)
        effects, without = _next_model(judged, aside)
        if (_names(effects), without) in tried:
            judged = campaign.with_rivals(judged, aside)
            effects, without = _next_model(judged, aside)
        if (_names(effects), without) in tried:
            judged = replace(judged, aside=campaign.asked_again(judged, aside))
            without = frozenset(off for off, p in judged.aside.items() if p >= SET_ASIDE)
        if (_names(effects), without) in tried:
            break
        try:
            fit = campaign.fit(effects, without)
        except (NoBalanceError, ArithmeticError):
            break
        if without != aside:
            campaign = _Campaign.of(states, robot, fit, catalogue, settings)
        chosen, aside = _names(effects), without
        tried.add((chosen, aside))
    return judged


def _next_model(judged: Judged, aside: frozenset[Off]) -> tuple[list[Member], frozenset[Off]]:
    """Return the effects of the model that is fitted next, and the runs that take no part in it.

    A run in another unit spoils the fit that all columns are about, and what was prepared with it is of another robot:
    it is set aside first, and effects are compared anew.
    """
    off = {off for one in judged.best for off in one.off}
    effects = [one for one in judged.best if one.kind is MemberKind.EFFECT and (not off or one.name in judged.chosen)]
    return effects, aside | off


def _names(members: Sequence[Member]) -> frozenset[str]:
    """Return the names of the effects among members."""
    return frozenset(one.name for one in members if one.kind is MemberKind.EFFECT)


def _is_member(placed: PlacedEffect) -> bool:
    """Return whether an effect of the model under test is judged like those that are not in it."""
    return placed.effect.name not in COMMON and not placed.effect.general


def _name_of(placed: PlacedEffect) -> str:
    return f"{placed.effect.name} {placed.place.label}"


def _noise_of(fit: Fit) -> Noise:
    """Return the noise of a fit; where none is known, the residuals' own size by kind of row."""
    return fit.noise or residual_noise(fit.data, fit.predicted)


@dataclass(frozen=True)
class _Campaign:
    """What all models of one judgement share."""

    states: LoadStates
    """The load states."""
    model: CompliantRobot
    """The present model: readings are of its kinematics."""
    data: Observations
    """Of all runs that take part, as rows."""
    springs: CompliantRobot
    """What every hypothesis has."""
    candidates: Sequence[Candidate]
    """Effects of the catalogue at their places."""
    scale: RobotScale
    """How soft and how loaded the robot is."""
    geometry: GeometryNuisance | None
    """Errors of its geometry."""
    weight: WeightOfLinks
    """What the links weigh beyond what is stated."""
    settings: Settings
    """How fits are made."""

    @classmethod
    def of(
        cls,
        states: LoadStates,
        model: CompliantRobot,
        fit: Fit,
        catalogue: Mapping[str, Effect],
        settings: Settings,
    ) -> _Campaign:
        """Prepare, with the fit of a model: the robot is as large and as loaded as in the runs that took part in it."""
        springs = replace(fit.robot, placed=tuple(placed for placed in fit.robot.placed if not _is_member(placed)))
        candidates, _ = list_candidates(springs, states, catalogue)
        scale = RobotScale.of(fit.robot, Linearised.about(fit.robot, fit.data).loads)
        geometry, weight = GeometryNuisance.of(states, fit), WeightOfLinks.of(fit.robot, fit.data)
        return cls(states, model, fit.data, springs, candidates, scale, geometry, weight, settings)

    def fit(self, chosen: Sequence[Member], aside: frozenset[Off]) -> Fit:
        """Return the fit of the model with some effects; runs that are off take no part."""
        added = tuple(
            PlacedEffect(one.candidate.effect, one.candidate.place, dict(one.shape))
            for one in chosen
            if one.candidate is not None
        )
        robot = replace(self.springs, placed=(*self.springs.placed, *added))
        kept = ~off_mask(self.states.run, np.arange(len(self.states)), aside) if aside else None
        return fit_observations(fit_problem(self.states, self.model, kept), robot, self.settings)

    def with_rivals(self, judged: Judged, aside: frozenset[Off]) -> Judged:
        """Return a judgement with the nearest rivals of its set refitted, what is off left out."""
        noise = _noise_of(judged.fit)
        weighed = with_rivals_refitted(
            judged.weighed,
            judged.own,
            self.scale,
            lambda members: self.fit(members, aside),
            lambda rival: self.ground(rival, noise, self.data),
        )
        return replace(judged, weighed=weighed)

    def asked_again(self, judged: Judged, aside: frozenset[Off]) -> dict[Off, float]:
        """Return of each run and state that was set aside the probability that it is off, about the last model."""
        if not aside:
            return {}
        fit = judged.fit
        everything = fit_problem(self.states, self.model).data
        ground = self.ground(fit, _noise_of(fit), everything)
        laws = {law.place + ": " + law.follows: law for law in unlisted_laws(ground.state)}
        columns = [
            columns_of(ground, ground.state.regressor(one.effect, one.place, one.shape()), self.scale)
            for one in ground.present
        ]
        columns += [unlisted_columns(ground, laws[one.name].columns) for one in judged.best if one.name in laws]
        off = [(Off(run), off_columns(rows), 0.0) for run, rows in ground.runs_off() if Off(run) in aside]
        states = frozenset(one.state for one in aside if one.state is not None)
        off += [(one, off_columns(rows, ALONE), 0.0) for one, rows in rows_off(ground, states)]
        usual = range(len(columns) + len(off))
        off += [
            (Off(one.run), off_columns(one.rows), one.log_share)
            for one in mistakes_in_runs(ground)
            if Off(one.run) in aside
        ]
        evidence = ground.evidence([*columns, *(rows for _, rows, _ in off)])
        log_odds = dict[Off, float]()
        for number, (one, _, share) in enumerate(off, start=len(columns)):
            sound = [i for i in usual if i < len(columns) or off[i - len(columns)][0] != one]
            gain = evidence.of_set([*sound, number]) - evidence.of_set(sound)
            odds = gain + share + log_odds_of_doubt(one.state is not None)
            log_odds[one] = float(np.logaddexp(log_odds.get(one, -np.inf), odds))
        return {one: float(1.0 / (1.0 + np.exp(-np.clip(odds, -500.0, 500.0)))) for one, odds in log_odds.items()}

    def judged(self, fit: Fit, chosen: frozenset[str], number: int) -> Judged:
        """Weigh sets about a model."""
        ground = self.ground(fit, _noise_of(fit), self.data)
        weights = dict(self.weight.of_links) if self.springs.chain.masses_known else {}
        # who states a tool has not forgotten it: what its link lacks is then a law like those of the others
        of_tool = None if self.data.setup.tool_mass else weights.pop(self.springs.chain.link_names[-1], None)
        laws = [*unlisted_laws(ground.state), *(UnlistedLaw(f"link {a}", "weight", b) for a, b in weights.items())]
        settings = settings_off(ground, fit, of_tool, self.scale)
        members = list_members(ground, self.candidates, self.scale, laws, settings)
        start = tuple(i for i, one in enumerate(members) if one.name in chosen and len(one.columns.present))
        weighed = search_sets(members, ground.evidence([one.columns for one in members]), start)
        unlisted = [i for i in weighed.best if members[i].kind is MemberKind.UNLISTED]
        own = tuple(sorted({*start, *unlisted}))
        weighed.weigh(own)
        return Judged(weighed, fit, ground, chosen, own, number)

    def ground(self, fit: Fit, noise: Noise, data: Observations) -> Ground:
        """Return what members are compared about: a fit, what it has beyond the springs as members.

        Parameters
        ----------
        data : of all runs that take part, as they were read; or of all, where errors of geometry and weight stay out.
        """
        state = Linearised.about(fit.robot, data)
        about = fit.linearised(noise, state, data)
        own = [(placed.effect.name, placed.place) for placed in self.springs.placed]
        present = tuple(one for one in fit.robot.placed if (one.effect.name, one.place) not in own)
        common = [k for k, column in enumerate(about.columns) if fit.robot.placed[column.placed] not in present]
        columns, prior = about.derivative[common], _prior_of(about.prior, common)
        nuisance = []
        if self.geometry is not None and data is self.data:
            nuisance.append(self.geometry.directions(about.space, columns))
        if not fit.robot.chain.masses_known and data is self.data:
            nuisance.append(shown(self.weight.unknown(self.scale), about.space))
        p, q = len(columns), sum(len(part) for part in nuisance)
        columns = np.concatenate([columns, *nuisance])
        prior = np.insert(prior, [p] * q, 0.0, axis=1)
        prior = np.concatenate([prior, np.eye(q, p + q + 1, p)])
        derivative: dict[tuple[str, Place], dict[str, Floats]] = defaultdict(dict)
        for column, change in zip(about.columns, about.derivative, strict=True):
            placed = fit.robot.placed[column.placed]
            if placed in present and column.role is not ParameterRole.NONLINEAR:
                derivative[placed.effect.name, placed.place][column.symbol] = change
        space = about.space
        stated = fit.noise is not None and fit.noise.source == "manifest"
        scale = NoiseScale(float(about.dof - len(common)), STATED_NOISE_DOF if stated else 0.0)
        of_loads, of_time = Discrepancy.of_loads(space), Discrepancy.of_time(space)
        louder = LouderRun.of(space, space.rows(about.residual[None])[0])
        kinds: list[tuple[Discrepancy | LouderRun, float]] = [(of_loads, OF_LOADS), (of_time, OF_TIME)]
        if louder is not None:
            kinds.append((louder, DOUBTED_RUN))
        shared = Shared(space.rows(columns), prior, kinds)
        return Ground(state, space, shared, about.residual, present, derivative, of_loads, of_time, louder, scale)


def _prior_of(prior: Floats, chosen: Sequence[int]) -> Floats:
    """Return the rows (r, p + 1) of what is known before that are of chosen parameters alone, as rows of these."""
    kept = [row for row in prior if not np.delete(row[:-1], chosen).any()]
    return np.array([[*row[:-1][chosen], row[-1]] for row in kept]).reshape(-1, len(chosen) + 1)

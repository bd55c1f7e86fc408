"""One distribution over what may be missing from a model of load states, and what is read off it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.candidates import Candidate, list_candidates
from stiffcal.diagnosis.geometry_nuisance import GeometryNuisance
from stiffcal.identification.fit import Fit
from stiffcal.identification.identify import Settings, fit_observations, fit_problem
from stiffcal.identification.noise import Noise
from stiffcal.identification.observation import Observations
from stiffcal.identification.readings import WrenchCorrection
from stiffcal.identification.regressors import Linearised
from stiffcal.identification.weights import residual_noise
from stiffcal.judgement.discrepancy import Discrepancy
from stiffcal.judgement.evidence import NoiseScale, Shared
from stiffcal.judgement.ground import Ground
from stiffcal.judgement.members import Member, list_members
from stiffcal.judgement.priors import JOINT_SPRING, OF_LOADS, OF_TIME, STATED_NOISE_DOF, MemberKind, RobotScale
from stiffcal.judgement.rivals import with_rivals_refitted
from stiffcal.judgement.sets import Key, WeighedSets, search_sets
from stiffcal.judgement.unlisted import UnlistedLaw, unlisted_laws
from stiffcal.judgement.weight import WeightOfLinks, shown
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, ParameterRole, Place
from stiffcal.model.no_balance import NoBalanceError

ROUNDS = 6
"""Models about which the members are compared, at most."""


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
    """Names of the effects and runs with which the fit was made …"""
    own: Key
    """… and the set of them, with the unlisted laws of the best set."""
    rounds: int
    """Models about which members were compared."""

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
        """Names of the effects and runs in the best set."""
        return frozenset(one.name for one in self.best if one.kind is not MemberKind.UNLISTED)

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
    problem = fit_problem(states, robot)
    fit = fit_observations(problem, robot, settings or Settings())
    campaign = _Campaign.of(states, problem.data, fit, catalogue, settings or Settings())
    chosen = frozenset(_name_of(placed) for placed in fit.robot.placed if _is_member(placed))
    tried = {chosen}
    for number in range(1, ROUNDS + 1):
        judged = campaign.judged(fit, chosen, number)
        if judged.names_of_best in tried:
            noise = _noise_of(fit)
            weighed = with_rivals_refitted(
                judged.weighed,
                judged.own,
                campaign.scale,
                campaign.fit,
                lambda rival: campaign.ground(rival, noise),  # noqa: B023
            )
            judged = replace(judged, weighed=weighed)
        best = judged.names_of_best
        if best in tried:
            break
        try:
            fit, chosen = campaign.fit(judged.best), best
        except (NoBalanceError, ArithmeticError):
            break
        tried.add(best)
    return judged


def _is_member(placed: PlacedEffect) -> bool:
    """Return whether an effect of the model under test is judged like those that are not in it."""
    return placed.effect.name != JOINT_SPRING and not placed.effect.general


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
    data: Observations
    """All of them, as rows, as they were read."""
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
        cls, states: LoadStates, data: Observations, fit: Fit, catalogue: Mapping[str, Effect], settings: Settings
    ) -> _Campaign:
        """Prepare, with the fit of the model under test."""
        springs = replace(fit.robot, placed=tuple(placed for placed in fit.robot.placed if not _is_member(placed)))
        candidates, _ = list_candidates(springs, states, catalogue)
        scale = RobotScale.of(fit.robot, Linearised.about(fit.robot, data).loads)
        geometry, weight = GeometryNuisance.of(states, fit), WeightOfLinks.of(fit.robot, data)
        return cls(states, data, springs, candidates, scale, geometry, weight, settings)

    def fit(self, chosen: Sequence[Member]) -> Fit:
        """Return the fit of the model with some members; runs that are off take no part."""
        added = tuple(
            PlacedEffect(one.candidate.effect, one.candidate.place, dict(one.shape))
            for one in chosen
            if one.candidate is not None
        )
        robot = replace(self.springs, placed=(*self.springs.placed, *added))
        off = [one.run for one in chosen if one.run is not None]
        problem = fit_problem(self.states, robot, ~np.isin(self.states.run, off) if off else None)
        return fit_observations(problem, robot, self.settings)

    def judged(self, fit: Fit, chosen: frozenset[str], number: int) -> Judged:
        """Weigh sets about a model."""
        ground = self.ground(fit, _noise_of(fit))
        members = list_members(ground, self.candidates, self.scale, self._unlisted(ground))
        start = tuple(
            i
            for i, one in enumerate(members)
            if one.name in chosen and (one.run is not None or len(one.columns.present))
        )
        weighed = search_sets(members, ground.evidence([one.columns for one in members]), start)
        unlisted = [i for i in weighed.best if members[i].kind is MemberKind.UNLISTED]
        own = tuple(sorted({*start, *unlisted}))
        weighed.weigh(own)
        return Judged(weighed, fit, ground, chosen, own, number)

    def _unlisted(self, ground: Ground) -> list[UnlistedLaw]:
        """Return the laws that nobody has written down; the weight of a robot without masses every hypothesis has."""
        laws = list(unlisted_laws(ground.state))
        if self.springs.chain.masses_known:
            laws += [UnlistedLaw(f"link {link}", "weight", columns) for link, columns in self.weight.of_links]
        return laws

    def ground(self, fit: Fit, noise: Noise) -> Ground:
        """Return what members are compared about: a fit, what it has beyond the springs as members."""
        data = _all_corrected(self.data, fit.data)
        state = Linearised.about(fit.robot, data)
        about = fit.linearised(noise, state, data)
        own = [(placed.effect.name, placed.place) for placed in self.springs.placed]
        present = tuple(one for one in fit.robot.placed if (one.effect.name, one.place) not in own)
        common = [k for k, column in enumerate(about.columns) if fit.robot.placed[column.placed] not in present]
        columns, prior = about.derivative[common], _prior_of(about.prior, common)
        nuisance = [] if self.geometry is None else [self.geometry.directions(about.space, columns)]
        if not fit.robot.chain.masses_known:
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
        shared = Shared(space.rows(columns), prior, ((of_loads, OF_LOADS), (of_time, OF_TIME)))
        return Ground(state, space, shared, about.residual, present, derivative, of_loads, of_time, scale)


def _all_corrected(data: Observations, fitted: Observations) -> Observations:
    """Return all readings with wrenches where a fit has them; those that took no part in it as they were read."""
    own = fitted.correction
    if own is None:
        return data
    took_part = np.isin(data.run, fitted.run)
    whole = WrenchCorrection(
        np.zeros_like(data.wrench), np.zeros_like(data.measured), np.zeros_like(data.wrench), np.ones(data.n_states)
    )
    whole.wrench[:, took_part], whole.rows[:, took_part] = own.wrench, own.rows
    return data.corrected(whole)


def _prior_of(prior: Floats, chosen: Sequence[int]) -> Floats:
    """Return the rows (r, p + 1) of what is known before that are of chosen parameters alone, as rows of these."""
    kept = [row for row in prior if not np.delete(row[:-1], chosen).any()]
    return np.array([[*row[:-1][chosen], row[-1]] for row in kept]).reshape(-1, len(chosen) + 1)

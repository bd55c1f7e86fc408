"""One distribution over what may be missing from a model of load states, and what is read off it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.candidates import Candidate, list_candidates
from stiffcal.diagnosis.geometry_nuisance import GeometryNuisance
from stiffcal.diagnosis.load_scan import weights_of
from stiffcal.identification.fit import Fit
from stiffcal.identification.identify import Settings, fit_observations, fit_problem
from stiffcal.identification.noise import Whitening
from stiffcal.identification.regressors import Linearised
from stiffcal.judgement.discrepancy import Discrepancy
from stiffcal.judgement.evidence import NoiseScale
from stiffcal.judgement.ground import Ground
from stiffcal.judgement.members import Member, list_members
from stiffcal.judgement.priors import JOINT_SPRING, STATED_NOISE_DOF, MemberKind, RobotScale
from stiffcal.judgement.rivals import with_rivals_refitted
from stiffcal.judgement.sets import WeighedSets, search_sets
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
    """Of the model with the best set."""
    ground: Ground
    """About which they were weighed."""
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
    def best(self) -> list[Member]:
        """The members of the best set."""
        return [self.members[i] for i in self.weighed.best]

    @property
    def names_of_best(self) -> frozenset[str]:
        """Names of the effects in the best set."""
        return frozenset(one.name for one in self.best if one.kind is MemberKind.EFFECT)

    @property
    def settled(self) -> bool:
        """Whether the best set about the last model is that model's."""
        present = {f"{placed.effect.name} {placed.place.label}" for placed in self.ground.present}
        return self.names_of_best == present

    @property
    def members(self) -> Sequence[Member]:
        """All members."""
        return self.weighed.members


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
    problem = fit_problem(states, robot)
    fit = fit_observations(problem, robot, settings)
    springs = replace(fit.robot, placed=tuple(placed for placed in fit.robot.placed if not _is_member(placed)))
    candidates, _ = list_candidates(springs, states, catalogue)
    scale = RobotScale.of(fit.robot, Linearised.about(fit.robot, problem.data).loads)
    geometry = GeometryNuisance.of(states, fit)
    own = tuple((placed.effect.name, placed.place) for placed in springs.placed)
    chosen = frozenset(f"{p.effect.name} {p.place.label}" for p in fit.robot.placed if _is_member(p))
    tried = {chosen}
    for number in range(1, ROUNDS + 1):
        judged = _judged(_ground(fit, own, geometry, weights_of(fit)), fit, candidates, scale, number)
        if judged.names_of_best in tried:
            weights = weights_of(fit)
            weighed = with_rivals_refitted(
                judged.weighed,
                scale,
                lambda chosen: fit_observations(problem, _with(springs, chosen), settings),
                lambda rival: _ground(rival, own, geometry, weights),  # noqa: B023, it is called before the next round
            )
            judged = replace(judged, weighed=weighed)
        best = judged.names_of_best
        if best in tried:
            break
        try:
            fit = fit_observations(problem, _with(springs, judged.best), settings)
        except (NoBalanceError, ArithmeticError):
            break
        tried.add(best)
    return judged


def _judged(ground: Ground, fit: Fit, candidates: Sequence[Candidate], scale: RobotScale, number: int) -> Judged:
    """Weigh sets about a model."""
    members = list_members(ground, candidates, scale)
    present = {f"{placed.effect.name} {placed.place.label}" for placed in ground.present}
    start = tuple(i for i, one in enumerate(members) if one.name in present and len(one.columns.present))
    return Judged(search_sets(members, ground.evidence([one.columns for one in members]), start), fit, ground, number)


def _is_member(placed: PlacedEffect) -> bool:
    """Return whether an effect of the model under test is judged like those that are not in it."""
    return placed.effect.name != JOINT_SPRING and not placed.effect.general


def _with(springs: CompliantRobot, chosen: Sequence[Member]) -> CompliantRobot:
    """Return the model with the listed of some members, their shapes as they were compared."""
    added = tuple(
        PlacedEffect(one.candidate.effect, one.candidate.place, dict(one.shape))
        for one in chosen
        if one.candidate is not None
    )
    return replace(springs, placed=(*springs.placed, *added))


def _ground(
    fit: Fit, own: Sequence[tuple[str, object]], geometry: GeometryNuisance | None, whitening: Whitening
) -> Ground:
    """Return what members are compared about: a fit, with what it has beyond the model under test as members."""
    state = Linearised.about(fit.robot, fit.data)
    about = fit.linearised(whitening, state)
    common_of = [
        k
        for k, column in enumerate(about.columns)
        if (fit.robot.placed[column.placed].effect.name, fit.robot.placed[column.placed].place) in own
    ]
    columns, prior = about.derivative[common_of], about.prior
    kept = [row for row in prior if not np.delete(row[:-1], common_of).any()]
    prior = np.array([[*row[:-1][common_of], row[-1]] for row in kept]).reshape(-1, len(common_of) + 1)
    if geometry is not None:
        nuisance = geometry.directions(about.space, columns)
        p, q = len(columns), len(nuisance)
        columns = np.concatenate([columns, nuisance])
        prior = np.insert(prior, [p] * q, 0.0, axis=1)
        prior = np.concatenate([prior, np.eye(q, p + q + 1, p)])
    space = about.space
    dof = float(about.dof - len(common_of))
    present = tuple(one for one in fit.robot.placed if (one.effect.name, one.place) not in own)
    derivative: dict[tuple[str, Place], dict[str, Floats]] = defaultdict(dict)
    for column, change in zip(about.columns, about.derivative, strict=True):
        placed = fit.robot.placed[column.placed]
        if placed in present and column.role is not ParameterRole.NONLINEAR:
            derivative[placed.effect.name, placed.place][column.symbol] = change
    of_loads, of_time = Discrepancy.of_loads(space), Discrepancy.of_time(space)
    noise = NoiseScale(dof, _known(fit))
    return Ground(
        state, space, space.rows(columns), prior, about.residual, present, derivative, of_loads, of_time, noise
    )


def _known(fit: Fit) -> float:
    """Return with how many degrees of freedom the scale of the weights is known besides the readings."""
    return STATED_NOISE_DOF if fit.noise is not None and fit.noise.source == "manifest" else 0.0

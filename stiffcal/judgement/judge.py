"""One distribution over what may be missing from a model of load states, and what is read off it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.candidates import list_candidates
from stiffcal.diagnosis.geometry_nuisance import GeometryNuisance
from stiffcal.diagnosis.load_scan import weights_of
from stiffcal.identification.fit import Fit
from stiffcal.identification.identify import Settings, fit_observations, fit_problem
from stiffcal.identification.noise import Whitening
from stiffcal.identification.regressors import Linearised
from stiffcal.judgement.discrepancy import Discrepancy
from stiffcal.judgement.evidence import Noise
from stiffcal.judgement.ground import Ground
from stiffcal.judgement.members import Member, list_members
from stiffcal.judgement.priors import STATED_NOISE_DOF, Kind, RobotScale
from stiffcal.judgement.sets import Weighed, search_sets
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, ParameterRole, Place
from stiffcal.model.no_balance import NoBalanceError

ROUNDS = 6
"""Models about which the members are compared, at most."""


@dataclass(frozen=True)
class Judged:
    """Sets of members with their probabilities about the best model."""

    weighed: Weighed
    """Of all sets."""
    fit: Fit
    """Of the model with the best set."""
    ground: Ground
    """About which they were weighed."""
    rounds: int
    """Models about which members were compared."""
    settled: bool
    """Whether the best set about the last model is that model's."""

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
    base = fit.robot
    candidates, _ = list_candidates(base, states, catalogue)
    scale = RobotScale.of(base, Linearised.about(base, problem.data).loads)
    geometry = GeometryNuisance.of(states, fit)
    own = tuple((placed.effect.name, placed.place) for placed in base.placed)
    chosen: frozenset[str] = frozenset()
    judged, known = None, {}
    for number in range(1, ROUNDS + 1):
        ground = _ground(fit, own, geometry, weights_of(fit))
        members = list_members(ground, candidates, scale)
        start = tuple(
            next(i for i, one in enumerate(members) if one.name == name and len(one.columns.present))
            for name in chosen
            if any(one.name == name and len(one.columns.present) for one in members)
        )
        weighed = search_sets(members, ground.evidence([one.columns for one in members]), start)
        best = frozenset(members[i].name for i in weighed.best if members[i].kind is Kind.EFFECT)
        judged = Judged(weighed, fit, ground, number, best == chosen)
        if best in known or best == chosen:
            break
        known[best] = True
        try:
            fit = fit_observations(problem, _with(base, [members[i] for i in weighed.best], ground), settings)
        except (NoBalanceError, ArithmeticError):
            break
        chosen = best
    assert judged is not None
    return judged


def _with(base: CompliantRobot, chosen: Sequence[Member], ground: Ground) -> CompliantRobot:
    """Return the model with the listed of some members, their shapes as they were compared."""
    added = tuple(
        PlacedEffect(one.candidate.effect, one.candidate.place, dict(one.shape))
        for one in chosen
        if one.candidate is not None
    )
    return replace(base, placed=(*base.placed, *added))


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
    discrepancy = Discrepancy.of(space)
    dof = float(about.dof - len(common_of))
    present = tuple(one for one in fit.robot.placed if (one.effect.name, one.place) not in own)
    derivative: dict[tuple[str, Place], dict[str, Floats]] = defaultdict(dict)
    for column, change in zip(about.columns, about.derivative, strict=True):
        placed = fit.robot.placed[column.placed]
        if placed in present and column.role is not ParameterRole.NONLINEAR:
            derivative[placed.effect.name, placed.place][column.symbol] = change
    return Ground(
        state, space, space.rows(columns), prior, about.residual, present, derivative, discrepancy,
        Noise(dof, _known(fit)),
    )  # fmt: skip


def _known(fit: Fit) -> float:
    """Return with how many degrees of freedom the scale of the weights is known besides the readings."""
    return STATED_NOISE_DOF if fit.noise is not None and fit.noise.source == "manifest" else 0.0

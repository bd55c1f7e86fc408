"""Who is tried: every effect at every place, with every shape of its grid."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.diagnosis.answers.results import UntestableEffect
from stiffcal.diagnosis.thresholds import MANY_SHAPES
from stiffcal.identification.fitting.regressors import Regressor, RegressorMaker
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Effect, EffectAtRest, ParameterRole, Place
from stiffcal.model.forms import added_forms


@dataclass(frozen=True)
class Candidate:
    """An effect at a place."""

    effect: Effect
    """The effect."""
    place: Place
    """Where on the robot it acts."""
    n_parameters: int
    """Number of its free parameters, nonlinear ones included."""
    forms: tuple[Effect, ...] = ()
    """Forms of the law among which the best is chosen, where there are several."""

    @property
    def name(self) -> str:
        """``effect at place``."""
        return f"{self.effect.name} {self.place.label}"


def list_candidates(
    robot: CompliantRobot, states: LoadStates, catalogue: Mapping[str, Effect]
) -> tuple[list[Candidate], list[UntestableEffect]]:
    """Return the effects that can be added to the model, and those that cannot, with the reason.

    Parameters
    ----------
    robot : the present model.
    states : the campaign's load states.
    catalogue : effects by name.
    """
    in_model = {(placed_effect.effect.name, placed_effect.place) for placed_effect in robot.placed}
    driven = set(driven_joint_of_state(states, robot.chain)) if len(states) and states.clamped.all() else None
    candidates, not_tried = [], []
    for effect in catalogue.values():
        if not isinstance(effect, EffectAtRest):
            not_tried.append(UntestableEffect(effect.name, "friction runs: load states are taken at rest"))
            continue
        reasons = {form: form.lacking(robot.chain, states) for form in added_forms(effect)}
        possible = [form for form, reason in reasons.items() if reason is None]
        if not possible:
            not_tried.append(UntestableEffect(effect.name, next(filter(None, reasons.values()))))
            continue
        places = effect.places(robot.chain)
        if driven is not None:
            if not effect.in_drive:
                needs = "load runs: clamped runs show only effects of a drive"
                not_tried.append(UntestableEffect(effect.name, needs))
                continue
            places = [place for place in places if driven.issuperset(place.joints)]
        if not places:
            not_tried.append(UntestableEffect(effect.name, f"no place on this robot: it acts at {effect.place_kind}"))
        elsewhere = {joint for place in places for joint in place.joints}
        left_out = robot.chain.prismatic_joints - elsewhere
        if places and effect.place_kind == "joints" and left_out and isinstance(effect.prismatic, str):
            names = ", ".join(robot.chain.joint_names[joint - 1] for joint in sorted(left_out))
            not_tried.append(
                UntestableEffect(effect.name, f"a revolute joint, and {names} is prismatic: {effect.prismatic}")
            )
        for place in places:
            if (effect.name, place) in in_model or stands_in_the_way(effect, place, robot):
                continue
            forms = tuple(form.at(place, robot.chain) for form in possible)
            law = forms[0] if len(forms) == 1 else effect.at(place, robot.chain)
            free = sum(1 for spec in law.parameters if not spec.scales_load)
            candidates.append(Candidate(law, place, free, forms if len(forms) > 1 else ()))
    return candidates, not_tried


def stands_in_the_way(effect: Effect, place: Place, robot: CompliantRobot) -> bool:
    """Return whether the model holds, at this place, what includes or excludes the effect."""
    return any(
        placed_effect.place == place
        and (
            effect.name in (*placed_effect.effect.includes, *placed_effect.effect.excludes)
            or placed_effect.effect.name in effect.excludes
        )
        for placed_effect in robot.placed
    )


def variants(candidate: Candidate, state: RegressorMaker, most: int = MANY_SHAPES) -> Iterator[Regressor]:
    """Return the candidate's regressors, one for each form of its law and combination of its shape grid.

    Laws with more combinations than ``most`` are left to a search of their own.
    """
    for effect in candidate.forms or (candidate.effect,):
        shapes: list[dict[str, float]] = [{}]
        if any(spec.role is ParameterRole.NONLINEAR for spec in effect.parameters):
            shapes = state.shapes(effect, candidate.place)
        if len(shapes) > most:
            continue
        for shape in shapes:
            regressor = state.regressor(effect, candidate.place, shape)
            if regressor.columns.any() or regressor.fixed.any():
                yield regressor


def driven_joint_of_state(states: LoadStates, chain: Chain) -> Integers:
    """Return (n,) the drive, from 1, that a clamped run has moved: the one that turned furthest; 0 of other runs."""
    turn, result = states.joints @ chain.drives_of_logged.T, np.zeros(len(states), dtype=np.int64)
    for members in members_of(states.run):
        if states.clamped[members].all():
            result[members] = int(np.argmax(np.ptp(turn[members], axis=0))) + 1
    return result

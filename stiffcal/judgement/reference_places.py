"""What absolute places of reference states say of errors of the set-up: readings that displacements do not hold.

A tracker that is turned, or a target elsewhere, misses in every place by what it is; a displacement shows it as well as
something else. The share s ± u of the fitted value that places show is normal about 1 if it is there, about 0 if it is
not: their log density differs by (s − ½)/u².
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.diagnosis.held_to_places import ReferencePlaces
from stiffcal.judgement.evidence import SetEvidence
from stiffcal.judgement.ground_of_states import GroundOfStates
from stiffcal.judgement.members import Member
from stiffcal.judgement.numbers import KNOWN_IN_PLACES
from stiffcal.judgement.priors import RobotScale
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Instrument


def with_reference_places(
    members: Sequence[Member], evidence: SetEvidence, ground: GroundOfStates, places: ReferencePlaces, scale: RobotScale
) -> list[Member]:
    """Return members with the odds that places give to errors of the set-up.

    Parameters
    ----------
    evidence : of their columns. places : of the campaign. scale : of the robot.
    """
    none = evidence.of_set(())
    return [
        replace(one, log_prior=one.log_prior + _said(number, one, evidence, ground, places, scale))
        if _is_of_setup(one) and evidence.of_set((number,)) > none + KNOWN_IN_PLACES
        else one
        for number, one in enumerate(members)
    ]


def _is_of_setup(member: Member) -> bool:
    candidate = member.candidate
    return candidate is not None and candidate.place.kind == "setup" and isinstance(candidate.effect, Instrument)


def _said(
    number: int,
    member: Member,
    evidence: SetEvidence,
    ground: GroundOfStates,
    places: ReferencePlaces,
    scale: RobotScale,
) -> float:
    """Return by how many nats places are more probable with an effect than without."""
    assert member.candidate is not None
    effect, place = member.candidate.effect, member.candidate.place
    best, coefficients = evidence.coefficients((number,))
    if len(member.symbols) != len(coefficients):
        return 0.0
    information = float(coefficients @ evidence.inner.own[number][best] @ coefficients)
    typical = [scale.typical(effect, place, symbol) for symbol in member.symbols]
    values = {
        symbol: effect.spec(symbol).value_of(float(coefficient * size))
        for symbol, coefficient, size in zip(member.symbols, coefficients, typical, strict=True)
    }
    placed = PlacedEffect(effect, place, {**member.shape, **values})
    others = tuple(one for one in ground.state.robot.placed if (one.effect.name, one.place) != (effect.name, place))
    robot = replace(ground.state.robot, placed=(*others, placed))
    found = places.agreement(robot, placed, 1.0 / np.sqrt(max(information, 1e-300)))
    if found is None:
        return 0.0
    return float((found.share - 0.5) / found.std**2)

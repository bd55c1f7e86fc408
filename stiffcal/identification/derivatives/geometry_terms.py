"""How parameters of the geometry move the chain, at their present values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.derivatives.observation_shift import STEP
from stiffcal.identification.readings.observations import Observations
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import ParameterRole, Term, joint_node


def geometry_terms(
    model: CompliantRobot, chosen: Sequence[PlacedEffect], data: Observations, angles: Floats
) -> Iterator[tuple[PlacedEffect, Term]]:
    """Yield how a unit of each parameter of the geometry moves a joint's node and all outboard of it, in its axes.

    Nothing where displacements count alone: they depend on the geometry by its square, as both of their ends move.

    Parameters
    ----------
    model : the chain with all effects.
    chosen : those of the effects whose terms are wanted.
    data : the observations.
    angles : (J, n) model angles at rest, rad, effects that change them included.
    """
    if not data.absolute.any():
        return
    for placed in chosen:
        terms = placed.geometry_terms(model.chain, data.angles)
        symbols = dict.fromkeys(term.symbol for term in terms)
        for symbol in symbols:
            moved = list(_chain_terms(model, placed, symbol, angles))
            for term in moved or [term for term in terms if term.symbol == symbol]:
                yield placed, term


def _chain_terms(model: CompliantRobot, placed: PlacedEffect, symbol: str, angles: Floats) -> Iterator[Term]:
    """Yield the terms of a parameter that moves the fixed transforms between the joints, by their difference."""
    spec = placed.effect.spec(symbol)
    value = placed.values.get(symbol, spec.neutral)
    step = STEP * spec.size
    number = next(k for k, acting in enumerate(model.acting) if acting is placed)
    ahead, behind = (model.fixed_with(number, {**placed.values, symbol: value + sign * step}) for sign in (1.0, -1.0))
    if spec.role is ParameterRole.AMPLITUDE:
        step *= spec.amplitude_of(1.0)
    chain = model.adjusted_chain
    for k in np.flatnonzero(np.any(ahead != behind, axis=(1, 2))):
        # in the axes of the joint's frame before it moves
        twist = np.linalg.inv(chain.fixed[k]) @ (ahead[k] - behind[k]) / (2.0 * step)
        turn = np.array([twist[2, 1], twist[0, 2], twist[1, 0]])
        yield from _after_the_joint(chain, int(k), symbol, turn, twist[:3, 3], angles)


def _after_the_joint(chain: Chain, k: int, symbol: str, turn: Floats, shift: Floats, angles: Floats) -> Iterator[Term]:
    """Yield a turn and a shift (3,) of the frame before the joint's motion as terms of its node behind it."""
    position, node = angles[k], joint_node(k + 1)
    along = np.full_like(position, chain.bearing[k])
    cosine, sine = np.ones_like(position), np.zeros_like(position)
    if chain.prismatic[k]:
        along = along + position
    else:
        cosine, sine = np.cos(position), np.sin(position)
    x, y = shift[0] + turn[1] * along, shift[1] - turn[0] * along
    parts = (x * cosine + y * sine, y * cosine - x * sine, np.full_like(along, shift[2]))
    turns = (turn[0] * cosine + turn[1] * sine, turn[1] * cosine - turn[0] * sine, np.full_like(along, turn[2]))
    for component, values in enumerate((*parts, *turns)):
        if values.any():
            yield Term(node, component, symbol, values)

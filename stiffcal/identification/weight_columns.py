"""How the observations move with the weight of a link, or with the direction of all weight.

On the shape at rest every node's wrench is linear in a link's first moment, so that a unit of it is exact there, and in
a small turn of gravity; what the laws answer moves the targets by the nodes' levers. That the shape then sags further
is left out, as in all columns of laws: a per cent of the step.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.readings import Observations
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.deformed_chain import node_wrenches
from stiffcal.model.effect import NodeLoads
from stiffcal.model.equilibrium import Rest, WeightOnlyRest, first_order_displacement, law_terms


def weight_column(
    model: CompliantRobot, data: Observations, at_rest: tuple[Rest, WeightOnlyRest], placed: PlacedEffect, symbol: str
) -> Floats:
    """Return (m, n) derivative of the observations by a parameter of an effect that changes weight.

    Parameters
    ----------
    model : chain and effects with values; ``placed`` need not be among them.
    at_rest : where the model rests, loaded and under weight alone.
    placed : the effect (`Effect.moves_masses`, `Effect.turns_gravity`).
    symbol : its parameter.
    """
    loaded, unloaded = at_rest
    step = placed.effect.spec(symbol).typical
    chain = model.adjusted_chain
    heavier = placed.effect.adjusted_chain(placed.place, chain, {symbol: step})
    turned = placed.effect.adjusted(placed.place, loaded.inputs, {symbol: step})
    before = node_wrenches(chain, loaded.shape, loaded.inputs)
    after = node_wrenches(heavier, loaded.shape, turned)
    change = after - before
    angles = loaded.inputs.angles
    moved = _answer(model, NodeLoads(loaded.wrench, angles, data.order, loaded.weight), change)
    if not data.absolute.all():
        # displacements are counted from the rest under weight, which moves with it
        resting = _answer(
            model, NodeLoads(unloaded.wrench, angles, reference_kelvin=data.order.reference_kelvin), change
        )
        moved -= np.where(data.absolute, 0.0, resting)
    moved /= step
    rows = data.layout.of_targets(np.stack(first_order_displacement(loaded, moved)))
    data.layout.add_rods(rows, moved)
    return rows


def _answer(model: CompliantRobot, loads: NodeLoads, change: Floats) -> Floats:
    """Return (2J + 2, 6, n) how the nodes' displacements change with their wrenches."""
    displacement = np.zeros_like(change)
    changed = replace(loads, wrench=loads.wrench + change)
    for (placed, term), (_, other) in zip(law_terms(model, loads), law_terms(model, changed), strict=True):
        amplitude = placed.amplitude(term.symbol)
        if amplitude:
            displacement[term.node, term.component] += amplitude * (other.value - term.value)
    return displacement

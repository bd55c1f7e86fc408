"""How the observations move with the weight of a link, or with the direction of all weight.

On the shape at rest every node's wrench is linear in a link's first moment, so that a unit of it is exact there, and in
a small turn of gravity.
"""

from __future__ import annotations

from stiffcal.arrays import Floats
from stiffcal.identification.derivatives.tangents import Tangents
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.balance.deformed_chain import node_wrenches
from stiffcal.model.balance.rest import Rest


def weight_column(tangents: Tangents, placed: PlacedEffect, symbol: str) -> Floats:
    """Return (m, n) derivative of the observations by a parameter of an effect that changes weight.

    Parameters
    ----------
    tangents : of the model where it rests; ``placed`` need not be among its effects.
    placed : the effect, a `LinkMoments` or `BaseTilt`.
    symbol : its parameter.
    """
    step = placed.effect.spec(symbol).typical
    chain = tangents.model.adjusted_chain
    heavier = placed.adjusted_chain(chain, {symbol: step})

    def change(rest: Rest) -> Floats:
        turned = placed.adjusted(rest.inputs, {symbol: step})
        return (node_wrenches(heavier, rest.shape, turned) - node_wrenches(chain, rest.shape, rest.inputs)) / step

    return tangents.wrench_rows(change(tangents.loaded), None if tangents.poses is None else change(tangents.poses))

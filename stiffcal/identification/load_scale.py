"""Gains of the whole load: redundant with all compliances, unless a law is not straight in it.

Where every law is in proportion to the load, displacement = compliance × load, and a load read s times too large gives
compliances that are s times too small and the same displacements. A known weight or torque determines s only through a
law that is not straight: play that is crossed where weight and load balance, friction, a curve.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stiffcal.identification.observation import Observations, predicted, rests
from stiffcal.model.composite import CompliantRobot, PlacedEffect

# A law that bends departs from proportion by a share of its displacement; rounding and the tolerance of the balance
# make 1e-9 of it.
STRAIGHT = 1e-6


def redundant_gains(robot: CompliantRobot, data: Observations, fixed: frozenset[str]) -> frozenset[str]:
    """Return the full names of free gains of the load that these data cannot determine.

    Parameters
    ----------
    robot : chain and effects, with or without values.
    data : the observations.
    fixed : full names of parameters that keep their values.
    """
    names = frozenset(
        placed_effect.parameter_name(spec.symbol)
        for placed_effect in robot.placed
        for spec in placed_effect.effect.parameters
        if spec.scales_load
    )
    names -= fixed
    return names if names and is_proportional(robot, data) else frozenset()


def is_proportional(robot: CompliantRobot, data: Observations) -> bool:
    """Return whether twice the load would move every reading twice as far, on the chain as drawn.

    The balance of the deformed chain bends every load-deflection curve by a per cent; that is less than what the laws
    themselves leave out, and no basis for a gain.
    """
    if not robot.chain.masses_known:
        return True
    typical = tuple(replace(placed, values=_typical(placed)) for placed in robot.placed)
    linear = replace(robot, placed=typical, deformed=False)
    once, twice = (
        predicted(linear, loaded, *rests(linear, loaded)) for loaded in (data, replace(data, wrench=2.0 * data.wrench))
    )
    size = float(np.abs(once).max(initial=0.0))
    return float(np.abs(twice - 2.0 * once).max(initial=0.0)) <= STRAIGHT * size


def _typical(placed: PlacedEffect) -> Mapping[str, float]:
    """Return usual values of laws; set-up errors stay out, what they change is the same for both loads."""
    effect = placed.effect
    return {
        spec.symbol: placed.values.get(spec.symbol, spec.typical) for spec in effect.parameters if not spec.scales_load
    }

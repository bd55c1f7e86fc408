"""Scales of loads and weights that all compliances together make up for.

Gains of the whole load are redundant, unless a law is not straight in it; moments of the links are, by one common
scale, where nothing but weight acts.

Where every law is in proportion to the load, displacement = compliance × load, and a load read s times too large gives
compliances that are s times too small and the same displacements. A known weight or torque determines s only through a
law that is not straight: play that is crossed where weight and load balance, friction, a curve.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import Observations, derivatives
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Kind, ParameterRole
from stiffcal.model.laws.link_moments import LinkMoments

# A law that bends departs from proportion by a share of its displacement; rounding and the tolerance of the balance
# make 1e-9 of it.
STRAIGHT = 1e-6
# Places of two models that differ by less than this are the same: rounding of levers and weights makes 1e-12 of it.
SAME_PLACES = 1e-6
_LAWS = (Kind.NODE_LAW, Kind.COUPLING)


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
    once, twice = (predict_observations(linear, loaded) for loaded in (data, replace(data, wrench=2.0 * data.wrench)))
    size = float(np.abs(once).max(initial=0.0))
    return float(np.abs(twice - 2.0 * once).max(initial=0.0)) <= STRAIGHT * size


def _typical(placed: PlacedEffect) -> Mapping[str, float]:
    """Return usual values of laws; set-up errors stay out, what they change is the same for both loads."""
    effect = placed.effect
    return {
        spec.symbol: placed.values.get(spec.symbol, spec.typical) for spec in effect.parameters if not spec.scales_load
    }


def common_scale(robot: CompliantRobot, data: Observations, fixed: frozenset[str]) -> tuple[str, ...]:
    """Return the full names of free moments and compliances that one common scale leaves unknown; empty where none is.

    Under weight alone, moments s times as large and compliances s times as small give the same places. That is so where
    what the free compliances make is a sum of what the free moments make. The first name, of the moment with the
    largest share, is the one to keep its value.

    Parameters
    ----------
    robot : chain and effects, with or without values.
    data : the observations.
    fixed : full names of parameters that keep their values.
    """
    weighing = [placed for placed in robot.placed if isinstance(placed.effect, LinkMoments)]
    if not weighing or not data.absolute.all() or len(data.joint_torque):
        return ()  # motors that hold the robot weigh it
    linear = replace(robot, placed=tuple(replace(placed, values=_typical_law(placed)) for placed in robot.placed))
    linear = replace(linear, deformed=False)
    columns = [
        column
        for column in free_columns(linear, fixed)
        if isinstance(linear.placed[column.placed].effect, LinkMoments)
        or (column.role is ParameterRole.AMPLITUDE and linear.placed[column.placed].effect.kind in _LAWS)
    ]
    sensitivities = derivatives(linear, data, columns)
    rows = np.where(data.measured_mask, sensitivities, 0.0).reshape(len(columns), -1)
    names, parts, moments = [], [], []
    for column, row in zip(columns, rows, strict=True):
        placed = linear.placed[column.placed]
        names.append(placed.parameter_name(column.symbol))
        moments.append(isinstance(placed.effect, LinkMoments))
        parts.append(row if isinstance(placed.effect, LinkMoments) else placed.amplitude(column.symbol) * row)
    return _sharing(names, np.array(parts), np.array(moments, dtype=np.bool_))


def _sharing(names: list[str], parts: Floats, moments: Booleans) -> tuple[str, ...]:
    """Return who shares the scale, the largest moment first, where the laws' rows are a sum of the moments' rows."""
    if moments.all() or not moments.any():
        return ()
    whole = parts[~moments].sum(axis=0)
    length = np.linalg.norm(parts, axis=1)
    moving = np.flatnonzero(moments & (length > 0.0))
    if not whole.any() or not len(moving):
        return ()
    unit = (parts[moving] / length[moving, None]).T
    share, *_ = np.linalg.lstsq(unit, whole, rcond=1e-12)
    if np.linalg.norm(unit @ share - whole) > SAME_PLACES * np.linalg.norm(whole):
        return ()
    size = np.abs(share)
    sharing = [int(i) for i in moving[np.argsort(-size, kind="stable")]]
    laws = [int(i) for i in np.flatnonzero(~moments & (length > SAME_PLACES * np.linalg.norm(whole)))]
    return tuple(names[i] for i in (*sharing, *laws))


def _typical_law(placed: PlacedEffect) -> Mapping[str, float]:
    """Return typical values of laws that give under load, and of moments: one that is zero has its scale too."""
    if placed.effect.kind not in _LAWS and not isinstance(placed.effect, LinkMoments):
        return placed.values
    return {spec.symbol: placed.values.get(spec.symbol) or spec.typical for spec in placed.effect.parameters}

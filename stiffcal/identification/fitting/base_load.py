"""Compliances that weight loads by the tilt of the base alone.

A joint whose axis is vertical in every pose carries no weight on its drive. Where the turn of the base is a parameter,
what it loads such a joint with is known no better than that turn, and compliance times turn is one number.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import ParameterColumn, free_columns
from stiffcal.identification.derivatives.observation import Observations, derivatives
from stiffcal.model.assembled.base_tilt import BaseTilt
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import ParameterRole

# Regressors that are less than this share of the longest are rounding: nothing loads such a joint.
ROUNDING = 1e-9


def loaded_by_tilt(robot: CompliantRobot, data: Observations, fixed: frozenset[str]) -> frozenset[str]:
    """Return the full names of compliances whose regressor the prior's turn of the base changes by more than it is.

    Parameters
    ----------
    robot : chain and effects; their values play no part. data : the observations.
    fixed : full names of parameters that keep their values.
    """
    turns = [
        (placed.parameter_name(spec.symbol), spec.prior)
        for placed in robot.placed
        if isinstance(placed.effect, BaseTilt)
        for spec in placed.effect.parameters
        if spec.prior is not None
    ]
    if not turns:
        return frozenset()
    nominal = replace(robot, placed=tuple(replace(placed, values={}) for placed in robot.placed))
    columns = [
        column
        for column in free_columns(robot, fixed)
        if column.role is ParameterRole.AMPLITUDE and not robot.placed[column.placed].changes_geometry
    ]
    upright = _columns(nominal, data, columns)
    length = np.linalg.norm(upright, axis=1)
    change = np.zeros(len(columns))
    for name, size in turns:
        turned = _columns(nominal.with_values({name: size}), data, columns)
        change = np.maximum(change, np.linalg.norm(turned - upright, axis=1))
    return frozenset(
        robot.placed[column.placed].parameter_name(column.symbol)
        for column, more, less in zip(columns, change, length, strict=True)
        if more > max(less, ROUNDING * float(length.max(initial=0.0)))
    )


def _columns(robot: CompliantRobot, data: Observations, columns: list[ParameterColumn]) -> Floats:
    """Return (p, m n) regressors on the chain as drawn."""
    whole = derivatives(replace(robot, deformed=False), data, columns)
    return np.where(data.measured_mask, whole, 0.0).reshape(len(columns), -1)

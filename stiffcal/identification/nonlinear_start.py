"""Where the shape parameters of a law start: a profile over the effect's own grid (variable projection).

With the shape given, a law is linear in its amplitudes, and what it leaves of the residual is a matter of one small
least-squares problem; the shape that leaves least is where Gauss–Newton starts (Golub and Pereyra 1973).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.least_squares import triangular
from stiffcal.identification.noise import Whitening
from stiffcal.identification.observation import Observations, evaluate, free_columns
from stiffcal.identification.projection import Projection
from stiffcal.identification.regressors import Linearised
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import ParameterRole


def lacks_nonlinear_value(placed_effect: PlacedEffect) -> bool:
    """Return whether a shape parameter has no value yet."""
    return any(spec.symbol not in placed_effect.values for spec in placed_effect.specs(ParameterRole.NONLINEAR))


def start_nonlinear(
    robot: CompliantRobot, data: Observations, whitening: Whitening, fixed: frozenset[str] = frozenset()
) -> CompliantRobot:
    """Give every shape parameter that has none the value that leaves least of the residual, effect by effect.

    Parameters
    ----------
    robot : with values, except for the shapes and the amplitudes that go with them.
    data, whitening : the observations and their noise.
    fixed : full names that keep their values; their own effect's other shapes are still profiled.
    """
    space = Projection.of(data, whitening)
    for number, placed_effect in enumerate(robot.placed):
        if not lacks_nonlinear_value(placed_effect):
            continue
        other_effects = replace(robot, placed=tuple(p for k, p in enumerate(robot.placed) if k != number))
        state = Linearised.about(other_effects, data)
        columns = [
            column
            for column in free_columns(other_effects, fixed)
            if column.role is not ParameterRole.NONLINEAR
            and not lacks_nonlinear_value(other_effects.placed[column.placed])
        ]
        background = np.concatenate([block.columns for block in evaluate(other_effects, data, columns)], axis=2)
        residual = np.where(data.measured_mask, data.measured - state.predicted, 0.0)
        base = space.rows(np.concatenate([background, residual[None]]))
        best, least = {spec.symbol: spec.typical for spec in placed_effect.specs(ParameterRole.NONLINEAR)}, np.inf
        for shape in state.shapes(placed_effect.effect, placed_effect.place):
            trial = {**shape, **{s: v for s, v in placed_effect.values.items() if s in shape}}
            squares = remaining_squares(
                base, space.rows(state.regressor(placed_effect.effect, placed_effect.place, trial).columns)
            )
            if squares < least:
                best, least = trial, squares
        robot = replace(
            robot,
            placed=tuple(
                replace(p, values={**best, **p.values}) if k == number else p for k, p in enumerate(robot.placed)
            ),
        )
    return robot


def remaining_squares(base: Floats, columns: Floats) -> float:
    """Return the rest of the last row of ``base`` after the other rows and ``columns`` took what they can."""
    stack = np.concatenate([base[:-1], columns, base[-1:]])
    scale = np.sqrt(np.sum(stack**2, axis=1))
    nonzero = scale > 0.0
    nonzero[-1] = True
    factor = triangular((stack[nonzero] / np.where(scale[nonzero] > 0.0, scale[nonzero], 1.0)[:, None]).T)
    return float(factor[-1, -1] ** 2 * scale[-1] ** 2)

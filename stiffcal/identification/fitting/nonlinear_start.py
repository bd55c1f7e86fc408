"""Where the shape parameters of a law start: a profile over the effect's own grid (variable projection).

With the shape given, a law is linear in its amplitudes, and what it leaves of the residual is a matter of one small
least-squares problem; the shape that leaves least is where Gauss–Newton starts (Golub and Pereyra 1973).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.triangular import triangular
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.fitting.load_rows import LoadRows
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.readings.observations import Observations
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import ParameterRole, Values


def lacks_nonlinear_value(placed_effect: PlacedEffect) -> bool:
    """Return whether a shape parameter has no value yet."""
    return any(spec.symbol not in placed_effect.values for spec in placed_effect.specs(ParameterRole.NONLINEAR))


def start_nonlinear(
    robot: CompliantRobot, data: Observations, whitening: Whitening, fixed: frozenset[str] = frozenset()
) -> CompliantRobot:
    """Give every shape parameter that has none the value that leaves least of the residual.

    Effect by effect, until none of them would be given another value for what the others have become.

    Parameters
    ----------
    robot : with values, except for the shapes and the amplitudes that go with them.
    data, whitening : the observations and their noise.
    fixed : full names that keep their values; their own effect's other shapes are still profiled.
    """
    given = {n: placed.values for n, placed in enumerate(robot.placed) if lacks_nonlinear_value(placed)}
    tried: set[tuple[float, ...]] = set()
    while True:
        for number, values in given.items():
            others = replace(robot, placed=tuple(p for k, p in enumerate(robot.placed) if k != number))
            best = _best_shape(others, robot.placed[number], values, data, whitening, fixed)
            started = replace(robot.placed[number], values=best)
            robot = replace(robot, placed=tuple(started if k == number else p for k, p in enumerate(robot.placed)))
        # what the first of several took for its own may be another's: each again, with the others where they are now
        shapes = tuple(value for number in given for value in robot.placed[number].values.values())
        if len(given) < 2 or shapes in tried:
            return robot
        tried.add(shapes)


def _best_shape(
    others: CompliantRobot,
    placed: PlacedEffect,
    given: Values,
    data: Observations,
    whitening: Whitening,
    fixed: frozenset[str],
) -> Values:
    """Return the effect's values, its shapes those that leave least with the other effects as they are."""
    state = Linearised.about(others, data)
    columns = [
        column
        for column in free_columns(others, fixed)
        if column.role is not ParameterRole.NONLINEAR and not lacks_nonlinear_value(others.placed[column.placed])
    ]
    about = LoadRows.about(others, data, columns, whitening, state)

    best, least = {spec.symbol: spec.typical for spec in placed.specs(ParameterRole.NONLINEAR)}, np.inf
    for shape in state.shapes(placed.effect, placed.place):
        trial = {**shape, **{s: v for s, v in given.items() if s in shape}}
        added = about.space.rows(state.regressor(placed.effect, placed.place, trial).columns)
        left = remaining_squares(about.white, added)
        if left < least:
            best, least = trial, left
    return {**best, **given}


def remaining_squares(base: Floats, columns: Floats) -> float:
    """Return the rest of the last row of ``base`` after the other rows and ``columns`` took what they can."""
    stack = np.concatenate([base[:-1], columns, base[-1:]])
    scale = np.sqrt(np.sum(stack**2, axis=1))
    nonzero = scale > 0.0
    nonzero[-1] = True
    factor = triangular((stack[nonzero] / np.where(scale[nonzero] > 0.0, scale[nonzero], 1.0)[:, None]).T)
    return float(factor[-1, -1] ** 2 * scale[-1] ** 2)

"""Where a fit of friction begins: shapes of laws from the grids of their effects."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from itertools import pairwise, product

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import with_estimates
from stiffcal.kinds.friction.fitting.drive_space import DriveSpace
from stiffcal.kinds.friction.fitting.row_columns import RowColumns
from stiffcal.kinds.friction.fitting.source import MotionSource
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, ParameterRole, Place
from stiffcal.model.motion import as_motion

# Singular values below this share of the largest: amplitudes of one law that these rows do not distinguish.
RANK = 1e-9


def grid_shapes(made: RowColumns, effect: Effect, place: Place) -> list[dict[str, float]]:
    """Return the combinations of an effect's grid that are possible."""
    return _possible(made, PlacedEffect(effect, place), ())


def shapes_to_find(source: MotionSource) -> list[int]:
    """Return the numbers of the laws with shapes that are not fixed."""
    return [
        number
        for number, placed in enumerate(source.robot.placed)
        if any(placed.parameter_name(symbol) not in source.fixed for symbol in placed.shape())
    ]


def with_best_shapes(source: MotionSource, space: DriveSpace) -> CompliantRobot:
    """Return the model with each law's shape of the grid that leaves least, every amplitude refitted.

    Parameters
    ----------
    source : of the rows. space : their weights.
    """
    robot = source.robot
    for number in shapes_to_find(source):
        best = _best_shape(replace(source, robot=robot), space, number)
        robot = replace(robot, placed=(*robot.placed[:number], best, *robot.placed[number + 1 :]))
    return robot


def _possible(made: RowColumns, placed: PlacedEffect, fixed: Collection[str]) -> list[dict[str, float]]:
    """Return the shapes to try: those of the effect's grid that are possible, fixed ones kept."""
    effect, usual = as_motion(placed.effect), placed.shape()
    motion = made.rows.motion_of(placed.place.joints[0], with_travel=True)
    grid = effect.motion_grid(placed.place, made.chain, motion)
    values = [[usual[symbol]] if placed.parameter_name(symbol) in fixed else grid[symbol].tolist() for symbol in grid]
    shapes = [usual | dict(zip(grid, combination, strict=True)) for combination in product(*values)]
    return [shape for shape in shapes if effect.impossible(shape) is None]


def _best_shape(source: MotionSource, space: DriveSpace, number: int) -> PlacedEffect:
    """Return one of the laws with the shape of its grid that leaves least."""
    straight = [column for column in source.columns if column.role is ParameterRole.AMPLITUDE]
    # amplitudes that are free are refitted with each shape: without them there is what is fixed
    robot = with_estimates(source.robot, straight, np.zeros(len(straight)))
    placed, k = robot.placed[number], len(source.rows)
    apart = [source.torque_of(other) for position, other in enumerate(robot.placed) if position != number]
    target = source.rows.torque - sum(apart, np.zeros(k))
    of_others = [
        source.made.of(other.effect, other.place, other.shape())[column.symbol]
        for column in straight
        if column.placed != number
        for other in [robot.placed[column.placed]]
    ]
    others = space.rows(np.stack(of_others)[:, None]) if of_others else np.zeros((0, k))
    length = np.linalg.norm(others, axis=1)
    basis = np.linalg.qr((others[length > 0.0] / length[length > 0.0, None]).T)[0]

    def white(columns: list[Floats]) -> Floats:
        left = space.rows(np.stack(columns)[:, None])
        return np.asarray(left - (left @ basis) @ basis.T)

    own = [position for position, column in enumerate(source.columns) if column in straight and column.placed == number]
    symbols, lower = [source.columns[position].symbol for position in own], source.unknowns.lower[own]
    best, least = placed.shape(), np.inf
    for shape in _possible(source.made, placed, source.fixed):
        columns = source.made.of(placed.effect, placed.place, shape)
        held = sum((placed.amplitude(s) * column for s, column in columns.items()), np.zeros(k))
        rows = white([*(columns[s] for s in symbols), target - held])
        solution = np.linalg.lstsq(rows[:-1].T, rows[-1], rcond=RANK)[0] if own else np.zeros(0)
        left = float(np.sum((rows[-1] - np.maximum(solution, lower) @ rows[:-1]) ** 2))
        if left < least * (1.0 - 1e-12):
            best, least = shape, left
    return replace(source.robot.placed[number], values={**source.robot.placed[number].values, **best})


def within_reach(source: MotionSource) -> MotionSource:
    """Return the source whose shapes go as far as their effects' grids reach, and no further than is possible."""
    lower, upper = source.unknowns.lower.copy(), source.unknowns.upper.copy()
    for position, column in enumerate(source.columns):
        if not source.unknowns.nonlinear[position]:
            continue
        placed = source.robot.placed[column.placed]
        motion = source.rows.motion_of(placed.place.joints[0])
        grid = as_motion(placed.effect).motion_grid(placed.place, source.made.chain, motion)
        shape = placed.shape()
        value = shape[column.symbol]
        values = np.sort(grid.get(column.symbol, np.array([value])))
        low, high = float(lower[position]), float(upper[position])
        if placed.effect.spec(column.symbol).unit in ("rad/s", "rad") and values.size > 1:
            # of speeds and angles as far as these data reach
            low, high = max(low, float(values[0])), min(high, float(values[-1]))
        low, high = min(low, value), max(high, value)
        for first, second in pairwise(values.tolist()):
            if placed.effect.impossible(shape | {column.symbol: 0.5 * (first + second)}) is not None:
                low, high = (max(low, second), high) if second <= value else (low, min(high, first))
        lower[position], upper[position] = low, high
    return replace(source, unknowns=replace(source.unknowns, lower=lower, upper=upper))

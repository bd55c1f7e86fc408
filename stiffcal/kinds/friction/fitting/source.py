"""What drives' motion makes as rows of a fit; weight, inertia and zeros are projected out."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.estimation.rows import Rows
from stiffcal.estimation.triangular import Reduced
from stiffcal.estimation.undetermined import Undetermined
from stiffcal.estimation.unknowns import (
    OpenBefore,
    ParameterColumn,
    Unknowns,
    amplitudes,
    free_columns,
    with_estimates,
)
from stiffcal.kinds.friction.fitting.drive_space import DriveSpace, first_sigma
from stiffcal.kinds.friction.fitting.identifiability import LEAST_SHARE
from stiffcal.kinds.friction.fitting.row_columns import RowColumns
from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows, UnknownKind
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import ParameterRole
from stiffcal.model.motion import as_motion, is_constant_torque

# Half the step, as a share of a shape, over which its slope is taken.
SLOPE_STEP = 1e-4


@dataclass(frozen=True)
class MotionSource:
    """Makes the rows of friction runs about a model's free parameters (`stiffcal.estimation.solve.RowSource`)."""

    made: RowColumns
    """The rows, and what effects make of them."""
    robot: CompliantRobot
    """The effects of the moved joints; the values of its free parameters do not matter."""
    columns: Sequence[ParameterColumn]
    """Its p free parameters."""
    unknowns: Unknowns
    """The same, as the fit knows them."""
    fixed: frozenset[str]
    """Full names of parameters that keep the model file's values."""

    @classmethod
    def of(
        cls, rows: FrictionRows, placed: tuple[PlacedEffect, ...], chain: Chain, fixed: frozenset[str] = frozenset()
    ) -> MotionSource:
        """Return the source of all parameters but the fixed ones and those that only a grid chooses.

        Parameters
        ----------
        rows : that share unknowns. placed : effects that act in them. chain : the robot.
        fixed : as the field.
        """
        for effect in placed:
            if is_constant_torque(as_motion(effect.effect), effect.place, chain):
                # the constants at each speed would absorb it
                rows = rows.without(UnknownKind.STRETCH, effect.place.joints[0])
        # shapes without a value begin at their usual one
        shaped = tuple(replace(effect, values={**effect.values, **effect.shape()}) for effect in placed)
        robot = CompliantRobot(chain, shaped)
        columns = free_columns(robot, fixed)
        source = cls(RowColumns(rows, chain), robot, columns, Unknowns.of(robot, columns), fixed)
        absorbed = dict.fromkeys(source.absorbed(), Undetermined.INSEPARABLE)
        return replace(source, unknowns=replace(source.unknowns, open_before=OpenBefore(absorbed)))

    @property
    def rows(self) -> FrictionRows:
        """The k rows."""
        return self.made.rows

    @property
    def curved(self) -> bool:
        """Whether the rows or their weights change with the parameters."""
        return self.lasting_weights or bool(self.unknowns.nonlinear.any())

    @property
    def lasting_weights(self) -> bool:
        """Whether rows are weighed by what the fit leaves of them."""
        return not self.noise_known.all()

    @cached_property
    def noise_known(self) -> Booleans:
        """(k,) True where neighbouring samples show the noise."""
        return np.isfinite(self.rows.sigma)

    @cached_property
    def first_space(self) -> DriveSpace:
        """The rows' noise before any fit."""
        return DriveSpace.of(self.rows, first_sigma(self.rows))

    def absorbed(self) -> list[str]:
        """Return full names of amplitudes that weight, inertia and zeros can stand for."""
        derivative = self.about(amplitudes(self.robot, self.columns), self.first_space).derivative
        left = np.linalg.norm(self.first_space.rows(derivative), axis=1)
        whole = np.linalg.norm(derivative[:, 0] / self.first_space.sigma, axis=1)
        gone = ~self.unknowns.nonlinear & (left <= LEAST_SHARE * whole)
        return [name for name, is_gone in zip(self.unknowns.names, gone.tolist(), strict=True) if is_gone]

    def holding(self, names: Collection[str]) -> MotionSource:
        """Return the source with parameters, by full name, that keep the robot's values."""
        kept = np.flatnonzero(~self.unknowns.where(names)).tolist()
        return replace(self, columns=[self.columns[k] for k in kept], unknowns=self.unknowns.select(kept))

    def robot_at(self, values: Floats) -> CompliantRobot:
        """Return the robot with values (p,) of its free parameters."""
        return with_estimates(self.robot, self.columns, values)

    def torque_of(self, placed: PlacedEffect) -> Floats:
        """Return (k,) N·m that an effect makes of every row with its values."""
        columns = self.made.of(placed.effect, placed.place, placed.shape())
        return np.asarray(
            sum((placed.amplitude(s) * column for s, column in columns.items()), np.zeros(len(self.rows)))
        )

    def about(self, values: Floats, space: DriveSpace) -> Rows:
        """Return the rows about values (p,), with noise and other unknowns as in ``space``."""
        robot, k = self.robot_at(values), len(self.rows)
        torque, derivative = np.zeros(k), np.zeros((len(values), k))
        for number, placed in enumerate(robot.placed):
            columns = self.made.of(placed.effect, placed.place, placed.shape())
            for symbol, column in columns.items():
                torque += placed.amplitude(symbol) * column
            for position, free in enumerate(self.columns):
                if free.placed == number:
                    straight = free.role is ParameterRole.AMPLITUDE
                    derivative[position] = columns[free.symbol] if straight else self._slope(placed, free.symbol)
        return Rows(
            self.unknowns, values, derivative[:, None], torque[None], self.rows.torque[None],
            np.ones((1, k), dtype=np.bool_), space, np.zeros((0, len(values) + 1)),
        )  # fmt: skip

    def _slope(self, placed: PlacedEffect, symbol: str) -> Floats:
        """Return (k,) change of torque per unit of a shape, N·m."""
        value = placed.shape()[symbol]
        small = SLOPE_STEP * value
        ends = [replace(placed, values={**placed.values, symbol: value + way * small}) for way in (1.0, -1.0)]
        return np.asarray((self.torque_of(ends[0]) - self.torque_of(ends[1])) / (2.0 * small))

    def reduced(self, values: Floats, weights: DriveSpace | None, renew: bool) -> tuple[Reduced, DriveSpace]:
        """Return the rows about values (p,), and their weights; see `stiffcal.estimation.solve.RowSource`."""
        space = weights or self.first_space
        made = self.about(values, space)
        if self.lasting_weights and weights is not None:
            space = space.reweighed(self.rows, made.white[-1], self.noise_known)
            made = replace(made, space=space)
        return made.reduced(), space

    def squares(self, values: Floats, reduced: Reduced, weights: DriveSpace) -> float:
        """Return the sum of squares of the rows about values (p,) under other weights."""
        return float(np.sum(self.about(values, weights).white[-1] ** 2))

    def corrected(self, values: Floats, reduced: Reduced, weights: DriveSpace) -> tuple[MotionSource, float]:
        """Return the source: its readings are not corrected."""
        return self, 0.0

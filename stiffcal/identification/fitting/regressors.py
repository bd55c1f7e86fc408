"""What an effect would add to the displacements of the present model: its regressor.

All about one balanced state of the robot: the rest is found once, and a candidate costs only its law and the levers of
its nodes. Regressors are linear in the amplitudes, at given shape parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Protocol, Self

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.derivatives.geometry_terms import geometry_terms
from stiffcal.identification.derivatives.observation import (
    ModelAtRest,
    Observations,
    predicted,
    rests,
)
from stiffcal.identification.derivatives.tangents import loads_at_rest, loads_under_weight
from stiffcal.identification.derivatives.weight_columns import weight_column
from stiffcal.identification.fitting.load_scale import is_proportional
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, EffectAtRest, NodeLoads, Observed, ParameterRole, Place
from stiffcal.model.laws.link_moments import LinkMoments

# Bytes of regressors that one source keeps: those of a hundred candidates for some 2500 full poses.
MOST_KEPT = 1 << 25


@dataclass(frozen=True)
class Regressor:
    """An effect's displacements per unit of its amplitudes."""

    effect: Effect
    """The effect."""
    place: Place
    """Where on the robot it acts."""
    shape: Mapping[str, float]
    """Values of the nonlinear parameters."""
    symbols: tuple[str, ...]
    """q amplitudes or set-up parameters."""
    columns: Floats
    """(q, m, n) displacement per unit of each."""
    fixed: Floats
    """(m, n) displacement without a free parameter (zero for most effects)."""

    def whole(self) -> Regressor:
        """Return it as it is: who needs all of a `StoredRegressor` has it made once."""
        return self


class RegressorMaker(Protocol):
    """Makes the regressors of effects about one model."""

    def shapes(self, effect: Effect, place: Place) -> list[dict[str, float]]:
        """Return the combinations of shape parameters to try; empty where nothing shows."""

    def regressor(self, effect: Effect, place: Place, shape: Mapping[str, float]) -> Regressor:
        """Return an effect's regressor about the present model."""


@dataclass(frozen=True)
class Linearised(ModelAtRest):
    """The present model at rest, to which effects are added."""

    @classmethod
    def about(cls, robot: CompliantRobot, data: Observations, for_memory: bool | None = True) -> Self:
        """Find the rests of a robot in all states, those under weight alone too: added laws may have a memory."""
        return super().about(robot, data, for_memory)

    @property
    def loads(self) -> NodeLoads:
        """What the nodes carry in all states."""
        return loads_at_rest(self.loaded, self.data)

    @property
    def bare(self) -> NodeLoads:
        """What the nodes carry under weight alone, at the temperature of the run's reference."""
        return loads_under_weight(self.loaded, self.unloaded, self.data)

    def lever(self, node: int, component: int) -> Floats | None:
        """Return (m, n) how the observations move with a node's small displacement; None where they do not."""
        moved = self.tangents.law_rows(node, component, under_weight=False)
        return moved if moved is not None and moved.any() else None

    def shapes(self, effect: Effect, place: Place) -> list[dict[str, float]]:
        """Return the combinations of shape parameters to try, from the effect's own grid; empty where nothing shows."""
        if not isinstance(effect, EffectAtRest):
            return []
        grid = effect.nonlinear_grid(place, self.robot.chain, self.loads)
        return [dict(zip(grid, values, strict=True)) for values in product(*(grid[s].tolist() for s in grid))]

    def regressor(self, effect: Effect, place: Place, shape: Mapping[str, float]) -> Regressor:
        """Return an effect's regressor about the present model."""
        data, added = self.data, PlacedEffect(effect, place, shape)
        under_load, under_weight = (
            [] if loads is None else added.terms(self.robot.chain, loads)
            for loads in (self.loads, self.tangents.loads_of_poses)
        )
        columns = self.tangents.law_columns(
            *(
                [(term.symbol, term) for term in terms if self.lever(term.node, term.component) is not None]
                for terms in (under_load, under_weight)
            )
        )

        def add(symbol: str, values: Floats) -> None:
            columns[symbol] = columns[symbol] + values if symbol in columns else values

        model = replace(self.robot, placed=(*self.robot.placed, added))
        for _, term in geometry_terms(model, (added,), data, self.loaded.inputs.angles):
            moved = self.tangents.geometry_rows(term.node, term.component)
            if moved.any():
                add(term.symbol, moved * term.value)
        observed = Observed(self.displacement, data.order, data.layout.held)
        for symbol, column in added.observation_columns(observed).items():
            add(symbol, data.layout.of_targets(column))
        for spec in effect.parameters:
            # A gain of the whole load is no addition to a model: its compliances make it up.
            if spec.scales_load and is_proportional(self.robot, data):
                continue
            if spec.role is ParameterRole.SETUP or (
                spec.role is ParameterRole.AMPLITUDE and spec.symbol not in columns
            ):
                difference = self._difference(effect, place, shape, spec.symbol, 1e-3 * spec.amplitude_of(spec.typical))
                if difference is not None:
                    add(spec.symbol, difference)
        # Most effects add nothing without a parameter: one zero stands for all.
        fixed = columns.pop("", np.broadcast_to(0.0, data.measured.shape))
        symbols = tuple(columns)
        stack = np.stack([columns[s] for s in symbols]) if symbols else np.zeros((0, *data.measured.shape))
        return Regressor(effect, place, dict(shape), symbols, stack, fixed)

    def _difference(
        self, effect: Effect, place: Place, shape: Mapping[str, float], symbol: str, step: float
    ) -> Floats | None:
        """Return the derivative by a parameter that changes the inputs, by difference of the whole balance."""
        if isinstance(effect, LinkMoments):
            column = weight_column(self.tangents, PlacedEffect(effect, place), symbol)
            return column if column.any() else None
        unit_effect = PlacedEffect(effect, place, {**shape, symbol: effect.spec(symbol).value_of(step)})
        shifted = replace(self.robot, placed=(*self.robot.placed, unit_effect))
        # solved as in `about`: the difference of two ways of solving would be an effect of its own
        loaded, unloaded = rests(shifted, self.data, for_memory=True)
        change = predicted(shifted, self.data, loaded, unloaded) - self.predicted
        return change / step if change.any() else None


class RegressorSource:
    """Makes regressors about one model again, so that a large campaign need not keep those of a hundred candidates.

    Parameters
    ----------
    robot : chain and effects with values. data : the observations.
    """

    def __init__(self, robot: CompliantRobot, data: Observations) -> None:
        self._robot, self._data = robot, data
        self._state: Linearised | None = None
        self._bytes_kept = 0

    def state(self) -> Linearised:
        """Return the model at rest, found anew where it was released."""
        if self._state is None:
            self._state = Linearised.about(self._robot, self._data)
        return self._state

    def release(self) -> None:
        """Let go of the model at rest: much larger than what it was found from."""
        self._state = None

    def kept(self, regressor: Regressor | StoredRegressor) -> Regressor | StoredRegressor:
        """Return the regressor itself as long as there is room (`MOST_KEPT`), else what it can be made from again."""
        if isinstance(regressor, StoredRegressor):
            return regressor
        size = regressor.columns.nbytes + (regressor.fixed.nbytes if regressor.fixed.any() else 0)
        if self._bytes_kept + size > MOST_KEPT:
            return StoredRegressor(regressor.effect, regressor.place, regressor.shape, regressor.symbols, self)
        self._bytes_kept += size
        return regressor


@dataclass(frozen=True)
class StoredRegressor:
    """A regressor whose columns are made when they are needed."""

    effect: Effect
    """The effect."""
    place: Place
    """Where on the robot it acts."""
    shape: Mapping[str, float]
    """Values of the nonlinear parameters."""
    symbols: tuple[str, ...]
    """q amplitudes or set-up parameters."""
    source: RegressorSource
    """Makes them."""

    def whole(self) -> Regressor:
        """Return the regressor with its columns."""
        return self.source.state().regressor(self.effect, self.place, self.shape)

    @property
    def columns(self) -> Floats:
        """(q, m, n) displacement per unit of each amplitude."""
        return self.whole().columns

    @property
    def fixed(self) -> Floats:
        """(m, n) displacement without a free parameter."""
        return self.whole().fixed

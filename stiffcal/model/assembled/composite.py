"""The modelled robot: a chain and the sum of the effects placed on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.abilities import FiniteShift
from stiffcal.model.effect import (
    Covariate,
    Effect,
    EffectAtRest,
    Geometry,
    Inputs,
    Instrument,
    Law,
    NodeLoads,
    Observed,
    ParameterRole,
    ParameterSpec,
    Place,
    Term,
    Values,
)
from stiffcal.model.forms import form_of
from stiffcal.model.scalar_laws import ScalarLaw


@dataclass(frozen=True)
class PlacedEffect:
    """An effect at one place, with values."""

    effect: Effect
    """The physics."""
    place: Place
    """Where."""
    values: Mapping[str, float] = field(default_factory=dict)
    """Symbol to value, in the units of the effect's parameters. Missing amplitudes count as neutral."""

    def parameter_name(self, symbol: str) -> str:
        """The parameter's full name, ``effect.place.symbol``."""
        return f"{self.effect.name}.{self.place.label}.{symbol}"

    @property
    def changes_geometry(self) -> bool:
        """Whether the effect moves the unloaded chain or its angles: its parameters count from the robot file."""
        effect = self.effect
        return isinstance(effect, Geometry) and type(effect).geometry_terms is not Geometry.geometry_terms

    @property
    def has_memory(self) -> bool:
        """Whether its law depends on the states before."""
        return isinstance(self.effect, Law) and self.effect.has_memory

    def terms(self, chain: Chain, loads: NodeLoads) -> Sequence[Term]:
        """Return its law as a sum of terms; none of an effect that is no law."""
        return self.effect.terms(self.place, chain, loads, self.shape()) if isinstance(self.effect, Law) else ()

    def scalar_laws(self, chain: Chain) -> Sequence[ScalarLaw]:
        """Return its law as data; none where it gives none."""
        effect = self.effect
        return effect.scalar_laws(self.place, chain, self.amplitudes()) if isinstance(effect, Law) else ()

    def adjusted_chain(self, chain: Chain, values: Values | None = None) -> Chain:
        """Return a chain as it is with these values, its own by default."""
        if not isinstance(self.effect, Geometry):
            return chain
        return self.effect.adjusted_chain(self.place, chain, self.values if values is None else values)

    def adjusted(self, inputs: Inputs, values: Values | None = None) -> Inputs:
        """Return inputs as they are with these values, its own by default."""
        if not isinstance(self.effect, Geometry | Instrument):
            return inputs
        return self.effect.adjusted(self.place, inputs, self.values if values is None else values)

    def geometry_terms(self, chain: Chain, angles: Floats) -> Sequence[Term]:
        """Return how its amplitudes move the undeformed chain at model angles (J, n); none where they do not."""
        effect = self.effect
        return effect.geometry_terms(self.place, chain, angles, self.shape()) if isinstance(effect, Geometry) else ()

    def observation_columns(self, observed: Observed) -> dict[str, Floats]:
        """Return amplitude symbol to (B, 6, n): what a unit of it adds to the readings; none where it adds nothing."""
        effect = self.effect
        return effect.observation_columns(self.place, observed, self.shape()) if isinstance(effect, Instrument) else {}

    def observation_shift(self, observed: Observed, values: Values | None = None) -> Floats | None:
        """Return (B, 6, n) by how much it shifts the readings with these values, its own by default; None: not at all.

        Of an instrument whose shift does not bend it is the sum of its columns, with its own values.
        """
        if isinstance(self.effect, FiniteShift):
            return self.effect.observation_shift(self.place, observed, self.values if values is None else values)
        columns = self.observation_columns(observed).items()
        parts = [self.amplitude(symbol) * column for symbol, column in columns if self.amplitude(symbol) != 0.0]
        return sum(parts[1:], parts[0]) if parts else None

    def covariate(self, chain: Chain, loads: NodeLoads) -> Covariate | None:
        """Return what its residual in load states follows; None where it follows nothing there."""
        effect = self.effect
        return effect.covariate(self.place, chain, loads) if isinstance(effect, EffectAtRest) else None

    def amplitude(self, symbol: str) -> float:
        """What the law multiplies with: the value, of stiffnesses its inverse, of gains what they differ from 1 by.

        Where no value is set it is 0. A term without a symbol has no free parameter and counts as it is.
        """
        if not symbol:
            return 1.0
        value = self.values.get(symbol)
        if value is None:
            return 0.0
        return self.effect.spec(symbol).amplitude_of(value)

    def shape(self) -> dict[str, float]:
        """Symbol to value of the shape parameters; typical sizes where none is set."""
        return {
            spec.symbol: self.values.get(spec.symbol, spec.typical)
            for spec in self.effect.parameters
            if spec.role is ParameterRole.NONLINEAR
        }

    def amplitudes(self) -> dict[str, float]:
        """Symbol to what the law computes with: amplitudes, and values of the shape parameters."""
        straight = self.specs(ParameterRole.AMPLITUDE)
        return {spec.symbol: self.amplitude(spec.symbol) for spec in straight} | self.shape()

    def specs(self, role: ParameterRole) -> tuple[ParameterSpec, ...]:
        """The effect's parameters of one sort."""
        return tuple(spec for spec in self.effect.parameters if spec.role is role)


@dataclass(frozen=True)
class CompliantRobot:
    """A chain whose nodes give."""

    chain: Chain
    """Geometry and masses."""
    placed: tuple[PlacedEffect, ...]
    """The effects, each at one place."""
    deformed: bool = True
    """True where the wrench acts on the deformed, weight-sagged chain (``balance = "deformed"``); False for the papers'
    first-order form.
    """

    background: tuple[PlacedEffect, ...] = ()
    """Effects that act with their values and are not in question: they have no columns and are nowhere listed."""

    @property
    def acting(self) -> tuple[PlacedEffect, ...]:
        """All effects that act."""
        return (*self.placed, *self.background)

    @cached_property
    def adjusted_chain(self) -> Chain:
        """The chain with what the effects change of its geometry and masses."""
        return self._chains[-1]

    @cached_property
    def _chains(self) -> tuple[Chain, ...]:
        """The chain, and as it is after each of the effects."""
        chains = [self.chain]
        for placed_effect in self.acting:
            chains.append(placed_effect.adjusted_chain(chains[-1]))
        return tuple(chains)

    @cached_property
    def _moved_joints(self) -> Booleans:
        """(effects, J) True where an acting effect moves the fixed transform to a joint."""
        fixed = np.stack([chain.fixed for chain in self._chains])
        return np.asarray(np.any(fixed[1:] != fixed[:-1], axis=(2, 3)))

    def fixed_with(self, number: int, values: Values) -> Floats:
        """Return the chain's (J, 4, 4) fixed transforms with other values of one of the acting effects, by its number.

        Of the effects after it those act anew that move a joint which it moves.
        """
        chain = self.acting[number].adjusted_chain(self._chains[number], values)
        moved = np.any(chain.fixed != self._chains[number + 1].fixed, axis=(1, 2))
        for later in np.flatnonzero((self._moved_joints[number + 1 :] & moved).any(axis=1)) + number + 1:
            chain = self.acting[later].adjusted_chain(chain)
        return np.where(moved[:, None, None], chain.fixed, self.adjusted_chain.fixed)

    @property
    def has_memory(self) -> bool:
        """True where a law depends on the states before."""
        return any(placed_effect.has_memory for placed_effect in self.acting)

    def with_values(self, values: Mapping[str, float]) -> CompliantRobot:
        """Return the robot with parameters set by full name; names that the model lacks are ignored."""
        return replace(self, placed=tuple(_with_values(placed_effect, values) for placed_effect in self.placed))

    def values(self) -> dict[str, float]:
        """Return every set value by full name."""
        return {
            placed_effect.parameter_name(symbol): value
            for placed_effect in self.placed
            for symbol, value in placed_effect.values.items()
        }


def _with_values(placed_effect: PlacedEffect, values: Mapping[str, float]) -> PlacedEffect:
    """Return an effect with the values that are its own, in the form of the law that they are of."""
    stem = placed_effect.parameter_name("")
    effect = form_of(placed_effect.effect, (name.removeprefix(stem) for name in values if name.startswith(stem)))
    values_of_effect = {
        spec.symbol: values[stem + spec.symbol] for spec in effect.parameters if stem + spec.symbol in values
    }  # fmt: skip
    return replace(placed_effect, effect=effect, values={**placed_effect.values, **values_of_effect})

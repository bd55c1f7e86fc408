"""The modelled robot: a chain and the sum of the effects placed on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Effect, ParameterRole, ParameterSpec, Place, Values
from stiffcal.model.forms import form_of


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
        return type(self.effect).geometry_terms is not Effect.geometry_terms

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
            chains.append(placed_effect.effect.adjusted_chain(placed_effect.place, chains[-1], placed_effect.values))
        return tuple(chains)

    def chain_with(self, number: int, values: Values) -> Chain:
        """Return the chain with other values of one of the acting effects, by its number."""
        chain = self._chains[number]
        chain = self.acting[number].effect.adjusted_chain(self.acting[number].place, chain, values)
        for placed_effect, before, after in zip(
            self.acting[number + 1 :], self._chains[number + 1 : -1], self._chains[number + 2 :], strict=True
        ):
            if after is not before:
                chain = placed_effect.effect.adjusted_chain(placed_effect.place, chain, placed_effect.values)
        return chain

    @property
    def has_memory(self) -> bool:
        """True where a law depends on the states before."""
        return any(placed_effect.effect.has_memory for placed_effect in self.acting)

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

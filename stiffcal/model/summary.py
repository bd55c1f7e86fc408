"""Which effects a model holds, and where, as results name them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from stiffcal.documents import OrAbsent

if TYPE_CHECKING:
    from stiffcal.model.effect import Place

Balance: TypeAlias = Literal["deformed", "first-order"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Where:
    """Where an effect sits; empty for the set-up."""

    joints: OrAbsent[list[int]] = None
    """Numbers, from 1."""
    links: OrAbsent[list[str]] = None
    """Names."""
    pairs: OrAbsent[list[list[int]]] = None
    """Numbers of two joints each."""

    @classmethod
    def of(cls, place: Place) -> Where:
        """Return a place as results name it."""
        if place.kind == "joints":
            return cls(joints=list(place.joints))
        if place.kind == "pairs":
            return cls(pairs=[list(place.joints)])
        return cls(links=[place.link]) if place.kind == "links" else cls()

    def items(self) -> Iterator[tuple[str, list[Any]]]:
        """Return the places by their kind, as far as there are any."""
        for kind, places in (("joints", self.joints), ("links", self.links), ("pairs", self.pairs)):
            if places:
                yield kind, places


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectAt:
    """An effect at a place."""

    effect: str
    """Its name."""
    where: Where
    """Its place."""


@dataclass(frozen=True, slots=True)
class EffectInModel:
    """An effect of a model, with its places."""

    type: str
    """The effect's name."""
    joints: OrAbsent[list[int]] = None
    """Numbers, from 1."""
    links: OrAbsent[list[str]] = None
    """Names."""
    pairs: OrAbsent[list[list[int]]] = None
    """Numbers of two joints each."""

    @property
    def where(self) -> Where:
        """Its places alone."""
        return Where(joints=self.joints, links=self.links, pairs=self.pairs)


@dataclass(frozen=True, slots=True)
class ModelSummary:
    """What a model holds."""

    balance: Balance
    """On which robot the wrench acts."""
    effects: list[EffectInModel]
    """Each effect once, with all its places."""

    def same_as(self, other: ModelSummary) -> bool:
        """Return whether two models hold the same effects at the same places, in whatever order."""
        return self.balance == other.balance and self._sorted() == other._sorted()

    def _sorted(self) -> list[tuple[str, list[tuple[str, list[str]]]]]:
        return sorted(
            (effect.type, [(kind, sorted(map(str, places))) for kind, places in effect.where.items()])
            for effect in self.effects
        )

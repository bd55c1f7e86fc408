"""A friction law of one drive in a fit: its effect, its shape and what of it is free."""

from __future__ import annotations

from dataclasses import dataclass, field

from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import ParameterRole


@dataclass
class DriveLaw:
    """One effect of one joint while it is being fitted: its shape, and what of it is free."""

    placed: PlacedEffect
    fixed: frozenset[str]
    shape: dict[str, float]
    free_nonlinear: list[str] = field(default_factory=list)
    """Symbols of the continuous shape parameters that are estimated."""
    chosen: list[str] = field(default_factory=list)
    """Symbols of the discrete ones, chosen among the values of a grid."""
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Symbol of each free shape parameter to how far it may go."""

    @property
    def joint(self) -> int:
        """The joint's number, from 1."""
        return self.placed.place.joints[0]

    @property
    def amplitudes(self) -> list[str]:
        """Symbols of the amplitudes."""
        return [spec.symbol for spec in self.placed.specs(ParameterRole.AMPLITUDE)]

    def held(self, symbol: str) -> bool:
        """Return whether the model file holds a parameter at its value."""
        return self.placed.parameter_name(symbol) in self.fixed


def initial_law(placed: PlacedEffect, fixed: frozenset[str]) -> DriveLaw:
    """Begin with the model file's shapes, else usual ones, and all free that is not fixed."""
    shapes = [spec for spec in placed.specs(ParameterRole.NONLINEAR) if placed.parameter_name(spec.symbol) not in fixed]
    return DriveLaw(
        placed,
        fixed,
        dict(placed.shape()),
        [spec.symbol for spec in shapes if not spec.discrete],
        [spec.symbol for spec in shapes if spec.discrete],
    )

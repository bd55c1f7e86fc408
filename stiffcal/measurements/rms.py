"""The size of residuals, measure by measure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Annotated, TypeAlias

from stiffcal.documents import KeyIf, NullIsNan, Number

Applicable: TypeAlias = Annotated[float | None, KeyIf(""), NullIsNan()]
"""None where the measure does not apply, NaN where it does and is not known."""


@dataclass(frozen=True, slots=True)
class Rms:
    """Square root of the mean squared length of a residual vector."""

    translation: Number
    """m"""
    rotation: Number
    """rad"""
    length: Applicable = None
    """m, of rods."""
    torque: Applicable = None
    """N·m, of clamped and friction runs."""
    motor_angle: Applicable = None
    """rad, of clamped runs."""

    def items(self) -> Iterator[tuple[str, Number]]:
        """Return the measures that apply, by name."""
        for field in fields(self):
            value: Number = getattr(self, field.name)
            if value is not None or field.name in ("translation", "rotation"):
                yield field.name, None if value is None or value != value else value

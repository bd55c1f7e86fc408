"""The size of residuals, measure by measure."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
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

    @classmethod
    def of(cls, measures: Mapping[str, Number]) -> Rms:
        """Return measure to value of those that apply; None where one is not known.

        Examples
        --------
        >>> list(Rms.of({"translation": 1e-4, "rotation": None, "length": None}).items())
        [('translation', 0.0001), ('rotation', None), ('length', None)]
        """
        always = ("translation", "rotation")
        return cls(
            **{name: math.nan if value is None and name not in always else value for name, value in measures.items()}
        )

    def items(self) -> Iterator[tuple[str, Number]]:
        """Return the measures that apply, by name."""
        for field in fields(self):
            value: Number = getattr(self, field.name)
            if value is not None or field.name in ("translation", "rotation"):
                yield field.name, None if value is None or value != value else value


@dataclass(frozen=True, slots=True, kw_only=True)
class VarianceRatio:
    """What a model leaves against the scatter of repeats."""

    statistic: Number
    """F, or the reduced χ²."""
    dof: list[Number]
    """Degrees of freedom of both sides; null where one is known exactly."""
    p_value: Number
    """Probability of so large a ratio by chance."""

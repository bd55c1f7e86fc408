"""What `compare` answers: the parameters of two fits, and how surely each has changed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.documents import CommandResult, KeyIf, NullIsNan, Number, Origin
from stiffcal.identification.answers.before_after import BeforeAfter
from stiffcal.model.summary import Where


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedValue:
    """A parameter in one of the two campaigns."""

    value: Number
    """Null where these data do not identify it."""
    std: Number
    """Its standard uncertainty."""
    stiffness: Annotated[float | None, KeyIf(""), NullIsNan()] = None
    """Of a compliance: its inverse, NaN where not known; None of others."""
    stiffness_std: Annotated[float | None, KeyIf(""), NullIsNan()] = None
    """Of a compliance: its standard uncertainty."""

    @property
    def known_stiffness(self) -> float | None:
        """The stiffness where there is one and it is known."""
        return None if self.stiffness is None or math.isnan(self.stiffness) else self.stiffness


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A parameter before and after."""

    name: str
    """As in parameter names."""
    effect: str
    """The effect's name."""
    where: Where
    """The effect's place."""
    unit: str
    """Of the value."""
    before: FittedValue
    """In the first campaign."""
    after: FittedValue
    """In the second."""
    change: Number
    """After minus before; null where a value or its uncertainty is not known."""
    relative: Number
    """The change over the value before."""
    std: Number
    """Standard uncertainty of the change."""
    p_value: Number
    """Two-sided probability of so large a change by chance, normal."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CompareResult(CommandResult):
    """Answer of ``compare``."""

    schema: Literal["stiffcal/compare/1"] = "stiffcal/compare/1"
    before: str
    """The first campaign's folder."""
    after: str
    """The second's."""
    parameters: list[Change]
    """Those that both models hold."""
    before_after: list[BeforeAfter]
    """The values of both campaigns with their 95 % intervals, of compliances the stiffness; also of `only_before` and
    `only_after`."""
    only_before: list[str]
    """Names of parameters that the second model does not hold."""
    only_after: list[str]
    """Names of parameters that the first model does not hold."""
    p_value_all: Number
    """Probability of so large changes of all of them together (χ² with the covariances of both fits)."""
    origin: Origin
    """From whom the fits come: somebody else's where one of them is."""
    changed: list[str]
    """Names whose change has a family-wise p below 0.01."""

"""How kinds of experiment agree on the parameters that each determines alone."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.documents import Number


@dataclass(frozen=True, slots=True, kw_only=True)
class CommonParameter:
    """A parameter that two kinds of experiment determine, each alone."""

    name: str
    """``effect.place.symbol``."""
    unit: str
    """Of the values."""
    first: float
    """By the first kind alone."""
    first_std: float
    """Its standard uncertainty."""
    second: float
    """By the second kind alone."""
    second_std: float
    """Its standard uncertainty."""
    standard_errors: float
    """Second minus first over the standard uncertainty of the difference."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """How two kinds of experiment agree on what both determine."""

    first: str
    """A kind of experiment, as `StateKind.name`: "loads", "clamped", "absolute"."""
    second: str
    """Another one."""
    parameters: list[CommonParameter]
    """What both determine, in the model's order."""
    statistic: float
    """dᵀ (C₁ + C₂)⁻¹ d of the differences d."""
    dof: int
    """Number of common parameters."""
    p_value: float
    """Probability of such differences or larger ones, where model and instruments are right."""
    agree: bool
    """Whether that is 0.001 or more."""
    reduced_chi2: list[Number]
    """Of both fits: far above 1 where the model lacks something, and uncertainties hold the instruments only."""

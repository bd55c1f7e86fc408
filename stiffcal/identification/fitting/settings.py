"""How to identify."""

from __future__ import annotations

from dataclasses import dataclass, field

from stiffcal.identification.noise.reading_noise import Noise


@dataclass(frozen=True)
class Settings:
    """How to identify."""

    loss: str = "linear"
    """"linear" (least squares) or "huber" (readings beyond 2.5 standard uncertainties count less)."""
    equal_weights: bool = False
    """Leave the wrench's noise out of the weights: every reading of a kind counts alike."""
    fixed: frozenset[str] = field(default_factory=frozenset)
    """Full parameter names that keep the model file's values."""
    noise: Noise | None = None
    """Take this noise instead of estimating it."""
    noise_dominated: frozenset[str] = field(default_factory=frozenset)
    """Full names of parameters that only the wrench's noise turns: not determined."""

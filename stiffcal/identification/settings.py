"""How to identify."""

from __future__ import annotations

from dataclasses import dataclass, field

from stiffcal.identification.noise import Noise


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
    undriven: frozenset[str] = field(default_factory=frozenset)
    """Full names of parameters of joints that were not driven while the flange was clamped: not determined."""
    redundant: frozenset[str] = field(default_factory=frozenset)
    """Full names of gains that all compliances together make up for: not determined, they keep their values."""
    same_motion: frozenset[str] = field(default_factory=frozenset)
    """Full names of geometry and frame parameters that others make up for in every pose: they stay neutral."""
    one_orientation: frozenset[str] = field(default_factory=frozenset)
    """Full names of frame parameters that other frames make up for in the measured poses: they stay neutral."""
    tilt_loaded: frozenset[str] = field(default_factory=frozenset)
    """Full names of compliances that weight loads no more than a turn of the base would: not determined."""
    common_scale: tuple[str, ...] = ()
    """Full names of moments and compliances with one unknown scale; the first of them keeps its value."""

"""What the answers of all kinds of experiment share."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.documents import Number


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldoutSection:
    """How one kind of experiment was judged on data that the fit did not use; it stands in ``validate``."""

    scheme: str
    """How it was done, in words."""
    n_readings: int
    rms: dict[str, Number]
    """By measure: "torque", N·m, and "motor_angle", rad."""
    noise: dict[str, Number]
    """Scatter of repeats by measure; a measure is left out where they are too few."""
    zero_model: dict[str, Number]
    """What a model without parameters leaves, by measure."""

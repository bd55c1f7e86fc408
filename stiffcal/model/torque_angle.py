"""What a clamped joint's torque over angle gives the effects."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class TorqueAngle:
    """What a clamped joint's torque over angle gives, each a value with its standard uncertainty, SI."""

    curve: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    """p1, p2, p3 of τ = p1 φ + p2 φ² + p3 φ³, counted from the flank."""
    compliance: tuple[float, float]
    """rad/(N·m), from the flanks to the ends of what was reached."""
    width: tuple[float, float]
    """rad, lost motion; (0, std) where none was found."""
    band: tuple[float, float] | None
    """N·m within which it is crossed; None without play."""

"""What the pages on friction show of each joint."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class FrictionCurve:
    """Friction of one drive over its velocity.

    Attributes
    ----------
    joint : its name. steady : True where passes at constant velocity were measured, False for samples of other motion.
    velocity : (n,) rad/s, signed. friction : (n,) N·m, as measured, weight, inertia and zeros taken off.
    speed : (m,) rad/s, rising. fitted, std : (m,) N·m, the curve and its standard uncertainty.
    parameters : (symbol, value, half width of the 95 % interval, unit) of what is known; half width None where held.
    remarks : what is not seen, and why.
    rms, noise : N·m; the noise None where no repeats tell it.
    """

    joint: str
    steady: bool
    velocity: Floats
    friction: Floats
    speed: Floats
    fitted: Floats
    std: Floats
    parameters: tuple[tuple[str, float, float | None, str], ...]
    remarks: tuple[str, ...]
    rms: float
    noise: float | None

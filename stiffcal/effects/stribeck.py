"""More friction at crawling speed."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import ParameterRole, ParameterSpec, Place, Values
from stiffcal.model.motion import Motion

_SOURCE = "a third of a drive's Coulomb friction, as drawn in Lehmann et al. 2013, figure 4"
_VELOCITY = "minimum of friction at a few per cent of the rated speed (Bittencourt and Gunnarsson 2012)"
_EXPONENT = "1 (exponential) and 2 (Gaussian) are usual, 0.5 to 1.3 measured (Armstrong-Hélouvry et al. 1994)"
# Coulomb and viscous friction and the three parameters of the law itself are not known from fewer.
LEAST_SPEEDS = 4
_EXPONENTS = (0.5, 1.0, 1.3, 2.0)


class Stribeck(Motion):
    """Friction of a moving joint increases towards very low speed, where the lubricant does not separate the surfaces.

    Law: τ_f += F exp(−|ω/ω_S|^α) sign(ω), with stribeck F, velocity ω_S, exponent α; ω and τ_f at the joint's side of
    the gear (Armstrong-Hélouvry, Dupont and Canudas de Wit 1994; Lehmann et al. 2013, eq. 1, after Bittencourt et al.
    2010). It comes on top of joint-friction.

    Assumes steady motion at constant temperature. After Bittencourt and Gunnarsson 2012 ω_S grows with load and
    temperature.

    Limits: ω_S is known only where some speeds lie below it and some above; a Stribeck term that has vanished below the
    lowest speed is not identifiable, and one that has not vanished at the highest speed counts as Coulomb friction.
    Load states are taken at rest; there friction shows as friction-hysteresis.
    """

    name = "stribeck"
    summary = "friction increases towards very low speed"
    parameters = (
        ParameterSpec("stribeck", "N·m", "additional friction at very low speed", 0.0, 1e5, 20.0, _SOURCE),
        ParameterSpec(
            "velocity", "rad/s", "speed at which it has decreased to 1/e", 1e-5, 10.0, 0.05, _VELOCITY,
            ParameterRole.NONLINEAR,
        ),
        ParameterSpec("exponent", "1", "exponent of the decrease", 0.3, 4.0, 1.3, _EXPONENT, ParameterRole.NONLINEAR),
    )  # fmt: skip
    needs = ("friction runs: both directions at four speeds or more, some of them slow",)
    looks_like = ("viscous-power", "presliding", "joint-friction")
    least_speeds = LEAST_SPEEDS
    fingerprint = "torque over speed rises towards standstill, in both directions"
    how_to_check = "Add speeds of 1 to 5 % of the rated speed, both ways: friction increases as the joint slows down."

    def torque_columns(self, velocity: Floats, shape: Values) -> dict[str, Floats]:
        """Return the (n,) torque per N·m of it at velocities (n,), rad/s."""
        fading = np.exp(-(np.abs(velocity / shape["velocity"]) ** shape["exponent"]))
        return {"stribeck": fading * np.sign(velocity)}

    def motion_grid(self, place: Place, chain: Chain, motion: DriveMotion) -> dict[str, Floats]:
        """Speeds from half the slowest to half the fastest: below or above it would be no or Coulomb friction."""
        speed = motion.speeds()
        spec = self.spec("velocity")
        if len(speed) < 2:
            return {"velocity": np.zeros(0), "exponent": np.array(_EXPONENTS)}
        low, high = np.clip([0.5 * speed[0], 0.5 * speed[-1]], spec.lower, spec.upper)
        values = np.geomspace(low, high, 10) if high > 1.01 * low else np.array([low])
        return {"velocity": np.clip(values, low, high), "exponent": np.array(_EXPONENTS)}

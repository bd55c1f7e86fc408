"""Friction over speed on a curve."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import ParameterRole, ParameterSpec, Place, Values
from stiffcal.model.motion import Motion

LEAST_SPEEDS = 4
# Powers nearer to 0 are Coulomb friction, nearer to 1 viscous friction.
BELOW_ONE, ABOVE_ONE = (0.1, 0.8), (1.2, 2.0)
_POWERS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.2, 1.4, 1.6, 1.8, 2.0)


class ViscousPower(Motion):
    """Friction grows with a power of the speed: below one for shearing grease, above one for churning oil.

    Law: τ_f += factor |ω|^power sign(ω), with power from 0.1 to 0.8 or from 1.2 to 2; ω and τ_f at the joint's side of
    the gear. It comes on top of joint-friction: where friction follows the power alone, [viscous] there becomes zero.
    Friction that grows less than in proportion to speed is what Bittencourt and Gunnarsson 2012 and others measure on
    industrial robots; churning of oil grows with the square.

    Assumes constant temperature: fast motion warms the lubricant, which bends the curve as well.

    Limits: near 0 it is Coulomb friction and near 1 viscous friction, therefore the gaps. Speeds over a decade are
    needed to distinguish it from friction that rises at very low speed (stribeck).
    """

    name = "viscous-power"
    summary = "friction increases with a power of the speed other than one"
    parameters = (
        ParameterSpec(
            "factor", "N·m·(s/rad)^power", "friction at 1 rad/s", 0.0, 1e6, 50.0,
            "viscous friction of 100 N·m·s/rad of a large joint, half of it nonlinear",
        ),
        ParameterSpec(
            "power", "1", "power of the speed", BELOW_ONE[0], ABOVE_ONE[1], 0.6,
            "0.5 to 0.7 for shearing grease, 2 for churning oil",
            ParameterRole.NONLINEAR,
        ),
    )  # fmt: skip
    needs = ("friction runs: both directions at four speeds or more",)
    looks_like = ("stribeck", "friction-temperature", "joint-friction")
    least_speeds = LEAST_SPEEDS
    fingerprint = "torque over speed is curved up to the highest speed, in both directions"
    how_to_check = (
        "Add higher and lower speeds: on logarithmic axes, friction minus Coulomb friction has a slope other than 1."
    )

    def torque_columns(self, velocity: Floats, shape: Values) -> dict[str, Floats]:
        """Return the (n,) torque per unit of the factor at velocities (n,), rad/s."""
        return {"factor": np.abs(velocity) ** shape["power"] * np.sign(velocity)}

    def motion_grid(self, place: Place, chain: Chain, motion: DriveMotion) -> dict[str, Floats]:
        """Powers on either side of one."""
        return {"power": np.array(_POWERS)}

    def impossible(self, values: Values) -> str | None:
        """Return why a power cannot be: within the gap about one."""
        power = values.get("power", _POWERS[0])
        if BELOW_ONE[1] < power < ABOVE_ONE[0]:
            return f"a power between {BELOW_ONE[1]:g} and {ABOVE_ONE[0]:g} is viscous friction"
        return None

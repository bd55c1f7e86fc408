"""Friction that grows with the load on the drive."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import Covariate, ParameterSpec, Place, Values
from stiffcal.model.motion import Motion

# Loads whose sizes differ by less than this share of the largest are one load.
LEAST_SPREAD = 0.1


class FrictionLoad(Motion):
    """The friction of a moving joint increases under load, with the contact forces of teeth and bearings.

    Law: τ_f += per_Nm |τ| sign(ω), with τ the joint's load: the torque of the weight of arm and tool about its axis
    (Bittencourt and Gunnarsson 2012, where Coulomb friction grows linearly with the size of the load torque; ω at the
    joint's side of the gear). It comes on top of joint-friction.

    Assumes that the masses in robot.toml are right: the load is computed from them.

    Limits: where gravity does not act about the joint's axis, or the joint is moved at one angle only, no load changes
    and it cannot be distinguished from Coulomb friction. In a gear whose efficiency differs between driving and being
    driven, this is the mean of both.
    """

    name = "friction-load"
    summary = "friction of a moving joint increases with the torque of the weight"
    parameters = (
        ParameterSpec(
            "per_Nm", "1", "friction per load torque", 0.0, 1.0, 0.02,
            "a few per cent of the load torque (Bittencourt and Gunnarsson 2012, experiments on an ABB IRB 6620)",
        ),
    )  # fmt: skip
    needs = ("friction runs: both directions at angles with different weight torques", "masses in robot.toml")
    looks_like = ("joint-friction", "friction-temperature", "torque-ripple")
    fingerprint = (
        "half the difference between the torques of the two directions increases with the torque of the weight"
    )
    how_to_check = (
        "Repeat one speed, in both directions, with the arm stretched out, hanging down, and with a known tool weight."
    )

    def lacking_motion(self, chain: Chain, motion: DriveMotion) -> str | None:
        """Both directions, and a known load of several sizes."""
        size = np.abs(motion.load)
        if not size.any():
            return "the load on the joint: masses in robot.toml, and an axis about which their weight acts"
        one_way = super().lacking_motion(chain, motion)
        if one_way is not None:
            return one_way
        if float(np.ptp(size)) < LEAST_SPREAD * float(size.max()):
            return "motion at angles where the weight's torque differs in size"
        return None

    def motion_columns(self, place: Place, chain: Chain, motion: DriveMotion, shape: Values) -> dict[str, Floats]:
        """|τ| sign ω."""
        return {"per_Nm": np.abs(motion.load) * np.sign(motion.velocity)}

    def motion_covariate(self, place: Place, chain: Chain, motion: DriveMotion) -> Covariate:
        """The load."""
        return Covariate("torque of the weight", "N·m", motion.load)

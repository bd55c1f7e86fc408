"""Friction that builds up after a reversal."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import Covariate, ParameterRole, ParameterSpec, Place, Values
from stiffcal.model.motion import Motion

_SOURCE = "twice a drive's Coulomb friction of 50 N·m built up over 2 mrad of the joint"
# A log that begins later after each reversal, as a share of the longest travel, misses the build-up.
NEAR = 0.3


class Presliding(Motion):
    """After a reversal, friction builds up over a small angle like a spring, instead of changing sign at once.

    Law: τ_f += −stiffness · angle · exp(−s/angle) sign(ω), with s the travel since the direction last changed. It is
    Dahl's solid friction (Dahl 1968; "presliding displacement" in Armstrong-Hélouvry, Dupont and Canudas de Wit 1994)
    counted from joint-friction, which jumps: after a whole reversal dF/ds = σ (1 − F/F_C sign ω) gives F = F_C (1 − 2
    exp(−σ s/F_C)), so that angle is F_C/σ and the stiffness 2 σ, the slope right after the reversal; ω and s at the
    joint's side of the gear.

    Assumes that friction was fully built up before each reversal, and that it does not depend on speed as it builds up.

    Limits: it shows within some angles after a reversal only, in a log that runs through reversals. The drive's own
    wind-up and backlash, measured by the encoder of the motor, have the same effect: clamp the joint to distinguish
    them.
    """

    name = "presliding"
    summary = "friction builds up over a small angle after a reversal"
    parameters = (
        ParameterSpec("stiffness", "N·m/rad", "slope of friction directly after a reversal", 0.0, 1e9, 5e4, _SOURCE),
        ParameterSpec(
            "angle", "rad", "travel constant (1/e of the friction still missing)", 1e-6, 0.5, 2e-3, _SOURCE,
            ParameterRole.NONLINEAR,
        ),
    )  # fmt: skip
    needs = ("friction runs: logs that contain reversals of direction",)
    looks_like = ("stribeck", "joint-friction")
    fingerprint = "directly after each reversal the torque is too small, and recovers over the same small angle"
    how_to_check = (
        "Move back and forth by one degree at very low speed: torque over angle forms a loop with rounded corners."
    )

    def lacking_motion(self, chain: Chain, motion: DriveMotion) -> str | None:
        """Samples soon after a reversal."""
        known = motion.travel[np.isfinite(motion.travel)]
        if not known.size:
            return "logs that contain reversals of direction"
        if float(known.min()) > NEAR * float(known.max()):
            return "samples soon after a reversal of the direction"
        return None

    def motion_columns(self, place: Place, chain: Chain, motion: DriveMotion, shape: Values) -> dict[str, Floats]:
        """−angle exp(−s/angle) sign ω; nothing where the last reversal is not logged."""
        missing = np.nan_to_num(np.exp(-motion.travel / shape["angle"]))
        return {"stiffness": -shape["angle"] * missing * np.sign(motion.velocity)}

    def motion_grid(self, place: Place, chain: Chain, motion: DriveMotion) -> dict[str, Floats]:
        """Angles that some samples lie within, up to a third of the longest travel."""
        known = np.sort(motion.travel[motion.travel > 0.0])
        spec = self.spec("angle")
        if not known.size:
            return {"angle": np.zeros(0)}
        low = known[min(len(known) - 1, len(known) // 200)]
        low, high = np.clip([low, max(known[-1] / 3.0, low)], spec.lower, spec.upper)
        values = np.geomspace(low, high, 9) if high > 1.01 * low else np.array([low])
        return {"angle": np.clip(values, low, high)}

    def motion_covariate(self, place: Place, chain: Chain, motion: DriveMotion) -> Covariate:
        """The travel since the reversal; 0 where that is not logged."""
        return Covariate("travel since the reversal", "rad", np.nan_to_num(motion.travel))

"""Friction that changes as the drive warms up."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.varying import varies
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import Covariate, ParameterSpec, Place, Values
from stiffcal.model.motion import Motion

_SOURCE = (
    "viscous friction decreases by a few per cent per kelvin with the viscosity of the lubricant (Bittencourt "
    "and Gunnarsson 2012)"
)


class FrictionTemperature(Motion):
    """The friction of a drive decreases as it warms up, mostly at speed, because the viscosity of its lubricant falls.

    Law: τ_f += (coulomb_K sign(ω) + viscous_K ω) (T − T_ref), with T the first temperature that the campaign logs and
    T_ref its first reading; ω at the joint's side of the gear. This is the linear part of what Bittencourt and
    Gunnarsson 2012 measured on an industrial robot. Coulomb and viscous friction of joint-friction are those at T_ref.

    Assumes one temperature for the whole drive. Viscosity falls exponentially: over more than some 20 K a straight line
    is not sufficient.

    Limits: a drive that warms up once, steadily, cannot show whether temperature or time is the cause (running in, a
    drifting amplifier): let it cool down and repeat. A thermometer on the housing lags behind the lubricant.
    """

    name = "friction-temperature"
    summary = "Coulomb and viscous friction change linearly with the temperature"
    parameters = (
        ParameterSpec("coulomb_K", "N·m/K", "change of Coulomb friction per kelvin", -1e4, 1e4, -0.5, _SOURCE),
        ParameterSpec("viscous_K", "N·m·s/(rad·K)", "change of viscous friction per kelvin", -1e5, 1e5, -2.0, _SOURCE),
    )
    needs = ("friction runs: both directions", "a temperature that changes")
    looks_like = ("friction-load", "viscous-power")
    fingerprint = "the torque at the same speed decreases as the logged temperature rises"
    how_to_check = "Repeat the same speeds with the drive cold, warm and cold again: friction follows the temperature."

    def lacking_motion(self, chain: Chain, motion: DriveMotion) -> str | None:
        """Both directions, and a temperature that changes."""
        if not np.isfinite(motion.temperature).any():
            return "a temperature in the logs of the friction runs"
        one_way = super().lacking_motion(chain, motion)
        if one_way is not None:
            return one_way
        if not varies(motion.temperature[np.isfinite(motion.temperature)]):
            return "a temperature that changes during the friction runs"
        return None

    def motion_columns(self, place: Place, chain: Chain, motion: DriveMotion, shape: Values) -> dict[str, Floats]:
        """(T − T_ref) sign ω and (T − T_ref) ω; nothing where no temperature was logged."""
        warmer = np.nan_to_num(motion.temperature)
        return {"coulomb_K": warmer * np.sign(motion.velocity), "viscous_K": warmer * motion.velocity}

    def motion_covariate(self, place: Place, chain: Chain, motion: DriveMotion) -> Covariate:
        """The temperature."""
        return Covariate("temperature above the first reading", "K", np.nan_to_num(motion.temperature))

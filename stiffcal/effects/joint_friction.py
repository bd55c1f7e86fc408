"""Friction of a moving joint."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.model.effect import ParameterSpec, Values
from stiffcal.model.motion import Motion

_SOURCE = "a few per cent of a large joint's rated torque of 10³ N·m; shape as drawn in Lehmann et al. 2013, figure 4"


class JointFriction(Motion):
    """Friction of a moving joint: Coulomb friction, and viscous friction in proportion to speed.

    Law: τ_f(ω) = F_C sign(ω) + F_V ω: coulomb F_C, viscous F_V; ω and τ_f at the joint's side of the gear (Lehmann et
    al. 2013, eq. 1, after Bittencourt et al. 2010, without its Stribeck term; the Coulomb and viscous model in
    Armstrong-Hélouvry, Dupont and Canudas de Wit 1994).

    Assumes steady motion at constant temperature and load. Further terms are separate effects: stribeck, viscous-power,
    friction-load, friction-temperature, friction-asymmetry, torque-ripple, presliding.

    Limits: it is measured in friction runs, with the joint moving in both directions at constant speeds. Load states
    are taken at rest; there friction shows as friction-hysteresis.
    """

    name = "joint-friction"
    summary = "Coulomb and viscous friction of a moving joint"
    parameters = (
        ParameterSpec("coulomb", "N·m", "Coulomb friction", 0.0, 1e5, 50.0, _SOURCE),
        ParameterSpec("viscous", "N·m·s/rad", "friction in proportion to speed", 0.0, 1e6, 100.0, _SOURCE),
    )
    needs = ("friction runs: joint velocity and torque, best at constant speeds both ways",)
    looks_like = ("friction-hysteresis", "stribeck", "viscous-power")
    fingerprint = "the motor torque changes sign with the direction of motion and increases with speed"
    how_to_check = "Move the joint back and forth at several constant speeds and log motor torque against velocity."

    def torque_columns(self, velocity: Floats, shape: Values) -> dict[str, Floats]:
        """Return the (n,) torque per unit of each amplitude at velocities (n,), rad/s."""
        return {"coulomb": np.sign(velocity), "viscous": np.asarray(velocity)}

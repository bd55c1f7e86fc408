"""Friction of a moving joint."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import DocumentedEffect, Kind, ParameterRole, ParameterSpec, Values

_SOURCE = "some per cent of a large joint's rated torque of 10³ N·m; shape as drawn in paper 004, figure 4"


class JointFriction(DocumentedEffect):
    """A moving joint resists: by dry friction, by more of it at crawling speed, and in proportion to speed.

    Law: τ_f(ω) = (F_C + F_S exp(−|ω/ω_S|^α)) sign(ω) + F_V ω (paper 004, eq. 1, after Bittencourt et al. 2010): coulomb
    F_C, stribeck F_S, velocity ω_S, exponent α, viscous F_V; ω and τ_f at the joint's side of the gear.

    Assumes steady motion at constant temperature: lubricants thin out by half within a morning's work. The Stribeck
    terms are kept only where crawling speeds show them.

    Limits: it is measured in friction runs, the joint moving both ways at constant speeds. Load states are taken at
    rest; there friction shows as friction-hysteresis.
    """

    name = "joint-friction"
    kind = Kind.NODE_LAW
    place_kind = "joints"
    summary = "Coulomb, Stribeck and viscous friction of a moving joint"
    parameters = (
        ParameterSpec("coulomb", "N·m", "dry friction", 0.0, 1e5, 50.0, _SOURCE),
        ParameterSpec("stribeck", "N·m", "what comes on top at crawling speed", 0.0, 1e5, 20.0, _SOURCE),
        ParameterSpec(
            "velocity", "rad/s", "speed at which that has faded", 1e-5, 10.0, 0.05, _SOURCE, ParameterRole.NONLINEAR
        ),
        ParameterSpec("exponent", "1", "how sharply it fades", 0.3, 4.0, 1.3, _SOURCE, ParameterRole.NONLINEAR),
        ParameterSpec("viscous", "N·m·s/rad", "friction in proportion to speed", 0.0, 1e6, 100.0, _SOURCE),
    )
    needs = ("friction runs: joint velocity and torque, best at constant speeds both ways",)
    looks_like = ("friction-hysteresis",)
    in_motion = True
    optional = MappingProxyType({"stribeck": ("velocity", "exponent")})
    fingerprint = "the motor's torque changes its sign with the direction of motion and grows with speed"
    how_to_check = "Move the joint to and fro at several constant speeds and log motor torque against velocity."

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Load states are taken at rest."""
        return "friction runs: load states are taken at rest"

    def torque_columns(self, velocity: Floats, shape: Values) -> dict[str, Floats]:
        """Return amplitude symbol to (n,) torque per unit of it.

        Parameters
        ----------
        velocity : (n,) rad/s, as logged.
        shape : ``velocity`` and ``exponent``.
        """
        direction = np.sign(velocity)
        fading = np.exp(-(np.abs(velocity / shape["velocity"]) ** shape["exponent"]))
        return {"coulomb": direction, "stribeck": fading * direction, "viscous": np.asarray(velocity)}

    def friction_torque(self, velocity: Floats, values: Values) -> Floats:
        """Return (n,) τ_f at velocities (n,), rad/s."""
        columns = self.torque_columns(velocity, values)
        return np.asarray(sum(values[symbol] * column for symbol, column in columns.items()))

"""Friction over speed as paper 004 writes it (eq. 1), for simulations of the tests."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stiffcal.arrays import Floats


def friction_torque(velocity: Floats, values: Mapping[str, float]) -> Floats:
    """Return (n,) N·m: (F_C + F_S exp(−|ω/ω_S|^α)) sign ω + F_V ω at velocities (n,), rad/s.

    Parameters
    ----------
    values : coulomb F_C, viscous F_V, and where there is Stribeck friction stribeck F_S, velocity ω_S, exponent α.
    """
    dry = np.full(len(velocity), values["coulomb"])
    if values.get("stribeck", 0.0):
        dry = dry + values["stribeck"] * np.exp(-(np.abs(velocity / values["velocity"]) ** values["exponent"]))
    return np.asarray(dry * np.sign(velocity) + values["viscous"] * velocity)

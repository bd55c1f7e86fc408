"""Friction that differs between the two directions."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import ParameterSpec, Place, Values
from stiffcal.model.motion import Motion


class FrictionAsymmetry(Motion):
    """The friction of a moving joint differs between the two directions by a constant torque.

    Law: τ_f += offset, whatever speed and direction, with τ_f the torque of friction: Coulomb friction is coulomb +
    offset forwards and coulomb − offset backwards (Armstrong-Hélouvry, Dupont and Canudas de Wit 1994 report different
    friction in the two directions of many mechanisms). It replaces the constants that are otherwise free at each
    speed.

    Assumes that neither weight nor a spring acts about the axis, or that both are in the model.

    Limits: an offset of the torque sensor or of the motor current is the same constant: the two cannot be distinguished
    unless the sensor's zero is known, by readings at rest of a joint without load.
    """

    name = "friction-asymmetry"
    summary = "friction differs between the two directions by a constant torque"
    parameters = (
        ParameterSpec(
            "offset", "N·m", "half the difference between forward and backward friction", -1e5, 1e5, 2.0,
            "a few per cent of a drive's Coulomb friction of 50 N·m",
        ),
    )  # fmt: skip
    needs = ("friction runs: both directions at several speeds",)
    fingerprint = "the mean of both directions' torques is the same at all speeds and angles, and not zero"
    how_to_check = "Read the torque at rest without any load: a remaining value is the zero offset of the sensor."

    def motion_columns(self, place: Place, chain: Chain, motion: DriveMotion, shape: Values) -> dict[str, Floats]:
        """One, everywhere."""
        return {"offset": np.ones(len(motion))}

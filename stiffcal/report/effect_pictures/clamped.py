"""What an effect does to the motor angle of a clamped joint, computed by its own law on a lever with one drive."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Effect, Observed, ParameterRole, Place, StateOrder
from stiffcal.model.held_frame import HeldFrame
from stiffcal.quantity import ANGLE, MOMENT
from stiffcal.report.content import EffectPicture

# rad/(N·m) and N·m of the example's drive.
COMPLIANCE, LARGEST_TORQUE = 2e-6, 400.0
# The effect is drawn as large as this share of the drive's own deflection.
DRAWN_SIZE = 0.4
# m and rad of the held frame per radian of the joint, which turns about z at the other end of a lever of one metre.
_JACOBIAN = np.array([0.0, 1.0, 0.0, 0.0, 0.0, 1.0])


def clamped_picture(
    effect: Effect, place: Place, order: StateOrder, level: Floats, unloading: Booleans
) -> EffectPicture | None:
    """Return a clamped motor's angle over torque, without and with an effect; None where it adds nothing.

    Parameters
    ----------
    order : of the n states. level : (n,) torque as a share of the largest. unloading : (n,) True on the way back.
    """
    torque, n = LARGEST_TORQUE * level, len(level)
    inverse = _JACOBIAN / float(_JACOBIAN @ _JACOBIAN)
    n_joints = order.motor.shape[0]
    held = HeldFrame(
        target=0,
        inverse=np.tile(inverse[None, :, None], (n_joints, 1, n)),
        jacobian=np.tile(_JACOBIAN[:, None, None], (1, n_joints, n)),
        wrench=np.outer(inverse, torque),
    )
    columns = PlacedEffect(effect, place).observation_columns(Observed(np.zeros((1, 6, n)), order, held))
    amplitudes = {
        spec.symbol: spec.amplitude_of(spec.typical)
        for spec in effect.parameters
        if spec.role is ParameterRole.AMPLITUDE
    }
    added = np.asarray(sum((amplitudes[s] * (inverse @ column[0]) for s, column in columns.items()), np.zeros(n)))
    if not added.any():
        return None
    without = COMPLIANCE * torque
    added = added * (DRAWN_SIZE * np.abs(without).max() / np.abs(added).max())
    text = (effect.fingerprint or effect.summary).rstrip(".")
    angle = ANGLE.usual
    return EffectPicture(
        effect.name, MOMENT.usual.in_brackets("torque on the clamped joint"), angle.in_brackets("angle of the motor"),
        torque, angle.factor * without, angle.factor * (without + added),
        unloading if np.ptp(added[torque == 0.0]) > 0.0 else np.zeros(n, dtype=np.bool_),
        f"Effect of {effect.name} on the motor of a clamped joint, exaggerated: {text}.",
    )  # fmt: skip

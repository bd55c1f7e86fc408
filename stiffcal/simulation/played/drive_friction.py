"""What the drives need against friction while they move, by the laws of the model's own effects."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.drive_motion import DriveMotion, travel_since_reversal
from stiffcal.model.motion import Motion


def friction_torque(
    robot: CompliantRobot, joints: Floats, velocity: Floats, load: Floats, time: Floats, warmer: Floats
) -> Floats:
    """Return (s, L) torques that the drives need in addition, N·m.

    Parameters
    ----------
    robot : chain and effects with values; those that show in motion make the friction.
    joints : (s, L) logged angles, rad. velocity : (s, L) rad/s.
    load : (s, L) N·m that the drives carry.
    time : (s,) s from the run's start. warmer : (s,) K above the campaign's first temperature.
    """
    torque = np.zeros_like(velocity)
    for placed in robot.placed:
        if not isinstance(placed.effect, Motion):
            continue
        k = placed.place.joints[0] - 1
        travel = travel_since_reversal(joints[:, k], velocity[:, k])
        motion = DriveMotion(velocity[:, k], joints[:, k], load[:, k], warmer, time, travel)
        columns = placed.effect.motion_columns(placed.place, robot.chain, motion, placed.shape())
        # What a drive that stands still needs against friction is not determined: its brake holds it.
        moves = velocity[:, k] != 0.0
        for symbol, column in columns.items():
            torque[:, k] += np.where(moves, placed.amplitude(symbol) * column, 0.0)
    return torque

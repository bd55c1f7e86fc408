"""Which friction parameters a joint's motion cannot determine, and why: one direction, one speed, collinear terms."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from stiffcal.arrays import Floats

# Share of a column's length that must be left once weight, inertia and zeros are taken out. Below it the standard
# uncertainty is a thousand times that of the parameter alone, and the drift of a logged speed decides the value.
LEAST_SHARE = 1e-3
# Speeds that differ by less than this share are one: no servo holds a speed more closely.
ONE_SPEED = 0.02


class MotionLack(StrEnum):
    """What the motion of a joint lacks to determine its friction."""

    ONE_DIRECTION = "one-direction"
    """It moved one way only."""
    ONE_SPEED = "one-speed"
    """It moved both ways, at one speed only."""
    COLLINEAR = "collinear"
    """Terms of the model do the same at all speeds, angles and times that were logged."""
    SHAPE = "shape"
    """It does not show how a law bends: a shape is held at its usual value."""

    @property
    def sentence(self) -> str:
        """The reason and the cure."""
        return _SENTENCES[self]


_SENTENCES = {
    MotionLack.ONE_DIRECTION: (
        "moved in one direction only: friction, weight and the zero offset of the torque cannot be distinguished; "
        "move it in both directions"
    ),
    MotionLack.ONE_SPEED: (
        "moved at one speed only: Coulomb and viscous friction cannot be distinguished; add runs at other speeds"
    ),
    MotionLack.COLLINEAR: (
        "in these motions it cannot be distinguished from the other terms of the model; add other speeds or angles"
    ),
    MotionLack.SHAPE: "not identifiable from these data; the usual value is used",
}


def motion_lack(velocity: Floats) -> MotionLack | None:
    """Return what velocities (n,) rad/s of one joint's readings lack; None where nothing.

    Examples
    --------
    >>> import numpy as np
    >>> motion_lack(np.array([0.5, 1.0])), motion_lack(np.array([0.5, -0.5])), motion_lack(np.array([0.5, -1.0]))
    (<MotionLack.ONE_DIRECTION: 'one-direction'>, <MotionLack.ONE_SPEED: 'one-speed'>, None)
    """
    if velocity.size and (np.all(velocity > 0.0) or np.all(velocity < 0.0)):
        return MotionLack.ONE_DIRECTION
    speed = np.abs(velocity)
    if speed.size and float(np.ptp(speed)) <= ONE_SPEED * float(speed.max()):
        return MotionLack.ONE_SPEED
    return None

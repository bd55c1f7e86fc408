"""The motion of one drive, for effects that show in the torque of a moving joint."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers


@dataclass(frozen=True)
class DriveMotion:
    """What one drive does in n samples of free motion, at the joint's side of the gear."""

    velocity: Floats
    """(n,) rad/s, as logged."""
    angle: Floats
    """(n,) rad, as the controller shows it."""
    load: Floats
    """(n,) N·m that weight puts on the drive; 0 where the masses are not known."""
    temperature: Floats
    """(n,) K above the first logged one; NaN where not logged."""
    time: Floats
    """(n,) s since the joint's first sample."""
    travel: Floats
    """(n,) rad since the direction of motion last changed; NaN where reversals are not logged."""

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.velocity)

    def block(self, samples: slice | Booleans | Integers) -> DriveMotion:
        """Return some of the samples."""
        return DriveMotion(*(getattr(self, field.name)[samples] for field in fields(self)))

    @classmethod
    def at_velocity(cls, velocity: Floats) -> DriveMotion:
        """Return motion of which nothing but the velocities (n,), rad/s, is known: at angle 0, unloaded."""
        zero, unknown = np.zeros(len(velocity)), np.full(len(velocity), np.nan)
        return cls(np.asarray(velocity, dtype=np.float64), zero, zero, unknown, zero, unknown)

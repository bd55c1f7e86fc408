"""The motion of one drive, for effects that show in the torque of a moving joint."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers

# Speeds that differ by less, relatively, are one commanded speed.
SAME_SPEED = 0.05


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

    @property
    def both_ways(self) -> bool:
        """Whether the joint was moved in both directions."""
        return bool((self.velocity > 0.0).any() and (self.velocity < 0.0).any())

    def speeds(self) -> Floats:
        """Return the different speeds, rad/s, increasing; those within 5 % of each other count once.

        Examples
        --------
        >>> DriveMotion.at_velocity(np.array([0.1, -0.101, 0.0, 0.5])).speeds()
        array([0.1, 0.5])
        """
        logs = np.sort(np.log(np.abs(self.velocity[self.velocity != 0.0])))
        if not logs.size:
            return logs
        # A gap of 5 % begins another speed; where the speed varies without a gap, steps of 5 % count.
        group = np.cumsum(np.diff(logs, prepend=logs[0]) > SAME_SPEED)
        step = np.floor((logs - logs[np.searchsorted(group, group)]) / (2.0 * SAME_SPEED))
        _, first = np.unique(np.stack([group, step]), axis=1, return_index=True)
        return np.asarray(np.exp(logs[np.sort(first)]))


def travel_since_reversal(angle: Floats, velocity: Floats) -> Floats:
    """Return (n,) rad travelled since the direction of motion last changed; NaN before the first change.

    Parameters
    ----------
    angle : (n,) rad, in the order of time, without gaps.
    velocity : (n,) rad/s; where it is zero, the direction is that of the motion before.

    Examples
    --------
    >>> travel_since_reversal(np.array([0.0, 1.0, 2.0, 1.5, 0.5]), np.array([1.0, 1.0, 0.0, -1.0, -1.0]))
    array([nan, nan, nan, 0.5, 1.5])
    """
    direction = np.sign(velocity)
    moving = np.flatnonzero(direction)
    if not moving.size:
        return np.full(len(angle), np.nan)
    last = np.maximum.accumulate(np.where(direction != 0.0, np.arange(len(angle)), moving[0]))
    direction = direction[last]
    turned = np.flatnonzero(np.diff(direction) != 0.0) + 1
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)))])
    since = np.searchsorted(turned, np.arange(len(angle)), side="right") - 1
    # The last sample before a change lies nearest to the reversal.
    start = path[turned - 1][np.maximum(since, 0)] if turned.size else np.zeros(len(angle))
    return np.where(since >= 0, path - start, np.nan)

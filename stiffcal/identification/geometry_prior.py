"""How well the robot's geometry is known, and what that is from."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from stiffcal.arrays import Floats


class GeometrySource(Enum):
    """What the tolerance of the geometry is from."""

    ROBOT_FILE = "robot.toml"
    DEFAULT = "default"
    PLACES = "absolute places"


@dataclass(frozen=True)
class GeometryPrior:
    """How well the robot's lengths and angles are known."""

    length: float
    """m, standard deviation of every length."""
    angle: float
    """rad, of every angle."""
    source: GeometrySource
    """What it is from."""

    def sizes(self, n_joints: int) -> Floats:
        """Return (6J,) standard deviations in the order of `geometry_changes`."""
        return np.tile(np.repeat([self.length, self.angle], 3), n_joints)

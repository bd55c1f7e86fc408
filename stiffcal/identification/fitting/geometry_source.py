"""What the tolerance of the geometry is from."""

from __future__ import annotations

from enum import Enum


class GeometrySource(Enum):
    """What the tolerance of the geometry is from."""

    ROBOT_FILE = "robot.toml"
    DEFAULT = "default"
    PLACES = "absolute places"

"""The change of the input that would mend a fault, as values: texts are made from it, programs and tests read it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class ChangeKind(StrEnum):
    """What is changed."""

    ANGLE_UNIT = "angle-unit"
    LENGTH_UNIT = "length-unit"
    JOINT_UNIT = "joint-unit"
    JOINT_ORDER = "joint-order"
    DIRECTION = "direction"
    COUNTED_TOGETHER = "counted-together"
    ZERO = "zero"
    TRACKER_FRAME = "tracker-frame"
    TRACKER_AXES = "tracker-axes"
    INVERSE_FRAME = "inverse-frame"
    TARGET = "target"
    POSE_ORDER = "pose-order"
    QUATERNION_ORDER = "quaternion-order"
    QUATERNION_INVERSE = "quaternion-inverse"
    ACTS_ON = "acts-on"
    SENSOR_AXES = "sensor-axes"
    WRENCH_COLUMNS = "wrench-columns"
    WRENCH_SIGN = "wrench-sign"
    DISPLACEMENT_AXES = "displacement-axes"
    RUNS = "runs"
    REPEATS = "repeats"


@dataclass(frozen=True)
class InputChange:
    """A change of the input with which the data agree."""

    kind: ChangeKind
    """What is changed."""
    names: tuple[str, ...] = ()
    """Joints, columns, axes or runs that it is about, by name, in their order after the change."""
    sizes: tuple[float, ...] = ()
    """By how much, where there is an amount: a zero of each joint, rad (m of a prismatic joint); of a frame three
    angles of a rotation vector, rad, and three lengths, m; of a target three lengths, m; the factor of an angle that is
    added; the rows by which places move down; a number of runs.
    """
    value: str = ""
    """What the manifest or the robot file holds after it: a unit, or who the load acts on."""

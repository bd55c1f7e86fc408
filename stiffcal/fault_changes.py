"""The change of the input that would mend a fault, as values: texts are made from it, programs and tests read it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class ChangeKind(StrEnum):
    """What is changed."""

    ANGLE_UNIT = "angle-unit"
    """Of all joint angles; of one joint it is `JOINT_UNIT`."""
    LENGTH_UNIT = "length-unit"
    LENGTH_FACTOR = "length-factor"
    JOINT_UNIT = "joint-unit"
    JOINT_ORDER = "joint-order"
    DIRECTION = "direction"
    COUNTED_TOGETHER = "counted-together"
    ZERO = "zero"
    TRACKER_FRAME = "tracker-frame"
    TRACKER_AXES = "tracker-axes"
    INVERSE_FRAME = "inverse-frame"
    TARGET = "target"
    TARGET_ORDER = "target-order"
    POSITION_AXES = "position-axes"
    MIRRORED = "mirrored"
    POSE_ORDER = "pose-order"
    ROW_ORDER = "row-order"
    ROBOT_CONVENTION = "robot-convention"
    ROBOT_SIGN = "robot-sign"
    QUATERNION_ORDER = "quaternion-order"
    QUATERNION_INVERSE = "quaternion-inverse"
    ACTS_ON = "acts-on"
    SENSOR_AXES = "sensor-axes"
    WRENCH_COLUMNS = "wrench-columns"
    WRENCH_SIGN = "wrench-sign"
    DISPLACEMENT_AXES = "displacement-axes"
    RUNS = "runs"
    REPEATS = "repeats"


FORCES_ALONE = "forces"
"""Of the columns of a wrench: the order of those of the moments is open."""


@dataclass(frozen=True)
class InputChange:
    """A change of the input with which the data agree."""

    kind: ChangeKind
    """What is changed."""
    names: tuple[str, ...] = ()
    """Joints, columns, targets, axes or runs that it is about, by name, in their order after the change; of rows in
    another order what moves: positions, displacements or loads.
    """
    sizes: tuple[float, ...] = ()
    """By how much, where there is an amount: a zero of each joint, rad (m of a prismatic joint); of a frame three
    angles of a rotation vector, rad, and three lengths, m; of a target three lengths, m; the factor of an angle that is
    added, or of a length; the rows by which columns move down, none where they are reversed; the entry of a robot file;
    a number of runs.
    """
    value: str = ""
    """What the manifest or the robot file holds after it: a unit, a convention, or who the load acts on; the key of an
    entry, the axis of a length or the target of axes, where not all are meant.
    """

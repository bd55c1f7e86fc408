"""What is measured in load states; a kind of experiment says it of its runs."""

from __future__ import annotations

from enum import StrEnum


class StateMeasure(StrEnum):
    """What is measured in the load states of a run."""

    DISPLACEMENT = "displacement"
    """How far a loaded robot moved since the run's reference."""
    PLACE = "place"
    """Where a target is, each row by itself: no reference, no offset that it shares with others."""
    MOTOR_ANGLE = "motor_angle"
    """The angles of motors while a fixture holds the flange."""
    FRAME = "frame"
    """The pose of an unloaded robot, from which frames are found; where it carries a load that is large next to those
    of load runs, displacements."""

"""What the logs that are there say of the robot that a plan is made for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stiffcal.measurements.load_states import MeasurementSetup
    from stiffcal.model.assembled.composite import CompliantRobot


@dataclass(frozen=True)
class MeasuredSoFar:
    """What the logs that are there say of the robot."""

    robot: CompliantRobot
    """With the values that were fitted; what was not identified keeps that of model.toml, if any."""
    setup: MeasurementSetup
    """Estimated frames where they were found."""
    covariance: dict[str, dict[str, float]]
    """Of the fitted parameters, by full names."""
    noise: tuple[float | None, ...]
    """(6,) translation m, rotation rad, force N, moment N·m, motor angle rad, device m of a state; None: not known."""
    source: str
    """Where the values are from, in words."""
    readings: int
    """How many numbers of displacements and places were measured."""

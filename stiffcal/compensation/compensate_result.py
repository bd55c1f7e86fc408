"""What `compensate` answers: a path pose by pose, and its error as a picture shows it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.arrays import Floats
from stiffcal.compensation.targets import Corrected
from stiffcal.document_arrays import Vector
from stiffcal.documents import NOT_IN_DOCUMENT, CommandResult, Number, OrAbsent
from stiffcal.measurements.rms import Rms

Wanted = Literal["path", "nominal robot", "unloaded robot"]


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrectedPose:
    """A pose of a path; errors are reached minus wanted, base axes."""

    line: int
    """Of the path's file."""
    joints: Vector
    """(L,) rad, as commanded in the path."""
    corrected: Vector
    """(L,) rad, as they are to be commanded."""
    wrench: Vector
    """(6,) N, N·m, on the robot."""
    deflection: Vector
    """(6,) m, rad: what the load does at the path's joint angles."""
    error_before: Vector
    """(6,) m, rad, without the correction."""
    error_after: Vector
    """(6,) m, rad, with it, by the model itself."""
    residual_std: Vector
    """(6,) m, rad: what the model's own uncertainty leaves of the error."""
    reached: bool
    """Whether all that is wanted is reached."""
    held: str
    """Names of the joints that a limit stopped."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PathJudgement:
    """The errors of the corrected targets by another campaign's robot."""

    by: str
    """The campaign's folder."""
    rms_before: Rms
    """Without the correction."""
    rms_after: Rms
    """With it."""
    gone: Number
    """The share of the position's error that the correction takes."""
    campaign: Annotated[str, NOT_IN_DOCUMENT]
    """The campaign's name."""
    before: Annotated[Floats, NOT_IN_DOCUMENT]
    """(n, 6) m, rad, without the correction."""
    after: Annotated[Floats, NOT_IN_DOCUMENT]
    """(n, 6) m, rad, with it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CompensateResult(CommandResult):
    """Answer of ``compensate``."""

    schema: Literal["stiffcal/compensate/1"] = "stiffcal/compensate/1"
    values_from: str
    """Where the model's values are from, in words."""
    target: str
    """The frame that follows the path."""
    wanted: Wanted
    """Which poses the errors count from, base axes: the poses that the path gives, those of robot.toml's rigid robot at
    the path's joint angles, or those of the robot itself there without the load.
    """
    rms_before: Rms
    """Of the pose errors without the correction."""
    rms_after: Rms
    """With it, by the model itself."""
    residual_95: Number
    """m, what the position's error keeps under with 95 %; null where the values were given and not fitted."""
    largest_correction: Vector
    """(L,) rad."""
    rows: list[CorrectedPose]
    """The path, pose by pose."""
    judged: OrAbsent[PathJudgement] = None
    """The errors by another campaign's robot, where one was named."""
    file: OrAbsent[str] = None
    """The table that was written."""
    picture: OrAbsent[str] = None
    """The picture that was written."""
    found: Annotated[Corrected, NOT_IN_DOCUMENT]
    """The path as arrays."""
    joint_names: Annotated[tuple[str, ...], NOT_IN_DOCUMENT]
    """Of the logged joints, L of them."""
    joint_units: Annotated[tuple[str, ...], NOT_IN_DOCUMENT]
    """In which tables have their positions: "deg", of prismatic joints "mm"."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PathError:
    """The error along a path, with and without compensation (002, Fig. 9; 001, Fig. 8)."""

    place: Floats
    """(n, 3) m, base axes: where the tool is wanted."""
    before: Floats
    """(n, 3) m, reached minus wanted, without the correction."""
    after: Floats
    """(n, 3) m, with it."""
    covariance: Floats
    """(n, 3, 3) m², of what the model's uncertainty leaves; zero where the values were given."""
    direction: Floats | None
    """(n, 3) unit vectors along which the error is drawn; None: its length."""
    along: str
    """What that is, in words."""
    judge: str
    """By which robot: the model itself, or another campaign's."""
    name: str
    """The campaign's name."""

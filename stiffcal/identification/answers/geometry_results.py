"""The robot's own geometry as ``identify`` answers it: zeros of the joints and lengths of the links."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from stiffcal.documents import Number, OrAbsent
from stiffcal.mechanics.conventions import Convention


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedNumber:
    """A number of the calibrated robot's rows."""

    value: float
    """m or rad."""
    change: float
    """Against the robot file, m or rad."""
    std: Number
    """Standard uncertainty; None where these places do not determine the number: it is then part of a choice."""
    cannot_be_separated_from: OrAbsent[list[str]] = None
    """What makes the same motion, where `std` is None: frames, parameters or other numbers of the rows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedZero:
    """A joint's zero."""

    joint: int
    """From 1."""
    theta: StatedNumber
    """θ of the joint's row, rad: added to the model angle."""
    logged: float
    """The change as added to the logged angle, rad: what one enters in the controller. Of a prismatic joint the change
    of d as added to the logged position, m.
    """
    prismatic: OrAbsent[bool] = None
    """True of a prismatic joint; absent of others."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedLink:
    """Lengths and twist in the row of a joint."""

    joint: int
    """From 1."""
    d: StatedNumber
    """Along the joint's axis, m."""
    a: OrAbsent[StatedNumber] = None
    """Between this axis and the next ("dh") or the one before ("modified-dh"), m; none at the robot's end."""
    alpha: OrAbsent[StatedNumber] = None
    """The twist between these axes, rad; none at the robot's end."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedBeta:
    """Hayati's β in the row of a joint whose axis is nearly parallel to the next or the one before."""

    joint: int
    """From 1."""
    beta: StatedNumber
    """rad."""


class NoOffsets(StrEnum):
    """Why no offsets alone serve."""

    BEYOND_RANGE = "beyond-range"
    NO_SMALLER_ERROR = "no-smaller-error"
    NOT_CONVERGED = "not-converged"


@dataclass(frozen=True, slots=True, kw_only=True)
class OffsetsAlone:
    """The best that a controller can do which takes zeros of the joints and frames of base and tool, and no lengths."""

    zeros: list[float]
    """For each logged angle, added to it, rad (prismatic: m); 0 where a frame makes the same motion."""
    mean: float
    """Distance from the calibrated robot's targets that this leaves over the measured poses, m."""
    median: float
    """m."""
    p95: float
    """95 % are nearer."""
    max: float
    """m."""
    rms: float
    """Root mean square, m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GeometryFound:
    """The geometry that a fit of absolute poses found."""

    convention: Convention
    """Of the rows: that of robot.toml, and "modified-dh" for a URDF."""
    zeros: list[StatedZero]
    """One for each joint."""
    links: list[StatedLink]
    """One for each joint."""
    beta: list[StatedBeta]
    """Of nearly parallel axes."""
    offsets_alone: OffsetsAlone | None
    """For controllers that take only offsets; None where there are none."""
    no_offsets: OrAbsent[NoOffsets] = None
    """Why there are none: the best ones are beyond half a turn or a joint's range, leave no smaller error, or the
    iteration for them does not converge.
    """

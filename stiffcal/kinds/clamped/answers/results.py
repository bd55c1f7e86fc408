"""What ``identify`` answers of the clamped robot; SI."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from stiffcal.document_arrays import Matrix
from stiffcal.documents import NOT_PROMISED, Number
from stiffcal.kinds.clamped.held.torque_source import TorqueSource


@dataclass(frozen=True, slots=True, kw_only=True)
class Definition:
    """What the numbers mean."""

    low_slope: str
    """The segment whose slope lies below `slope_share` of the outer slope."""
    friction: str
    """Half the distance of the two directions' torques."""
    reversal_error: str
    """In words."""
    angle: str
    """From where angles count, in words."""
    curve: str
    """The law of torque over angle, in words."""
    left_out: str
    """Which poses are not used."""
    slope_share: float
    """Share of the outer slope below which a segment counts as low."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueOverAngle:
    """τ = p1 φ + p2 φ² + p3 φ³, φ counted from the flank."""

    p1: float
    """N·m/rad."""
    p2: float
    """N·m/rad²."""
    p3: float
    """N·m/rad³."""
    covariance: Matrix
    """(3, 3) of p1, p2, p3."""
    reach: list[float]
    """Least and greatest angle that was reached, rad."""
    torque: list[float]
    """Torque at both ends of `reach`, N·m."""
    runs: list[str]
    """Names of the runs that it was fitted to."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tangent:
    """Tangent stiffness at a torque."""

    torque: float
    """N·m."""
    angle: float
    """rad."""
    stiffness: float
    """N·m/rad."""
    interval: list[Number]
    """Both ends of the 95 % interval, N·m/rad; null where one is open."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunLeftOut:
    """A run that is not used for its joint."""

    run: str
    """The run's id."""
    why: str
    """The reason, in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JointResult:
    """One joint, from all poses that are used."""

    joint: int
    """From 1."""
    low_slope_found: bool
    """Whether there is a segment of low slope beyond noise: a description of the curve, no parameter of the model."""
    low_slope: float
    """Its length, rad."""
    low_slope_std: Number
    """rad; null where none is found, or at a limit of the search."""
    low_slope_interval: list[Number]
    """Both ends of the 95 % interval, rad; null where one is open."""
    law_width: float
    """b of the law b·tanh(torque/w), rad: `low_slope` is the segment of it whose slope is low."""
    law_width_interval: list[Number]
    """Both ends of the 95 % interval, rad; null where one is open."""
    low_slope_band: Number
    """Torque within which the segment is crossed, ± N·m."""
    resolution: Number
    """Of the segment, rad."""
    spread_between_poses: Number
    """Standard deviation of the segment between poses, rad."""
    friction_found: bool
    """Whether friction is significant."""
    friction: Number
    """N·m."""
    friction_std: Number
    """N·m; null where none is found, or at a limit of the search."""
    reversal_error: Number
    """rad."""
    torque_from: TorqueSource
    """What measured the torque."""
    curve: TorqueOverAngle
    chord_stiffness: float
    """Torque over angle from end to end of what was reached, without that segment, N·m/rad: one over joint-compliance.
    """
    chord_interval: list[Number]
    """Both ends of the 95 % interval, N·m/rad; null where one is open."""
    tangent_stiffness: list[Tangent]
    at_bound: Annotated[list[str], NOT_PROMISED] = field(default_factory=list)
    """Which of low_slope, width, friction, p1, p2, p3 and chord rest on a search that ended at a limit of its
    range, and have no standard uncertainty."""
    runs: list[str]
    """Names of the runs that are used."""
    left_out: list[RunLeftOut]
    name: str
    """The joint's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesLaw:
    """Spring and play in series with friction, as fitted to one run."""

    middle: float
    """Angle at the middle of the play, rad."""
    width: float
    """Of the play, rad."""
    band: float
    """Torque within which the play is crossed, ± N·m."""
    zero: float
    """The torque's zero, N·m."""
    friction: float
    """Constant part, N·m."""
    drag: float
    """Friction that grows with the load, as a share of it."""
    lag: float
    """Angle by which the torque stays behind (two clocks), rad."""
    curve: list[float]
    """p1, p2, p3 as in `TorqueOverAngle`."""
    reach: list[float]
    """Least and greatest angle from the flank, rad."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ClampedRunResult:
    """One joint in one pose."""

    run: str
    """The run's id."""
    joint: int
    """From 1."""
    used: bool
    """Whether the joint's values rest on it."""
    left_out: str
    """Why it is not used, "" where it is."""
    half_sweeps: int
    """Motions from one end to the other."""
    cycles: int
    """Motions there and back."""
    motion: float
    """Whole range of the joint's angle, rad."""
    low_slope: Number
    """rad."""
    low_slope_between_cycles: Number
    """Standard deviation of the segment between cycles, rad."""
    resolution: Number
    """Of the segment, rad."""
    encoder_step: float
    """rad."""
    reversal_error: Number
    """rad."""
    torque_range: list[float]
    """Smallest and largest torque that was measured, mean over the half sweeps, N·m."""
    friction: Number
    """N·m; null where one direction alone was driven."""
    friction_found: bool
    """Whether friction is significant."""
    law: SeriesLaw
    rms_torque: float
    """Of what the law leaves, N·m."""
    noise_torque: float
    """Scatter of repeats, N·m."""
    torque_from: TorqueSource
    """What measured the torque."""
    lever: Number
    """Of the force about the moved joint, m; null without a force sensor."""
    weight: float
    """The moved drive's share of the weight, N·m; 0 where masses are not known."""
    others_share: float
    """Share of the motion that other joints take up."""
    saturated: str | None
    """What limits the torque, in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ClampedSection:
    """Play, friction and torque over angle of every joint that was driven against the fixture."""

    definition: Definition
    joints: list[JointResult]
    runs: list[ClampedRunResult]

"""What ``identify`` and ``validate`` say of the clamped robot, typed; SI."""

from __future__ import annotations

from typing import Literal

from typing_extensions import TypedDict

from stiffcal.workflow.document_types import Matrix, Number


class Definition(TypedDict):
    """What the numbers mean; play is where the slope lies below ``slope_share`` of the outer one."""

    play: str
    friction: str
    reversal_error: str
    angle: str
    curve: str
    left_out: str
    slope_share: float


class TorqueOverAngle(TypedDict):
    """τ = p1 φ + p2 φ² + p3 φ³, φ counted from the flank, its covariance, what was reached, and which runs tell it."""

    p1: float
    p2: float
    p3: float
    covariance: Matrix
    reach: list[float]
    torque: list[float]
    runs: list[str]


class Tangent(TypedDict):
    """Tangent stiffness at a torque, N·m/rad, with its 95 % interval."""

    torque: float
    angle: float
    stiffness: float
    interval: list[float]


class RunLeftOut(TypedDict):
    """A run that is not used for its joint, and why."""

    run: str
    why: str


class ClampedJoint(TypedDict):
    """One joint, from all poses that are used."""

    joint: int
    name: str
    play_found: bool
    play: float
    play_std: float
    play_interval: list[float]
    play_band: Number
    resolution: Number
    spread_between_poses: Number
    friction_found: bool
    friction: Number
    friction_std: Number
    reversal_error: Number
    torque_from: Literal["force sensor", "motor torque"]
    curve: TorqueOverAngle
    tangent_stiffness: list[Tangent]
    runs: list[str]
    left_out: list[RunLeftOut]


class SeriesLaw(TypedDict):
    """Spring and play in series as fitted to one run, friction constant and in proportion to the load (``drag``)."""

    middle: float
    width: float
    band: float
    zero: float
    friction: float
    drag: float
    lag: float
    curve: list[float]
    reach: list[float]


class ClampedRun(TypedDict):
    """One joint in one pose."""

    run: str
    joint: int
    used: bool
    left_out: str
    half_sweeps: int
    cycles: int
    motion: float
    play: Number
    play_between_cycles: Number
    resolution: Number
    encoder_step: float
    reversal_error: Number
    friction: Number
    friction_found: bool
    law: SeriesLaw
    rms_torque: float
    noise_torque: float
    torque_from: Literal["force sensor", "motor torque"]
    lever: Number
    weight: float
    others_share: float
    saturated: str | None


class Clamped(TypedDict):
    """Play, friction and torque over angle of every joint that was driven against the fixture."""

    definition: Definition
    joints: list[ClampedJoint]
    runs: list[ClampedRun]


class ClampedJudged(TypedDict):
    """How clamped runs were judged, and how many bins of angle that were."""

    scheme: str
    n_readings: int
    rms: dict[str, Number]
    noise: dict[str, Number]
    zero_model: dict[str, Number]

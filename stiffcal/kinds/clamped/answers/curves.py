"""The clamped robot's curves: what was read in each pose, and what all poses of a joint give."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats
from stiffcal.kinds.clamped.answers.results import ClampedRunResult, ClampedSection, JointResult
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.measurements.columns import values_of
from stiffcal.uncertainty import NORMAL_95

BRANCHES = "clamped_branches"
_POINTS = 201


@dataclass(frozen=True)
class ClampedPose:
    """One joint in one pose."""

    run: str
    """The run's id."""
    left_out: str
    """Why the joint's result does not use the run, "" where it does."""
    angle: Floats
    """(m,) rad, the joint's angle."""
    torque: Floats
    """(m,) N·m, about the joint."""
    up: Booleans
    """(m,) True where the angle was growing."""
    fitted: Floats
    """(m,) N·m, the fitted law at these angles."""
    play: float | None
    """rad; None where the run gives none."""
    doubt: float
    """rad, half width of what the play is known to in this pose."""
    motion: float
    """rad, span of the joint's angle."""
    low: float | None
    """rad, the lower end of the play, ``high`` its upper end; None without play."""
    high: float | None
    """rad, see ``low``."""
    spring_angle: Floats
    """(k,) rad from the flank, of the readings outside the play."""
    spring_torque: Floats
    """(k,) N·m at these angles, friction and zero torque taken off."""
    remark: str = ""
    """Saturation and similar faults, "" where there is none."""


@dataclass(frozen=True)
class ClampedCurve:
    """One joint, from all poses."""

    joint: str
    """The joint's name."""
    poses: tuple[ClampedPose, ...]
    """Its runs, used or not."""
    result: JointResult | None
    """The joint's result; None where no run can be used."""
    angle: Floats
    """(n,) rad from the flank, of the curve."""
    torque: Floats
    """(n,) N·m, the curve."""
    std: Floats
    """(n,) N·m, its standard uncertainty."""
    curve_runs: tuple[str, ...] = ()
    """Names of the runs that the curve was fitted to."""

    @property
    def widest_pose(self) -> ClampedPose:
        """The pose that moved the joint furthest, among those that are used where there are any."""
        return max(self.poses, key=lambda pose: (not pose.left_out, pose.motion))

    def of_run(self, run: str) -> ClampedCurve:
        """Return the curve with the poses of one run alone."""
        return replace(self, poses=tuple(pose for pose in self.poses if pose.run == run))


def clamped_curves(data: MeasuredRuns, section: ClampedSection) -> tuple[ClampedCurve, ...]:
    """Return every joint that a clamped run moved.

    Parameters
    ----------
    data : the campaign, with the averaged branches among its tables.
    section : of ``identify``.
    """
    if not section.runs or BRANCHES not in data.tables:
        return ()
    table = data.tables[BRANCHES]
    runs = np.array(table.column("run").to_pylist(), dtype=np.str_)
    columns = {name: values_of(table.column(name)) for name in ("angle_rad", "torque_Nm", "up", "law_Nm")}
    results = {joint.joint: joint for joint in section.joints}
    curves = []
    for joint in sorted({run.joint for run in section.runs}):
        poses = tuple(
            _pose(run, {name: values[runs == run.run] for name, values in columns.items()})
            for run in section.runs
            if run.joint == joint
        )
        result = results.get(joint)
        low, high = (0.0, 0.0) if result is None else result.curve.reach
        angle = np.linspace(low, high, 0 if result is None else _POINTS)
        powers = np.stack([angle, angle**2, angle**3])
        curve = np.zeros(3) if result is None else np.array([result.curve.p1, result.curve.p2, result.curve.p3])
        covariance = np.zeros((3, 3)) if result is None else result.curve.covariance
        through = () if result is None else tuple(result.curve.runs)
        std = np.sqrt(np.maximum(np.einsum("in,ij,jn->n", powers, covariance, powers), 0.0))
        curves.append(ClampedCurve(data.joint_names[joint - 1], poses, result, angle, curve @ powers, std, through))
    return tuple(curves)


def _pose(run: ClampedRunResult, columns: dict[str, NDArray[Any]]) -> ClampedPose:
    law = run.law
    angle, torque, up = columns["angle_rad"], columns["torque_Nm"], columns["up"].astype(bool)
    sign = np.where(up, 1.0, -1.0)
    even = torque - law.zero - sign * law.friction
    spring = even / (1.0 + sign * np.sign(even) * law.drag)
    spring_side = angle - sign * law.lag - law.middle
    outside = np.abs(spring_side) > 0.5 * law.width
    from_flank = spring_side - 0.5 * law.width * np.sign(spring_side)
    half = 0.5 * (run.low_slope or 0.0)
    return ClampedPose(
        run=run.run,
        left_out=run.left_out,
        angle=angle,
        torque=torque,
        up=up,
        fitted=columns["law_Nm"],
        play=run.low_slope,
        doubt=max(run.resolution or 0.0, NORMAL_95 * (run.low_slope_between_cycles or 0.0)),
        motion=run.motion,
        low=law.middle - half if half else None,
        high=law.middle + half if half else None,
        spring_angle=from_flank[outside],
        spring_torque=spring[outside],
        remark=run.saturated or "",
    )

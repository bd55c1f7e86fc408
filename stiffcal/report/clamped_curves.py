"""What the pages on the clamped robot show of each joint."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.arrays import Booleans, Floats
from stiffcal.experiments.clamped.results import JointResult


@dataclass(frozen=True)
class ClampedPose:
    """One joint in one pose.

    Attributes
    ----------
    run : its name. left_out : why it is not used, "" where it is.
    angle : (m,) rad. torque : (m,) N·m. up : (m,) True where the angle was growing. fitted : (m,) N·m, the law's.
    play : rad, None where the run says nothing. doubt : rad, what the play is known to in this pose.
    motion : rad. low, high : rad, the ends of the play; None without one.
    spring_angle, spring_torque : (k,) outside the play: angle from the flank, torque without friction and zero.
    remark : saturation and the like, "" where nothing is to be said.
    """

    run: str
    left_out: str
    angle: Floats
    torque: Floats
    up: Booleans
    fitted: Floats
    play: float | None
    doubt: float
    motion: float
    low: float | None
    high: float | None
    spring_angle: Floats
    spring_torque: Floats
    remark: str = ""


@dataclass(frozen=True)
class ClampedCurve:
    """One joint, from all poses.

    Attributes
    ----------
    joint : its name. poses : its runs.
    result : None where no run can be used.
    angle : (n,) rad from the flank. torque, std : (n,) N·m, the curve and its standard uncertainty.
    curve_runs : names of the runs that the curve was fitted to.
    """

    joint: str
    poses: tuple[ClampedPose, ...]
    result: JointResult | None
    angle: Floats
    torque: Floats
    std: Floats
    curve_runs: tuple[str, ...] = ()

    @property
    def shown(self) -> ClampedPose:
        """The pose that moved the joint furthest, among those that are used where there are any."""
        return max(self.poses, key=lambda pose: (not pose.left_out, pose.motion))

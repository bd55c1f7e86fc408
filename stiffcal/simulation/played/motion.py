"""Runs in which motors are driven: one long motion instead of holds, known at nodes of time.

Where the load of other runs goes along straight lines between holds, a driven motor goes along its own path: the path
coordinate of such a run is its time, and everything is solved at nodes and interpolated between.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.simulation.played.cycles import LoadProgram


@dataclass(frozen=True)
class MotionProgram(LoadProgram):
    """A driven motion, one hold long for all that counts holds."""

    node: Floats
    """(s,) s from the run's start, rising."""
    joints: Floats
    """(s, L) logged joint angles, rad, as the motors are driven."""
    moved_joint: int
    """Number of the moved joint, from 1; 0 where no joint is moved alone."""
    wrench_at_node: Floats
    """(s, 6) N, N·m, base axes, about the load point: what the surroundings do to the robot."""
    torque: Floats
    """(s, L) N·m, the motors' torques at the joints' side, friction included."""

    def path(self, time: Floats) -> Floats:
        """Return (n,) the path coordinate at moments: time itself, s, within the motion."""
        return np.clip(time, self.node[0], self.node[-1])

    def wrench_at(self, path: Floats) -> Floats:
        """Return (n, 6) the load at path coordinates, N, N·m, base axes."""
        return self._between(self.wrench_at_node, path)

    def joints_at(self, path: Floats) -> Floats:
        """Return (n, L) logged joint angles, rad."""
        return self._between(self.joints, path)

    def velocity_at(self, path: Floats) -> Floats:
        """Return (n, L) rad/s: the slope between nodes."""
        after = np.clip(np.searchsorted(self.node, path, side="left"), 1, self.node.size - 1)
        step = (self.node[after] - self.node[after - 1])[:, None]
        return np.asarray((self.joints[after] - self.joints[after - 1]) / step)

    def torque_at(self, path: Floats) -> Floats:
        """Return (n, L) torques of the motors at the joints' side, N·m."""
        return self._between(self.torque, path)

    def _between(self, values: Floats, path: Floats) -> Floats:
        return np.stack([np.interp(path, self.node, column) for column in values.T], axis=1)


@dataclass(frozen=True)
class PoseProgram(MotionProgram):
    """Poses taken one after the other, a hold each, without a way between that any instrument logs."""

    payload: Floats
    """(m,) kg hung on at the load point."""

    def payload_at(self, path: Floats) -> Floats:
        """Return (n,) kg at path coordinates; a pose's payload counts from its hold's start."""
        return np.asarray(self.payload[np.clip(np.searchsorted(self.end, path), 0, self.payload.size - 1)])

    def velocity_at(self, path: Floats) -> Floats:
        """Return (n, L) zero: the robot rests in every pose."""
        return np.zeros((path.size, self.joints.shape[1]))


def pose_program(joints: Floats, payload: Floats, interval_s: float) -> PoseProgram:
    """Return poses at equal times: wrench and torques are filled in where it is played.

    Parameters
    ----------
    joints : (m, L) logged joint angles, rad. payload : (m,) kg. interval_s : from one pose to the next.
    """
    size = len(payload)
    middle: Floats = np.linspace(0.5, size - 0.5, size) * interval_s
    none = np.zeros(size, dtype=np.int64)
    # a quarter of the time to either side: the robot moves in the rest
    start, end = middle - 0.25 * interval_s, middle + 0.25 * interval_s
    return PoseProgram(
        wrench=np.zeros((size, 6)),
        direction=none - 1,
        sign=none,
        level=np.ones(size),
        branch=none,
        cycle=none,
        ramp_from=np.append(start[:1], end[:-1]),
        ramp_to=start,
        start=start,
        end=end,
        node=middle,
        joints=joints,
        moved_joint=0,
        wrench_at_node=np.zeros((size, 6)),
        torque=np.zeros_like(joints),
        payload=payload,
    )


def motion_program(node: Floats, joints: Floats, moved_joint: int) -> MotionProgram:
    """Return a motion without loads: wrench and torques are filled in where it is played.

    Parameters
    ----------
    node : (s,) s, rising from 0.
    joints : (s, L) rad.
    moved_joint : from 1.
    """
    zero, none = np.array([0.0]), np.zeros(1, dtype=np.int64)
    return MotionProgram(
        wrench=np.zeros((1, 6)),
        direction=none - 1,
        sign=none,
        level=zero,
        branch=none,
        cycle=none,
        ramp_from=zero,
        ramp_to=zero,
        start=zero,
        end=np.array([float(node[-1])]),
        node=node,
        joints=joints,
        moved_joint=moved_joint,
        wrench_at_node=np.zeros((node.size, 6)),
        torque=np.zeros_like(joints),
    )

"""Deflection and correction of many samples at once, in the papers' linear form: D = Σ J_k C_k J_kᵀ W (002, eq. 8).

For maps, for whole logs, for choosing among many poses: where a million samples count more than the last half per cent,
which `targets.correct_joints` and `prediction.predict_states` hold.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.linear_nodes import LinearNodes, NodeChain, linear_nodes, node_chain
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.kinematics import BLOCK, StackedFrame, base_frame, cross, from_frame, jacobians, to_frame
from stiffcal.model.assembled.composite import CompliantRobot


class LinearCompensation:
    """A robot's linear compliance, ready for many samples.

    Parameters
    ----------
    robot : chain and effects, every parameter with a value, all of them linear.
    setup : where load and target are; the wrench's axes and point ride on bodies of the chain, or are the base's.
    leave_out : names of effects that may be left out because they are not linear.

    Raises
    ------
    ValueError : an effect is not linear, and ``leave_out`` does not name it.
    """

    def __init__(self, robot: CompliantRobot, setup: MeasurementSetup, leave_out: tuple[str, ...] = ()) -> None:
        self._robot = robot
        self._nodes: LinearNodes = linear_nodes(robot, setup, leave_out)
        self._chain: NodeChain = node_chain(robot.chain, self._nodes)
        self._setup = self._nodes.setup
        count = len(self._chain.nodes)
        blocks = self._nodes.compliance.reshape(count, 6, count, 6)
        diagonal = np.einsum("iaib->iab", blocks)
        off_diagonal = blocks.copy()
        off_diagonal[np.arange(count), :, np.arange(count)] = 0.0
        # Springs that each answer their own component alone, as most do, need no matrix product.
        self._springs = (
            None if off_diagonal.any() or (diagonal * (1.0 - np.eye(6))).any() else np.einsum("iaa->ia", diagonal)
        )

    def deflection(self, joints: Floats, wrench: Floats) -> Floats:
        """Return (n, 6) the target's deflection, base axes, m and rad.

        Parameters
        ----------
        joints : (n, L) logged angles, rad.
        wrench : (n, 6) N and N·m on the robot, in the set-up's wrench axes about its wrench point.
        """
        angles = self._robot.chain.model_angles(joints)
        result = np.empty((6, len(joints)))
        for start in range(0, len(joints), BLOCK):
            rows = slice(start, start + BLOCK)
            self._block(np.ascontiguousarray(angles[rows].T), np.ascontiguousarray(wrench[rows].T), result[:, rows])
        return result.T

    def correction(self, joints: Floats, wrench: Floats, damping: float = 5e-3) -> Floats:
        """Return (n, L) joint offsets, rad, that take it back: least motion, damped near singular poses."""
        chain = self._robot.chain
        result = np.empty(joints.shape)
        for start in range(0, len(joints), BLOCK):
            states = slice(start, start + BLOCK)
            deflection = self.deflection(joints[states], wrench[states])
            jacobian = jacobians(chain, chain.model_angles(joints[states]), self._setup.targets[0])
            if not np.array_equal(chain.coupling, np.eye(chain.n_joints)):
                jacobian = jacobian @ chain.coupling
            rows = np.ascontiguousarray(jacobian)
            normal = rows @ np.swapaxes(rows, 1, 2) + damping * damping * np.eye(6)
            result[states] = -np.einsum("nij,ni->nj", rows, np.linalg.solve(normal, deflection[:, :, None])[:, :, 0])
        return result

    def _block(self, angles: Floats, wrench: Floats, result: Floats) -> None:
        frames = self._frames(angles)
        setup = self._setup
        n = angles.shape[1]
        force, moment = wrench[:3], wrench[3:]
        if setup.wrench_axes.body != 0 or not np.array_equal(setup.wrench_axes.transform[:3, :3], np.eye(3)):
            node, inner = self._chain.placed(setup.wrench_axes)
            axes = (base_frame(n) if node < 0 else frames[node]).moved(inner).rotation
            force, moment = from_frame(axes, force), from_frame(axes, moment)
        node, inner = self._chain.placed(setup.wrench_point)
        reach, point = node, frames[node].point(inner[:3, 3])
        if not setup.moments_measured:
            moment = np.zeros_like(force)
        node, inner = self._chain.placed(setup.targets[0])
        target = frames[node].point(inner[:3, 3])
        if self._springs is not None:
            self._sum_springs(frames[: min(reach, node) + 1], (force, moment, point), target, result)
            return
        carried = np.zeros((len(frames), 6, n))
        for k, frame in enumerate(frames[: reach + 1]):
            carried[k, :3] = to_frame(frame.rotation, force)
            carried[k, 3:] = to_frame(frame.rotation, moment + cross(point - frame.position, force))
        small = (self._nodes.compliance @ carried.reshape(-1, n)).reshape(-1, 6, n)
        result[:] = 0.0
        for k, frame in enumerate(frames[: node + 1]):
            turn = from_frame(frame.rotation, small[k, 3:])
            result[:3] += from_frame(frame.rotation, small[k, :3]) + cross(turn, target - frame.position)
            result[3:] += turn

    def _sum_springs(
        self, frames: list[StackedFrame], load: tuple[Floats, Floats, Floats], target: Floats, result: Floats
    ) -> None:
        """Sum over nodes whose components each have a spring of their own; result (6, n) is written."""
        assert self._springs is not None
        force, moment, point = load
        n = force.shape[1]
        result[:] = 0.0
        about, inside, back = np.empty((3, n)), np.empty((3, n)), np.empty((3, n))
        for frame, springs in zip(frames, self._springs, strict=False):
            arm = point - frame.position
            np.add(moment, cross(arm, force), out=about)
            if springs[3:].any():
                np.einsum("ian,in->an", frame.rotation, about, out=inside)
                inside *= springs[3:, None]
                np.einsum("ian,an->in", frame.rotation, inside, out=back)
                result[3:] += back
                result[:3] += cross(back, target - frame.position)
            if springs[:3].any():
                np.einsum("ian,in->an", frame.rotation, force, out=inside)
                inside *= springs[:3, None]
                np.einsum("ian,an->in", frame.rotation, inside, out=back)
                result[:3] += back

    def _frames(self, angles: Floats) -> list[StackedFrame]:
        """Return the nodes' undeformed frames."""
        frames = []
        frame = base_frame(angles.shape[1])
        for fixed, joint in zip(self._chain.fixed, self._chain.joint, strict=True):
            frame = frame.moved(fixed)
            if joint >= 0:
                frame = frame.moved_by_joint(angles[joint], bool(self._chain.prismatic[joint]))
            frames.append(frame)
        return frames

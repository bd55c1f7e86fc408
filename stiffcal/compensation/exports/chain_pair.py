"""Two shapes of one chain, loaded and unloaded, in arrays that stand ready.

Nothing here allocates arrays after construction: every operation writes into one of the arrays below, through views
that are made once. Axis 0 is the shape: 0 under load and weight, 1 under weight alone. Frames stand transposed, column
vectors as rows, so that whatever is linear in all frames is one product with a constant matrix.

Why products where a formula would do: for arrays as small as a robot's, calling numpy is what costs, so that the fewest
calls win. The joints' transforms are a constant matrix times (1, cos, sin), of prismatic ones (1, q); levers, mass
moments and the sensor's axes are a constant matrix times all frames; the nodes' wrenches are these times a matrix in
which the load stands; and displacements, with a 1 appended to each, are a constant matrix times the wrenches.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.exports.scalar_responses import ScalarResponses
from stiffcal.compensation.linear_nodes import LinearNodes, NodeChain
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.rotations import cross_matrix

# v @ MINUS_SKEW is −[v]× in nine numbers.
MINUS_SKEW = -np.stack([cross_matrix(axis).ravel() for axis in np.eye(3)])
# A displacement's six numbers, and the 1 appended to them.
SIX_AND_ONE = 7


def turning_basis(chain: NodeChain, n_joints: int) -> Floats:
    """Return (1 + 2 J, 16 N): the nodes' transposed transforms over (1, cos θ, sin θ), prismatic joints: (1, q)."""
    count = len(chain.nodes)
    basis = np.zeros((1 + 2 * n_joints, count, 4, 4))
    for node, (fixed, joint) in enumerate(zip(chain.fixed, chain.joint, strict=True)):
        if joint < 0:
            basis[0, node] = fixed.T
            continue
        if chain.prismatic[joint]:
            basis[0, node], basis[1 + joint, node, 3] = fixed.T, fixed.T[2]
            continue
        basis[0, node, 2:] = fixed.T[2:]
        basis[1 + joint, node, :2] = fixed.T[:2]
        basis[1 + n_joints + joint, node, :2] = fixed.T[1], -fixed.T[0]
    return basis.reshape(len(basis), -1)


def displacement_basis(deformed: bool) -> Floats:
    """Return (7, 16) M: (shift, φ, 1) @ M is the transposed 4×4 transform of a small motion; of none if not deformed.

    Second-order rotation is left out: it changes levers by some 10⁻⁶ of themselves, and the deflection is not read off
    from these frames but summed over the nodes.
    """
    basis = np.zeros((SIX_AND_ONE, 4, 4))
    basis[6] = np.eye(4)
    if deformed:
        basis[:3, 3, :3] = np.eye(3)
        basis[3:6, :3, :3] = [cross_matrix(axis).T for axis in np.eye(3)]
    return basis.reshape(SIX_AND_ONE, 16)


def seeing_matrix(chain: NodeChain, nodes: LinearNodes) -> Floats:
    """Return (5 N + 3, 16 (N + 1)): what is wanted of all frames, rows as they stand in `ChainPair`.

    Columns: the ground and every node, before its own displacement and after it, two shapes, the frame's four rows.
    """
    count = len(chain.nodes)
    matrix = np.zeros((5 * count + 3, count + 1, 2, 2, 4))
    after = matrix[:, :, 1]
    levers, axes = after[: 4 * count].reshape(2, count, 2, count + 1, 2, 4), after[4 * count : 4 * count + 3]
    arms = after[4 * count + 3 :]
    reach, point = chain.placed(nodes.setup.wrench_point)
    outermost, target = chain.placed(nodes.setup.targets[0])
    for k in range(count):
        own, ground = (k + 1, 3), (0, 3)
        outboard = float(chain.mass[k:].sum())
        for shape in range(2):
            lever, carried = levers[shape, k, :, :, shape]
            if k <= reach:
                lever[reach + 1] += point[:, 3]
                lever[own] -= 1.0
                lever[ground] += 1.0
            carried[k + 1 :] += np.concatenate([chain.mass_moment[k:], chain.mass[k:, None]], axis=1)
            carried[own] -= outboard
            carried[ground] += outboard
        if k <= outermost:
            arms[k, outermost + 1] += 0.5 * target[:, 3]
            arms[k, own[0], :, 3] -= 0.5
    node, axes_in_node = _axes_at(chain, nodes.setup.wrench_axes)
    axes[:, node + 1, 0, :3] = axes_in_node[:3, :3].T
    return matrix.reshape(len(matrix), -1)


def _axes_at(chain: NodeChain, axes: Attachment) -> tuple[int, Floats]:
    """Return the node that a reading's axes are fixed on: the ground's own, whatever the base does."""
    return (-1, axes.transform) if axes.body == 0 else chain.placed(axes)


def wrench_matrix(gravity: Floats, moments: bool) -> Floats:
    """Return (9, 48): the matrix (8, 6) from a node's levers and masses to its wrench, over (F, 0, M, 0, 1)."""
    matrix = np.zeros((9, 8, 6))
    for k, axis in enumerate(np.eye(3)):
        matrix[k, 3, :3] = axis
        matrix[k, :3, 3:] = [np.cross(lever, axis) for lever in np.eye(3)]
        if moments:
            matrix[4 + k, 3, 3:] = axis
        matrix[8, 4 + k, 3:] = np.cross(axis, gravity)
    matrix[8, 7, :3] = gravity
    return matrix.reshape(9, 48)


class ChainPair:
    """The chain's two shapes.

    Parameters
    ----------
    chain : the row of nodes.
    nodes : what they give by.
    motion : (J, L) model angles per logged angle.
    damping : of `motion_and_damping`, m/rad or rad/rad.

    Attributes
    ----------
    axes_of_reading : (3, 4) the reading's axes in base axes, row by row, on the loaded shape; the last column is 0.
    motion_and_damping : (6, L + 6) −J, how the target moves per logged angle, base axes, halfway between both shapes,
        and with it the damping on a diagonal.
    """

    def __init__(self, chain: NodeChain, nodes: LinearNodes, motion: Floats, damping: float) -> None:
        count = len(chain.nodes)
        self._place_frames(chain, nodes, len(motion))
        self._place_wrenches(chain, nodes, count)
        self._place_target(chain, nodes, motion, damping)
        self.straighten()

    def _place_frames(self, chain: NodeChain, nodes: LinearNodes, n_joints: int) -> None:
        count = len(chain.nodes)
        self._features = np.zeros(1 + 2 * n_joints)
        self._features[0] = 1.0
        self._cosine, self._sine = self._features[1 : 1 + n_joints], self._features[1 + n_joints :]
        self._turning = turning_basis(chain, n_joints)
        self._prismatic, self._slides = chain.prismatic, bool(chain.prismatic.any())
        self._local = np.zeros((count, 4, 4))  # from the displaced node before to the node, joint turned
        self._local_flat = self._local.reshape(-1)
        self._to_move = displacement_basis(nodes.deformed)
        self._move_flat = np.zeros((2 * count, 16))
        self._move = self._move_flat.reshape(2, count, 4, 4)
        # What takes both shapes' frame after one node's displacement to the next node's, before and after its own.
        links = np.zeros((count, 2, 2, 4, 2, 4))
        self._link_before, self._link_after = np.einsum("kzsasb->zskab", links)
        frames = np.zeros((count + 1, 2, 2, 4, 4))
        frames[:] = np.eye(4)
        steps = links.reshape(count, 16, 8)
        self._links = [(steps[k], frames[k, 1].reshape(8, 4), frames[k + 1].reshape(16, 4)) for k in range(count)]
        self._from_base = np.transpose(frames[1:, 0, :, :3, :3], (1, 0, 3, 2))
        self._frames = frames.reshape(-1, 4)
        # Of each shape's each node: lever to the load and 1, moment of what it carries and its mass; then the reading's
        # axes, then the mean levers to the target.
        self._seeing = seeing_matrix(chain, nodes)
        self._measured = np.zeros((len(self._seeing), 4))
        self._levers = self._measured[: 4 * count].reshape(2, count, 8)
        self.axes_of_reading = self._measured[4 * count : 4 * count + 3]
        self._mean_arm = self._measured[4 * count + 3 :, :3]
        self._frames_of_node = frames[1:].reshape(count, 4, 16)
        self._quarter, self._mean_flat = np.full((1, 4), 0.25), np.zeros((count, 1, 16))
        self._mean_axes = self._mean_flat.reshape(count, 4, 4)[:, :3, :3]

    def _place_wrenches(self, chain: NodeChain, nodes: LinearNodes, count: int) -> None:
        self._load = np.zeros((2, 9))  # force, 0, moment, 0 in base axes, and 1; none on the unloaded shape
        self._load[:, 8] = 1.0
        self._loaded = self._load[0, :8].reshape(2, 4)
        self._to_wrench = wrench_matrix(chain.gravity, nodes.setup.moments_measured)
        self._per_lever_flat = np.zeros((2, 48))
        self._per_lever = self._per_lever_flat.reshape(2, 8, 6)
        self._wrench = np.zeros((2, count, 6))
        self._wrench_parts = self._wrench.reshape(2, count, 2, 3)
        self._carried = np.zeros((2, 6 * count + 1))
        self._carried[:, -1] = 1.0
        self._carried_parts = self._carried[:, :-1].reshape(2, count, 2, 3)
        give = np.zeros((6 * count + 1, count, SIX_AND_ONE))
        give[:-1, :, :6] = nodes.compliance.T.reshape(6 * count, count, 6)
        give[-1, :, 6] = 1.0
        self._give = give.reshape(6 * count + 1, -1)
        self._small = np.zeros((2, SIX_AND_ONE * count))
        self._small_rows = self._small.reshape(2 * count, SIX_AND_ONE)
        self._small_loaded, self._small_unloaded = self._small
        self._small_nodes = self._small.reshape(2, count, SIX_AND_ONE)
        self._carried_wrench = self._carried[:, :-1]
        self._laws = ScalarResponses(nodes, count)

    def _place_target(self, chain: NodeChain, nodes: LinearNodes, motion: Floats, damping: float) -> None:
        count, size, n_logged = len(chain.nodes), SIX_AND_ONE * len(chain.nodes), motion.shape[1]
        inboard = chain.placed(nodes.setup.targets[0])[0] + 1  # nodes that move the target
        # How the target moves per displacement of every node, and its damping.
        self._reach = np.zeros((6, size + 6))
        self._reach[:, size:] = damping * np.eye(6)
        of_node = np.moveaxis(self._reach[:, :size].reshape(6, count, SIX_AND_ONE)[:, :inboard], 1, 0)
        self._by_shift, self._by_turn = of_node[:, :3, :3], of_node[:, :, 3:6]
        # Per turn about a node: −[arm]×, the target's shift, above the turn itself.
        self._lever_matrix = np.zeros((inboard, 6, 3))
        self._lever_matrix[:, 3:] = np.eye(3)
        self._minus_skew = self._lever_matrix.reshape(inboard, 18)[:, :9]
        self._mean_arm = self._mean_arm[:inboard]
        self._axes = np.swapaxes(self._mean_axes[:inboard], 1, 2)
        self._moved = np.zeros(size + 6)
        self._moved_nodes = self._moved[:size]
        self._choice = np.zeros((size + 6, n_logged + 6))
        self._choice[size:, n_logged:] = np.eye(6)
        for node in np.flatnonzero(chain.joint >= 0):
            component = 2 if chain.prismatic[chain.joint[node]] else 5
            self._choice[SIX_AND_ONE * node + component, :n_logged] = -motion[chain.joint[node]]
        self.motion_and_damping = np.zeros((6, n_logged + 6))

    def straighten(self) -> None:
        """Forget the nodes' displacements: the next shapes are the rigid chain's."""
        self._move[:] = np.eye(4)
        self._small[:] = 0.0
        self._laws.forget()

    def remember(self) -> None:
        """Keep what laws with a memory remember of this call's load."""
        self._laws.remember()

    def stand(self, angles: Floats) -> None:
        """Put both shapes to model angles (J,), rad (prismatic joints: m), the nodes displaced as they last were."""
        self._laws.stand(angles)
        np.cos(angles, self._cosine)
        np.sin(angles, self._sine)
        if self._slides:
            np.copyto(self._cosine, angles, where=self._prismatic)
        np.dot(self._features, self._turning, self._local_flat)
        self.place()

    def place(self) -> None:
        """Put all frames where angles and displacements lead."""
        np.copyto(self._link_before, self._local)
        np.matmul(self._move, self._local, self._link_after)
        for link, before, after in self._links:
            np.dot(link, before, after)
        np.dot(self._seeing, self._frames, self._measured)

    def respond(self, wrench: Floats) -> None:
        """Find what the nodes carry on the present shapes, and their displacements by it.

        Parameters
        ----------
        wrench : (2, 3) force and moment of this sample's process, in the reading's axes.
        """
        np.dot(wrench, self.axes_of_reading, self._loaded)
        np.dot(self._load, self._to_wrench, self._per_lever_flat)
        np.matmul(self._levers, self._per_lever, self._wrench)
        np.matmul(self._wrench_parts, self._from_base, self._carried_parts)
        if self._laws.present:
            self._laws.load(self._carried_wrench, self._small_nodes)
        np.dot(self._carried, self._give, self._small)
        if self._laws.present:
            self._laws.respond(self._carried_wrench, self._small_nodes)
        np.dot(self._small_rows, self._to_move, self._move_flat)

    def deflect(self, deflection: Floats) -> None:
        """Write the target's way from the unloaded shape to the loaded one into (6,), m and rad, base axes.

        Taken halfway, of the nodes' own turn too, where the chain's derivative is exact to the second order; it stays
        for `motion_and_damping`.
        """
        np.matmul(self._quarter, self._frames_of_node, self._mean_flat)
        np.matmul(self._mean_arm, MINUS_SKEW, self._minus_skew)
        np.matmul(self._lever_matrix, self._axes, self._by_turn)
        np.copyto(self._by_shift, self._axes)
        np.subtract(self._small_loaded, self._small_unloaded, self._moved_nodes)
        np.dot(self._reach, self._moved, deflection)
        np.dot(self._reach, self._choice, self.motion_and_damping)

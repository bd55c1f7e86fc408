"""Two shapes of one chain, loaded and unloaded, in arrays that stand ready.

Nothing here allocates arrays after construction: every operation writes into one of the arrays below, through views
that are made once. Axis 0 is the shape: 0 under load and weight, 1 under weight alone.

Why products where a formula would do: for arrays as small as a robot's, calling numpy is what costs, so that the fewest
calls win. A cross product with one vector for all rows is a product with its skew matrix, a skew matrix is a product of
the vector with a constant (3, 9), and a displaced frame is a product of its displacement, squares included, with a
constant (16, 16).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.compensation.linear_nodes import LinearNodes, NodeChain
from stiffcal.mechanics.rotations import cross_matrix

Floats = NDArray[np.float64]

# v @ SKEW is [v]× in nine numbers; a row v with w of the same row: v @ [w]× = v × w.
SKEW = np.stack([cross_matrix(axis).ravel() for axis in np.eye(3)])
# Twice the sine of a small turn from its nine numbers: R32 − R23, R13 − R31, R21 − R12, halved.
VEE = 0.5 * SKEW.T


def displacement_matrix() -> Floats:
    """Return (16, 16): the transform I + [φ]× + [φ]×²/2 with its shift, from (1, shift, φ, φ φᵀ); exact to 10⁻⁹."""
    matrix = np.zeros((16, 4, 4))
    matrix[0] = np.eye(4)
    matrix[1:4, :3, 3] = np.eye(3)
    matrix[4:7, :3, :3] = SKEW.reshape(3, 3, 3)
    for i in range(3):
        for j in range(3):
            # [φ]×² = φ φᵀ − (φ·φ) I
            matrix[7 + 3 * i + j, i, j] += 0.5
            if i == j:
                matrix[7 + 3 * i + j, :3, :3] -= 0.5 * np.eye(3)
    return matrix.reshape(16, 16)


class Shapes:
    """The chain's two shapes.

    Parameters
    ----------
    chain : the row of nodes.
    nodes : what they give by.

    Attributes
    ----------
    axes_of_reading : (3, 3) base_from_reading's axes on the loaded shape.
    jacobian : (J, 6), row k: how the target moves when joint k turns by one, on the loaded shape; ``jacobian_columns``
        is its transpose.

    Raises
    ------
    ValueError : the load does not act on the outermost body that gives.
    """

    def __init__(self, chain: NodeChain, nodes: LinearNodes) -> None:
        count = len(chain.nodes)
        self._place_frames(chain, count)
        self._place_displacements(count)
        self._place_load(chain, nodes)
        self._place_carried(chain, nodes, count)
        self._place_target(chain, nodes)

    def _place_frames(self, chain: NodeChain, count: int) -> None:
        turning = np.flatnonzero(chain.joint >= 0)
        self._local = chain.fixed.copy()  # (N, 4, 4) from the displaced node before, joint turned
        # x and y columns of the frames that turn, and (y, −x): x cos + y sin, y cos − x sin
        self._still = np.ascontiguousarray(np.moveaxis(chain.fixed[turning][:, :, :2], 2, 0))
        self._across = np.stack([self._still[1], -self._still[0]])
        self._turned, self._room = np.zeros_like(self._still), np.zeros_like(self._still)
        whole = np.moveaxis(self._local[:, :, :2], 2, 0)
        self._columns = [(whole[:, node], self._turned[:, place]) for place, node in enumerate(turning)]
        if len(turning) == count:
            self._columns = [(whole, self._turned)]
        self._sine, self._cosine = np.zeros((len(turning), 1)), np.zeros((len(turning), 1))
        self._sine_flat, self._cosine_flat = self._sine[:, 0], self._cosine[:, 0]
        # The ground, then every node; nodes outermost in memory, so that none overlaps the next: numpy would copy it.
        self._displaced = np.moveaxis(np.tile(np.eye(4), (count + 1, 2, 1, 1)), 1, 0)
        self._before, self._after = self._displaced[:, :-1], self._displaced[:, 1:]
        self._step = np.zeros((2, count, 4, 4))
        self._links = [(self._displaced[:, k], self._step[:, k], self._displaced[:, k + 1]) for k in range(count)]
        self._node = np.zeros((2, count, 4, 4))  # node frames before their own displacement
        self._to_node = np.swapaxes(self._node[..., :3, :3], 2, 3)

    def _place_displacements(self, count: int) -> None:
        self._small = np.zeros((2, 6 * count))
        self._small_of = self._small.reshape(2, count, 6)
        self._features = np.zeros((2, count, 16))
        self._features[..., 0] = 1.0
        self._linear = self._features[..., 1:7]
        self._squares = self._features[..., 7:].reshape(2, count, 3, 3)
        turn = self._small_of[..., 3:]
        self._turn_column, self._turn_row = turn[..., :, None], turn[..., None, :]
        self._to_move = displacement_matrix()
        self._move_flat = np.zeros((2, count, 16))
        self._move = self._move_flat.reshape(2, count, 4, 4)
        self.straighten()

    def _place_load(self, chain: NodeChain, nodes: LinearNodes) -> None:
        setup = nodes.setup
        node, there = chain.placed(setup.wrench_axes)
        if setup.wrench_axes.body == 0:
            node, there = -1, setup.wrench_axes.transform  # the ground's axes, whatever the base does
        self._axes_there = np.ascontiguousarray(there[:3, :3])
        self._axes_frame = self._displaced[:, node + 1, :3, :3]
        node, there = chain.placed(setup.wrench_point)
        if node != len(chain.nodes) - 1:
            raise ValueError("a controller's loop wants the load on the outermost body that gives, the flange")
        self._point_frame, self._point_there = self._displaced[:, node + 1, :3, :], there[:, 3].copy()
        self._axes, self._point = np.zeros((2, 3, 3)), np.zeros((2, 3))
        self.axes_of_reading = self._axes[0]
        self._point_each = self._point[:, None, :]
        self._load = np.zeros((2, 3, 2))  # columns: force, moment
        self._load_force, self._load_moment = self._load[0, :, 0], self._load[0, :, 1]
        self._moments = setup.moments_measured
        self._in_base = np.zeros((2, 3, 2))
        self._force, self._force_skew = self._in_base[..., 0], np.zeros((2, 9))
        self._skew_of_force = self._force_skew.reshape(2, 3, 3)
        self._force_each, self._moment_each = self._in_base[:, None, :, 0], self._in_base[:, None, :, 1]

    def _place_carried(self, chain: NodeChain, nodes: LinearNodes, count: int) -> None:
        self._mass = np.cumsum(chain.mass[::-1])[::-1, None].copy()  # outboard of each node
        self._weight = self._mass * chain.gravity
        self._has_weight = bool(np.any(self._weight))
        self._gravity_skew = cross_matrix(chain.gravity)
        self._mass_there = np.concatenate([chain.mass_moment, chain.mass[:, None]], axis=1)[..., None]
        self._mass_moment, self._mass_sum = np.zeros((2, count, 3, 1)), np.zeros((2, count, 3))
        self._inward, self._sum_inward = self._mass_moment[:, ::-1, :, 0], self._mass_sum[:, ::-1]
        self._after_top, self._origin = self._after[..., :3, :], self._after[..., :3, 3]
        self._arm, self._term = np.zeros((2, count, 3)), np.zeros((2, count, 3))
        self._wrench = np.zeros((2, count, 3, 2))
        self._wrench_force, self._wrench_moment = self._wrench[..., 0], self._wrench[..., 1]
        self._carried = np.zeros((2, count, 3, 2))
        self._carried_flat = self._carried.reshape(2, -1)
        # columns in the order in which the wrench components lie in ``_carried``: Fx, Mx, Fy, My, Fz, Mz of each node
        order = (6 * np.arange(count)[:, None] + np.array([0, 3, 1, 4, 2, 5])).ravel()
        self._compliance = np.ascontiguousarray(nodes.compliance[:, order].T)

    def _place_target(self, chain: NodeChain, nodes: LinearNodes) -> None:
        node, there = chain.placed(nodes.setup.targets[0])
        self._target_frame, self._target_there = self._displaced[:, node + 1, :3, :], there[:, 3].copy()
        self._target = np.zeros((2, 3))
        turned = self._displaced[:, node + 1, :3, :3]
        self._turned_loaded, self._turned_back = turned[0], turned[1].T
        self._between = np.zeros((3, 3))
        self._between_flat = self._between.ravel()
        self._joints = np.flatnonzero(chain.joint >= 0)
        count = len(self._joints)
        self._node_rows, self._joint_rows = self._node[0].reshape(-1, 16), np.zeros((count, 16))
        frames = self._joint_rows.reshape(count, 4, 4)
        self._axis, self._joint_origin = frames[:, :3, 2], frames[:, :3, 3]
        self._axis_skew, self._minus_skew = np.zeros((count, 9)), -SKEW
        self._skew_of_axis = self._axis_skew.reshape(count, 3, 3)
        self._joint_arm = np.zeros((count, 1, 3))
        self._joint_arm_flat = self._joint_arm[:, 0]
        self.jacobian = np.zeros((count, 6))
        self.jacobian_columns = self.jacobian.T
        self._jacobian_shift, self._jacobian_turn = self.jacobian[:, None, :3], self.jacobian[:, 3:]
        self._outboard = self.jacobian[int(np.searchsorted(self._joints, node, side="right")) :]

    def straighten(self) -> None:
        """Forget the nodes' displacements: the next shapes are the rigid chain's."""
        self._move[:] = np.eye(4)

    def stand(self, angles: Floats) -> None:
        """Put both shapes to model angles (J,), rad, the nodes displaced as they last were."""
        np.sin(angles, self._sine_flat)
        np.cos(angles, self._cosine_flat)
        np.multiply(self._still, self._cosine, self._turned)
        np.multiply(self._across, self._sine, self._room)
        np.add(self._turned, self._room, self._turned)
        for place, column in self._columns:
            np.copyto(place, column)
        self._place()

    def load(self, wrench: Floats) -> None:
        """Take the process wrench (6,) of this sample."""
        np.copyto(self._load_force, wrench[:3])
        if self._moments:
            np.copyto(self._load_moment, wrench[3:])

    def sweep(self) -> None:
        """Find what the nodes carry on the present shapes, and the shapes that follow from it."""
        np.matmul(self._axes, self._load, self._in_base)
        np.matmul(self._force, SKEW, self._force_skew)
        np.matmul(self._point_frame, self._point_there, self._point)
        np.subtract(self._point_each, self._origin, self._arm)
        np.matmul(self._arm, self._skew_of_force, self._wrench_moment)
        np.add(self._wrench_moment, self._moment_each, self._wrench_moment)
        if self._has_weight:
            np.matmul(self._after_top, self._mass_there, self._mass_moment)
            np.add.accumulate(self._inward, 1, None, self._sum_inward)
            np.multiply(self._origin, self._mass, self._term)
            np.subtract(self._mass_sum, self._term, self._term)
            np.matmul(self._term, self._gravity_skew, self._arm)
            np.add(self._wrench_moment, self._arm, self._wrench_moment)
        np.add(self._force_each, self._weight, self._wrench_force)
        np.matmul(self._to_node, self._wrench, self._carried)
        np.matmul(self._carried_flat, self._compliance, self._small)
        self._displace()

    def _displace(self) -> None:
        """Move every node by its small displacement."""
        np.copyto(self._linear, self._small_of)
        np.multiply(self._turn_column, self._turn_row, self._squares)
        np.matmul(self._features, self._to_move, self._move_flat)
        self._place()

    def _place(self) -> None:
        """Put all frames where angles and displacements lead."""
        np.matmul(self._local, self._move, self._step)
        for before, step, after in self._links:
            np.matmul(before, step, after)
        np.matmul(self._before, self._local, self._node)
        np.matmul(self._axes_frame, self._axes_there, self._axes)

    def difference(self, deflection: Floats) -> None:
        """Write the target's displacement from the unloaded shape to the loaded one into (6,), m and rad, base axes."""
        np.matmul(self._target_frame, self._target_there, self._target)
        np.subtract(self._target[0], self._target[1], deflection[:3])
        np.dot(self._turned_loaded, self._turned_back, self._between)
        np.matmul(self._between_flat, VEE, deflection[3:])

    def differentiate(self) -> None:
        """Write the loaded shape's Jacobian at the target into ``jacobian``."""
        np.take(self._node_rows, self._joints, 0, self._joint_rows, "clip")
        np.matmul(self._axis, self._minus_skew, self._axis_skew)
        np.subtract(self._target[0], self._joint_origin, self._joint_arm_flat)
        np.matmul(self._joint_arm, self._skew_of_axis, self._jacobian_shift)
        np.copyto(self._jacobian_turn, self._axis)
        if self._outboard.size:
            self._outboard.fill(0.0)

"""How far a load moves the targets of the deformed chain: from its rest under weight, or from where the file has it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import BLOCK, StackedFrame, cross, from_frame, stacked_bodies, turn_between
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.no_balance import NoBalanceError as NoBalanceError
from stiffcal.model.balance.rest import TOLERANCE, Rest, find_rest
from stiffcal.model.effect import Inputs, StateOrder, Term, joint_nodes, tool_node


@dataclass(frozen=True)
class Balance:
    """Where the targets are at rest, and how far the load moved them."""

    target_position: Floats
    """(n, B, 3) base axes, m."""
    target_rotation: Floats
    """(n, B, 3, 3) base_from_target."""
    unloaded_position: Floats
    """(n, B, 3) m, base axes, under weight alone."""
    unloaded_rotation: Floats
    """(n, B, 3, 3) base_from_target under weight alone."""
    displacement: Floats
    """(n, B, 6) from the weight-only state: difference of positions, and rotation vector of R R_refᵀ, base axes, m and
    rad.
    """
    joint_torque: Floats
    """(n, J) whole torque about the joints' axes at rest, N·m; of prismatic joints the force along them, N."""
    nodes: Floats
    """(n, 2J + 2, 6) every node's own small displacement, from the weight-only state, in the node's axes, m and rad; 2k
    is the outboard end of link k in beam axes, which the rods on the link measure.
    """


def blocks(run: NDArray[np.int64] | None, n: int, keep_runs: bool) -> Iterator[slice]:
    """Cut n states into blocks for the cache; with ``keep_runs`` only between runs, for laws with a memory."""
    if not keep_runs or run is None:
        for start in range(0, n, BLOCK):
            yield slice(start, min(start + BLOCK, n))
        return
    edges = np.concatenate([np.flatnonzero(np.diff(run)) + 1, [n]])
    start = 0
    for edge in edges:
        if edge - start >= BLOCK or edge == n:
            yield slice(start, int(edge))
            start = int(edge)


def displacement_between(loaded: StackedFrame, unloaded: StackedFrame) -> Floats:
    """Return (6, n): position difference and rotation vector of R R_refᵀ, base axes."""
    return np.concatenate([loaded.position - unloaded.position, turn_between(loaded.rotation, unloaded.rotation)])


def last_node_inboard(body: int, n_joints: int) -> int:
    """Return the outermost node whose displacement moves a body: joint k's for link k, the tool's for the flange."""
    return 2 * n_joints + 1 if body == n_joints + 1 else max(2 * body - 1, 0)


def first_order_displacement(rest: Rest, nodes: Floats | None = None) -> list[Floats]:
    """Return each target's (6, n) by the papers' linear form: Jacobian columns times node displacements (002, eq. 8).

    Parameters
    ----------
    nodes : (2J + 2, 6, n) small displacements in the nodes' axes, counted from the shape at rest; None for the whole
        displacement of a shape that is drawn undeformed.
    """
    nodes = rest.displacement if nodes is None else nodes
    n_joints = len(rest.shape.bodies) - 2
    outermost = [last_node_inboard(target.body, n_joints) for target in rest.inputs.setup.targets]
    result = [np.zeros_like(nodes[0]) for _ in outermost]
    for node, small in enumerate(nodes):
        if not small.any():
            continue
        axes = rest.shape.nodes[node].rotation
        move, turn = from_frame(axes, small[:3]), from_frame(axes, small[3:])
        for last, frame, displacement in zip(outermost, rest.targets, result, strict=True):
            if node <= last:
                displacement[:3] += move + cross(turn, frame.position - rest.shape.origins[node])
                displacement[3:] += turn
    return result


@dataclass(frozen=True)
class WeightOnlyRest:
    """What displacements are counted from, state axis last: of loads the rest under weight alone.

    Of absolute places it is the undeformed robot as the robot file and the manifest describe it, without any effect:
    what weight does is then part of the displacement.
    """

    targets: list[StackedFrame]
    """Each target's frame."""
    linear: list[Floats]
    """Each target's (6, n) first-order displacement; empty in the finite form."""
    wrench: Floats
    """(2J + 2, 6, n) N, N·m, wrench of each node, its axes; zero where displacements are absolute."""
    displacement: Floats
    """(2J + 2, 6, n) m, rad, displacement of each node, its axes."""
    terms: list[tuple[PlacedEffect, Term]]
    """The laws' terms."""
    absolute: Booleans | None = None
    """(n,) True where it is the robot file's undeformed robot; None: nowhere."""
    poses: Rest | None = None
    """The rest of each stretch of states that share it; None where no robot with effects rests."""
    pose: Integers | None = None
    """(n,) which of them."""


def rest_under_weight(
    robot: CompliantRobot, inputs: Inputs, tolerance: float = TOLERANCE, order: StateOrder | None = None
) -> WeightOnlyRest:
    """Find the rest under weight alone: no load, no memory, motors where the reference left them, at its temperature.

    States of one pose share it, so that it is found once for each stretch of equal angles (and temperatures).
    """
    kelvin = np.full(inputs.angles.shape[1], np.nan) if order is None else order.reference_kelvin
    tracker = np.zeros(len(kelvin)) if inputs.tracker is None else inputs.tracker
    distinct = np.vstack([inputs.angles, np.nan_to_num(kelvin).round(6), tracker])
    first = np.concatenate([[0], np.flatnonzero(np.any(np.diff(distinct, axis=1) != 0.0, axis=0)) + 1])
    pick = np.repeat(np.arange(len(first)), np.diff(np.append(first, inputs.angles.shape[1])))
    poses = replace(
        inputs,
        angles=np.ascontiguousarray(inputs.angles[:, first]),
        wrench=np.zeros((len(inputs.wrench), len(first))),
        loaded=False,
        tracker=None if inputs.tracker is None else inputs.tracker[first],
    )
    try:
        rest = find_rest(robot, poses, tolerance=tolerance, kelvin=kelvin[first])
    except NoBalanceError as error:
        raise error.at_state(int(first[error.state])) from None
    frames = rest.targets
    linear = [] if robot.deformed else first_order_displacement(rest)
    return WeightOnlyRest(
        targets=[frame.states(pick) for frame in frames],
        linear=[factors[:, pick] for factors in linear],
        wrench=rest.wrench[:, :, pick],
        displacement=rest.displacement[:, :, pick],
        terms=[(placed_effect, replace(term, value=term.value[pick])) for placed_effect, term in rest.terms],
        poses=rest,
        pose=pick,
    )


def nominal_robot(chain: Chain, inputs: Inputs) -> WeightOnlyRest:
    """Return the undeformed robot of the robot file, which absolute places are counted from.

    Parameters
    ----------
    chain : as the robot file describes it, without what effects change.
    inputs : angles (J, n) as logged, and the set-up of the manifest.
    """
    n, n_nodes = inputs.angles.shape[1], 2 * chain.n_joints + 2
    bodies = stacked_bodies(chain, inputs.angles)
    targets = [bodies[target.body].moved(target.transform) for target in inputs.setup.targets]
    nothing = np.zeros((n_nodes, 6, n))
    return WeightOnlyRest(targets, [np.zeros((6, n)) for _ in targets], nothing, nothing, [])


def counted_from(unloaded: WeightOnlyRest, nominal: WeightOnlyRest, absolute: Booleans) -> WeightOnlyRest:
    """Return one origin of displacements for states of both kinds: ``nominal`` for those that are ``absolute`` (n,)."""
    targets = [
        StackedFrame(
            np.where(absolute, rigid.rotation, rest.rotation), np.where(absolute, rigid.position, rest.position)
        )
        for rest, rigid in zip(unloaded.targets, nominal.targets, strict=True)
    ]
    return WeightOnlyRest(
        targets,
        [np.where(absolute, 0.0, linear) for linear in unloaded.linear],
        np.where(absolute, 0.0, unloaded.wrench),
        np.where(absolute, 0.0, unloaded.displacement),
        [(placed, replace(term, value=np.where(absolute, 0.0, term.value))) for placed, term in unloaded.terms],
        absolute,
        unloaded.poses,
        unloaded.pose,
    )


def displacements(robot: CompliantRobot, loaded: Rest, unloaded: WeightOnlyRest) -> list[Floats]:
    """Return each target's (6, n) displacement from where it is counted, base axes, m and rad."""
    if robot.deformed:
        return [
            displacement_between(after, before) for after, before in zip(loaded.targets, unloaded.targets, strict=True)
        ]
    linear = first_order_displacement(loaded)
    change = [after - before for after, before in zip(linear, unloaded.linear, strict=True)]
    if unloaded.absolute is None:
        return change
    # Here the chain is drawn undeformed: where geometry and frames put it counts next to what it gives.
    return [
        sag + np.where(unloaded.absolute, displacement_between(drawn, nominal), 0.0)
        for sag, drawn, nominal in zip(change, loaded.targets, unloaded.targets, strict=True)
    ]


def solve_balance(
    robot: CompliantRobot,
    joints: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    order: StateOrder | None = None,
) -> Balance:
    """Predict where the targets come to rest, exactly.

    Parameters
    ----------
    robot : chain and effects with values.
    joints : (n, J) model joint angles, rad (``chain.model_angles`` of the logged ones).
    wrench : (n, 6) N and N·m in the set-up's wrench axes about its wrench point, acting on the robot.
    setup : where the instruments sit.
    order : order and time of the states, for laws with a memory; states of a run contiguous.

    Raises
    ------
    NoBalanceError : the load is more than the springs hold.
    """
    return RobotAtJoints(robot, joints, setup, order).under(wrench)


class RobotAtJoints:
    """A robot at the same joint angles under one load after another.

    With ``keep`` the rest under weight alone is found once, and each balance is sought from the last one; that holds
    all nodes' displacements of all states.
    """

    def __init__(
        self,
        robot: CompliantRobot,
        joints: Floats,
        setup: MeasurementSetup,
        order: StateOrder | None = None,
        keep: bool = False,
    ) -> None:
        self._robot, self._joints, self._setup, self._order, self._keep = robot, joints, setup, order, keep
        self._last: dict[int, tuple[WeightOnlyRest, Floats]] = {}

    def under(self, wrench: Floats) -> Balance:
        """Return the balance under a load (n, 6); see `solve_balance`."""
        robot, order, n, n_bodies = self._robot, self._order, len(self._joints), len(self._setup.targets)
        position, rotation = np.empty((n, n_bodies, 3)), np.empty((n, n_bodies, 3, 3))
        position_0, rotation_0 = np.empty_like(position), np.empty_like(rotation)
        displacement, torque = np.empty((n, n_bodies, 6)), np.empty((n, robot.chain.n_joints))
        nodes = np.empty((n, tool_node(robot.chain) + 1, 6))
        for block in blocks(None if order is None else order.run, n, robot.has_memory):
            unloaded, loaded = self._rests(block, wrench)
            torque[block] = loaded.wrench[joint_nodes(robot.chain), robot.chain.drive_components].T
            nodes[block] = np.moveaxis(loaded.displacement - unloaded.displacement, -1, 0)
            moves = displacements(robot, loaded, unloaded)
            for body, (after, before) in enumerate(zip(loaded.targets, unloaded.targets, strict=True)):
                displacement[block, body] = moves[body].T
                position[block, body], rotation[block, body] = after.position.T, np.moveaxis(after.rotation, -1, 0)
                position_0[block, body] = before.position.T
                rotation_0[block, body] = np.moveaxis(before.rotation, -1, 0)
        return Balance(position, rotation, position_0, rotation_0, displacement, torque, nodes)

    def _rests(self, block: slice, wrench: Floats) -> tuple[WeightOnlyRest, Rest]:
        robot, order = self._robot, None if self._order is None else self._order.block(block)
        angles, load = np.ascontiguousarray(self._joints[block].T), np.ascontiguousarray(wrench[block].T)
        inputs = Inputs(angles, load, self._setup)
        try:
            if block.start in self._last:
                unloaded, start = self._last[block.start]
            else:
                unloaded = rest_under_weight(robot, inputs, order=order)
                start = unloaded.displacement
            loaded = find_rest(robot, inputs, order, unloaded.wrench, start)
        except NoBalanceError as error:
            raise error.at_state(block.start + error.state) from None
        if self._keep:
            self._last[block.start] = unloaded, loaded.displacement
        return unloaded, loaded

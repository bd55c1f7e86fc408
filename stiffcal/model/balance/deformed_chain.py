"""The chain in one shape, and what its nodes carry there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import StackedFrame, base_frame, cross, from_frame, to_frame
from stiffcal.model.effect import RZ, Inputs


@dataclass(frozen=True)
class DeformedChain:
    """A chain in one shape: n states, state axis last."""

    bodies: list[StackedFrame]
    """J + 2 frames, base to flange, on the deformed chain."""
    nodes: list[StackedFrame]
    """2J + 2 frames of the nodes before their own displacement."""
    origins: list[Floats]
    """Where each node turns about, (3, n) in base axes: its origin after its own shift. A node that shifts and turns
    gives the more work to its moment the farther it has shifted: moments that belong to the turn are those about the
    shifted origin.
    """


def deformed_chain(
    chain: Chain, angles: Floats, small: Floats | None, turns: tuple[Floats, Floats] | None = None
) -> DeformedChain:
    """Place every body and node of the chain whose nodes are displaced by ``small``.

    Parameters
    ----------
    angles : (J, n) model angles, rad.
    small : (2J + 2, 6, n) node displacements in node axes, or None for the rigid chain.
    turns : (J, n) each, cosines and sines of the angles, where many shapes have the same; None: computed here.
    """
    cosine, sine = turns or (np.cos(angles), np.sin(angles))
    beams = {beam.joint: beam.end for beam in chain.beams.values()}
    frame = base_frame(angles.shape[1])
    nodes, origins, bodies = [], [], []

    def displace(node: StackedFrame, number: int) -> StackedFrame:
        displaced_node = node if small is None else _node_moved(node, small[number])
        nodes.append(node)
        origins.append(displaced_node.position)
        return displaced_node

    frame = displace(frame, 0)
    bodies.append(frame)
    for k in range(1, chain.n_joints + 1):
        fixed = frame.moved(chain.fixed[k - 1])
        if k in chain.prismatic_joints:
            frame = fixed.shifted_along_z(angles[k - 1])
        else:
            frame = fixed.turned_about_z_by(cosine[k - 1], sine[k - 1])
        bearing = float(chain.bearing[k - 1])
        frame = _shift_along_z(displace(_shift_along_z(frame, bearing), 2 * k - 1), -bearing)
        bodies.append(frame)
        if k in beams:
            end = frame.moved(beams[k])
            displaced_end = displace(end, 2 * k)
            frame = frame if displaced_end is end else displaced_end.moved(_inverse(beams[k]))
        else:
            nodes.append(frame)
            origins.append(frame.position)
    bodies.append(displace(frame.moved(chain.flange), 2 * chain.n_joints + 1))
    return DeformedChain(bodies, nodes, origins)


def _shift_along_z(frame: StackedFrame, distance: float) -> StackedFrame:
    return frame if distance == 0.0 else StackedFrame(frame.rotation, frame.position + distance * frame.rotation[:, 2])


def _node_moved(frame: StackedFrame, small: Floats) -> StackedFrame:
    # A plain drive only turns about z: much cheaper than the general displacement, and exact.
    if small[:RZ].any():
        return frame.displaced(small)
    return frame.turned_about_z(small[RZ]) if small[RZ].any() else frame


def _inverse(rigid: Floats) -> Floats:
    result = np.eye(4)
    result[:3, :3] = rigid[:3, :3].T
    result[:3, 3] = -rigid[:3, :3].T @ rigid[:3, 3]
    return result


def unit_wrenches(chain: Chain, shape: DeformedChain, inputs: Inputs) -> tuple[Floats, Floats]:
    """Return the loads of the nodes per unit of the reading, without weight.

    Parameters
    ----------
    shape : the chain as it stands.
    inputs : set-up of the reading.

    Returns
    -------
    direct : (2J + 2, 3, 3, n) force by force, and moment by moment: component in node axes, axis of the reading.
    levered : (2J + 2, 3, 3, n) moment by force, m. Zero for nodes outboard of the load.
    """
    setup = inputs.setup
    axes = _reading_axes(shape, setup, inputs.angles.shape[1])
    point = shape.bodies[setup.wrench_point.body].point(setup.wrench_point.transform[:3, 3])
    direct = np.zeros((len(shape.nodes), 3, 3, point.shape[1]))
    levered = np.zeros_like(direct)
    loaded_body = setup.wrench_point.body
    last_loaded = 2 * chain.n_joints + 1 if loaded_body == chain.n_joints + 1 else 2 * loaded_body
    for node in range(last_loaded + 1):
        if not _is_node(chain, node):
            continue
        rotation, arm = shape.nodes[node].rotation, point - shape.origins[node]
        for axis in range(3):
            force = axes.rotation[:, axis]
            direct[node, :, axis] = to_frame(rotation, force)
            levered[node, :, axis] = to_frame(rotation, cross(arm, force))
    return direct, levered


def _reading_axes(shape: DeformedChain, setup: MeasurementSetup, n: int) -> StackedFrame:
    """Return the axes of the wrench's components; base axes are those of the ground, whatever the foundation does."""
    body = base_frame(n) if setup.wrench_axes.body == 0 else shape.bodies[setup.wrench_axes.body]
    return body.moved(setup.wrench_axes.transform)


def _is_node(chain: Chain, node: int) -> bool:
    """Return whether anything can give there: links without a beam are no node, and what they carry is not needed."""
    bending = {2 * beam.joint for beam in chain.beams.values()}
    return node == 0 or node % 2 == 1 or node in bending


def node_wrenches(chain: Chain, shape: DeformedChain, inputs: Inputs, forces: Floats | None = None) -> Floats:
    """Return the load of every node: load and outboard weight, in node axes about the node's shifted origin.

    Parameters
    ----------
    shape : the chain as it stands.
    inputs : angles, wrench as read and set-up.
    forces : (6, n) wrench to use in place of the one in ``inputs``; without weight.

    Returns
    -------
    (2J + 2, 6, n) N, N·m.
    """
    setup = inputs.setup
    reading = inputs.wrench if forces is None else forces
    axes = _reading_axes(shape, setup, reading.shape[1])
    point = shape.bodies[setup.wrench_point.body].point(setup.wrench_point.transform[:3, 3])
    force = from_frame(axes.rotation, reading[:3])
    moment = from_frame(axes.rotation, reading[3:]) if setup.moments_measured else np.zeros_like(force)
    moment = moment + cross(point, force)
    n_joints = chain.n_joints
    result = np.zeros((2 * n_joints + 2, 6, reading.shape[1]))
    total_force, total_moment = np.zeros_like(force), np.zeros_like(force)

    def carry(node: int) -> None:
        if node >= 0 and _is_node(chain, node):
            frame = shape.nodes[node]
            result[node, :3] = to_frame(frame.rotation, total_force)
            result[node, 3:] = to_frame(frame.rotation, total_moment - cross(shape.origins[node], total_force))

    for body in range(n_joints + 1, -1, -1):
        # The load may act on an inner body; nodes outboard of it do not feel it.
        if body == setup.wrench_point.body:
            total_force, total_moment = total_force + force, total_moment + moment
        if 0 < body <= n_joints:
            # A link's own weight pulls inboard of its outboard end, which does not carry it: as a force and a moment
            # at that end it would bend a link whose weight sits near its inboard joint upwards.
            carry(2 * body)
        if forces is None:
            mass, centre = _mass_of(chain, setup, body)
            if mass != 0.0:
                place = shape.bodies[body].point(centre)
                weight = np.broadcast_to((mass * chain.gravity)[:, None], place.shape)
                total_force, total_moment = total_force + weight, total_moment + cross(place, weight)
        carry(2 * n_joints + 1 if body == n_joints + 1 else 2 * body - 1 if body > 0 else 0)
    return result


@dataclass(frozen=True)
class OutboardLoads:
    """What the nodes carry, by what it does when the chain outboard of a node turns."""

    force: Floats
    """(3, n) of the reading, base axes, N."""
    moment: Floats
    """(3, n) of the reading, base axes, about its point, N·m."""
    point: Floats
    """(3, n) where it acts, base axes, m."""
    last_loaded: int
    """The outermost node that carries it."""
    last_moving: int
    """The outermost node whose displacement moves its point."""
    last_turning: int
    """The outermost node whose displacement turns its axes; -1 where they are those of the base."""
    gravity: Floats
    """(3,) m/s², base axes."""
    mass: Floats
    """(2J + 2,) kg, whose weight each node carries."""
    first_moment: list[Floats]
    """(3, n) kg·m per node, of that mass about the node's shifted origin, base axes."""


def outboard_loads(chain: Chain, shape: DeformedChain, inputs: Inputs) -> OutboardLoads:
    """Return what the nodes carry in one shape, by what it does when the chain turns.

    Parameters
    ----------
    shape : the chain as it stands.
    inputs : angles, wrench as read and set-up.
    """
    setup, n = inputs.setup, inputs.angles.shape[1]
    axes = _reading_axes(shape, setup, n)
    force = from_frame(axes.rotation, inputs.wrench[:3])
    moment = from_frame(axes.rotation, inputs.wrench[3:]) if setup.moments_measured else np.zeros_like(force)
    point = shape.bodies[setup.wrench_point.body].point(setup.wrench_point.transform[:3, 3])
    mass, first = np.zeros(len(shape.nodes)), [np.zeros((3, n)) for _ in shape.nodes]
    total, weighted = 0.0, np.zeros((3, n))
    for body in range(chain.n_joints + 1, -1, -1):
        inboard = 2 * chain.n_joints + 1 if body == chain.n_joints + 1 else max(2 * body - 1, 0)
        own, centre = _mass_of(chain, setup, body)
        for node in (2 * body, inboard) if 0 < body <= chain.n_joints else (inboard,):
            if node == inboard and own != 0.0:
                total, weighted = total + own, weighted + own * shape.bodies[body].point(centre)
            mass[node], first[node] = total, weighted - total * shape.origins[node]
    return OutboardLoads(
        force,
        moment,
        point,
        2 * chain.n_joints + 1 if setup.wrench_point.body == chain.n_joints + 1 else 2 * setup.wrench_point.body,
        _last_node(chain, setup.wrench_point.body),
        -1 if setup.wrench_axes.body == 0 else _last_node(chain, setup.wrench_axes.body),
        chain.gravity,
        mass,
        first,
    )


def _last_node(chain: Chain, body: int) -> int:
    """Return the outermost node inboard of a body."""
    return 2 * chain.n_joints + 1 if body == chain.n_joints + 1 else max(2 * body - 1, 0)


def _mass_of(chain: Chain, setup: MeasurementSetup, body: int) -> tuple[float, Floats]:
    """Return a body's mass, kg, and its centre in the body's frame, m."""
    if body == 0:
        return 0.0, np.zeros(3)
    if body == chain.n_joints + 1:
        return setup.tool_mass, setup.tool_com
    return float(chain.link_mass[body - 1]), chain.link_com[body - 1]

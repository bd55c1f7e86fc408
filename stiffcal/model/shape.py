"""The chain in one shape, and what its nodes carry there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import StackedFrame, base_frame, cross, from_frame, to_frame
from stiffcal.model.effect import RZ, Inputs

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Shape:
    """A chain in one shape: n states, state axis last.

    Attributes
    ----------
    bodies : J + 2 frames, base to flange, on the deformed chain.
    nodes : 2J + 2 frames of the nodes before their own displacement.
    small : (2J + 2, 6, n) the nodes' displacements, node axes; None for the rigid chain.
    """

    bodies: list[StackedFrame]
    nodes: list[StackedFrame]
    small: Floats | None = None

    def origin(self, node: int) -> Floats:
        """Return where a node turns about, (3, n) in base axes: its origin after its own shift.

        A node that shifts and turns gives the more work to its moment the farther it has shifted: moments that belong
        to the turn are those about the shifted origin.
        """
        frame = self.nodes[node]
        if self.small is None or not self.small[node, :3].any():
            return frame.position
        return np.asarray(frame.position + from_frame(frame.rotation, self.small[node, :3]))


def chain_shape(chain: Chain, angles: Floats, small: Floats | None) -> Shape:
    """Place every body and node of the chain whose nodes are displaced by ``small``.

    Parameters
    ----------
    angles : (J, n) model angles, rad.
    small : (2J + 2, 6, n) node displacements in node axes, or None for the rigid chain.
    """
    n = angles.shape[1]
    beams = {beam.joint: beam.end for beam in chain.beams.values()}
    frame = base_frame(n)
    nodes = [frame]
    if small is not None and small[0].any():
        frame = frame.displaced(small[0])
    bodies = [frame]
    for k in range(1, chain.n_joints + 1):
        frame = frame.moved(chain.fixed[k - 1]).turned_about_z(angles[k - 1])
        bearing = float(chain.bearing[k - 1])
        node = _shifted_along_z(frame, bearing)
        nodes.append(node)
        if small is not None:
            frame = _shifted_along_z(_node_moved(node, small[2 * k - 1]), -bearing)
        bodies.append(frame)
        if k in beams:
            end = frame.moved(beams[k])
            nodes.append(end)
            if small is not None and small[2 * k].any():
                frame = end.displaced(small[2 * k]).moved(_inverse(beams[k]))
        else:
            nodes.append(frame)
    flange = frame.moved(chain.flange)
    nodes.append(flange)
    if small is not None and small[-1].any():
        flange = flange.displaced(small[-1])
    bodies.append(flange)
    return Shape(bodies, nodes, small)


def _shifted_along_z(frame: StackedFrame, distance: float) -> StackedFrame:
    return frame if distance == 0.0 else StackedFrame(frame.rotation, frame.position + distance * frame.rotation[:, 2])


def _node_moved(frame: StackedFrame, small: Floats) -> StackedFrame:
    # A plain drive only turns about z: much cheaper than the general displacement, and exact.
    if small[:RZ].any():
        return frame.displaced(small)
    return frame.turned_about_z(small[RZ])


def _inverse(rigid: Floats) -> Floats:
    result = np.eye(4)
    result[:3, :3] = rigid[:3, :3].T
    result[:3, 3] = -rigid[:3, :3].T @ rigid[:3, 3]
    return result


def node_wrenches(chain: Chain, shape: Shape, inputs: Inputs, forces: Floats | None = None) -> Floats:
    """Return what every node carries: load and outboard weight, in node axes about the node's shifted origin.

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
    # Base axes are those of the ground, whatever the foundation does.
    ground = setup.wrench_axes.body == 0
    axes = (base_frame(reading.shape[1]) if ground else shape.bodies[setup.wrench_axes.body]).moved(
        setup.wrench_axes.transform
    )
    point = shape.bodies[setup.wrench_point.body].point(setup.wrench_point.transform[:3, 3])
    force = from_frame(axes.rotation, reading[:3])
    moment = from_frame(axes.rotation, reading[3:]) if setup.moments_measured else np.zeros_like(force)
    moment = moment + cross(point, force)
    n_joints = chain.n_joints
    result = np.zeros((2 * n_joints + 2, 6, reading.shape[1]))
    bending = {2 * beam.joint for beam in chain.beams.values()}
    total_force, total_moment = np.zeros_like(force), np.zeros_like(force)
    for body in range(n_joints + 1, -1, -1):
        # The load may act on an inner body; nodes outboard of it do not feel it.
        if body == setup.wrench_point.body:
            total_force, total_moment = total_force + force, total_moment + moment
        if forces is None:
            mass, centre = _mass_of(chain, setup, body)
            if mass != 0.0:
                place = shape.bodies[body].point(centre)
                weight = np.broadcast_to((mass * chain.gravity)[:, None], place.shape)
                total_force, total_moment = total_force + weight, total_moment + cross(place, weight)
        # What a body carries goes through the node at its outboard end and through its joint's; links without a beam
        # are no node, and nobody asks what they carry.
        for node in (2 * n_joints + 1,) if body == n_joints + 1 else (2 * body, 2 * body - 1):
            if node < 0 or (node > 0 and node % 2 == 0 and node not in bending):
                continue
            frame = shape.nodes[node]
            result[node, :3] = to_frame(frame.rotation, total_force)
            result[node, 3:] = to_frame(frame.rotation, total_moment - cross(shape.origin(node), total_force))
    return result


def _mass_of(chain: Chain, setup: MeasurementSetup, body: int) -> tuple[float, Floats]:
    """Return a body's mass, kg, and its centre in the body's frame, m."""
    if body == 0:
        return 0.0, np.zeros(3)
    if body == chain.n_joints + 1:
        return setup.tool_mass, setup.tool_com
    return float(chain.link_mass[body - 1]), chain.link_com[body - 1]

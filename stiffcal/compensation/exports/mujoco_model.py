"""A robot with its springs as a model of MuJoCo (MJCF): a body for every node that gives.

A drive is a position servo whose gain is its stiffness: at rest the servo lets the joint go by torque over stiffness,
as the drive does. A drive that turns several joints (a parallelogram) is a servo on a tendon over them, whose length is
the logged angle but for a constant.

Every other compliance of a node is a slide or a hinge with a spring. Of a symmetric block [Ctt Ctr; Crt Crr] of a
node's compliance the principal axes of Crr are hinges; each goes through the point about which its own rotation turns
the node, and what is left of Ctt is slides along its own principal axes: a cantilever beam is a hinge at half its
length and a slide. What has no such form is left out by name.

Rotor inertia and damping in proportion to each spring let it come to rest within a second, and change nothing there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from xml.etree import ElementTree

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.linear_nodes import (
    STATED_SPRING,
    NodeChain,
    acts_next_to_drive,
    linear_nodes,
    matrix_of,
    node_chain,
)
from stiffcal.escapes import code_comment, xml_text
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.stated_spring import stated_spring
from stiffcal.model.effect import RZ, Instrument, joint_node
from stiffcal.quaternions import quaternion_from_rotation

RIGID = 1e11
"""N·m/rad, the gain of a joint whose drive has no compliance."""
RATE = 100.0
"""rad/s, of every spring with its rotor inertia; the damping is critical."""
MASSLESS = 1e-9
"""kg, kg·m²: MuJoCo refuses moving bodies without inertia."""
GYRATION_M2 = 0.01
"""Rotational inertia over mass, which plays no part at rest and is not known."""
MOST_FREEDOMS = 6
_NOTHING = 1e-9
_NEXT_TO_DRIVE = "an additional torque on the joint"


@dataclass(frozen=True)
class NodeSpring:
    """One spring of a node."""

    hinge: bool
    """A hinge; else a slide."""
    axis: Floats
    """(3,) node axes."""
    point: Floats
    """(3,) m, on a hinge's axis."""
    compliance: float
    """rad/(N·m), or m/N."""


@dataclass(frozen=True)
class EffectSprings:
    """What an effect is made of."""

    drives: Floats
    """(J,) rad/(N·m), compliance of the drive on each logged axis."""
    nodes: dict[int, list[NodeSpring]]
    """Other springs by node."""


@dataclass(frozen=True)
class Servo:
    """A drive."""

    name: str
    """Of the logged angle."""
    over: Floats
    """(J,) its length is the sum of these times the model's joint angles."""
    gain: float
    """N·m/rad."""


@dataclass(frozen=True)
class MujocoModel:
    """A model and what it lacks."""

    text: str
    """The file."""
    without_counterpart: tuple[str, ...]
    """Effects of the robot that it does not hold, with the reason, in words."""


def mujoco_model(robot: CompliantRobot, setup: MeasurementSetup, head: Sequence[str], name: str) -> MujocoModel:
    """Return a robot with values as a model of MuJoCo.

    Parameters
    ----------
    robot : chain and effects, every parameter with a value.
    setup : where load point and targets sit; they become sites.
    head : lines of the comment at the file's head, not yet escaped.
    name : of the model.
    """
    kept, lacking, drives = [], [], np.zeros(robot.chain.n_joints)
    springs: dict[int, list[NodeSpring]] = {}
    for placed in robot.placed:
        if isinstance(placed.effect, Instrument):
            continue  # a change of the readings alone: the robot does not bend by it
        of_nodes = _springs_of(robot, placed)
        if isinstance(of_nodes, str):
            lacking.append(f"{placed.effect.name} {placed.place.label}: {of_nodes}")
            continue
        kept.append(placed)
        drives += of_nodes.drives
        for node, own in of_nodes.nodes.items():
            springs.setdefault(node, []).extend(own)
    if stated_spring(robot) is not None:
        lacking.append(f"{STATED_SPRING} of robot.toml: {_NEXT_TO_DRIVE}")
    held = replace(robot, placed=tuple(kept))
    nodes = linear_nodes(held, setup, (STATED_SPRING,))
    row = node_chain(held.adjusted_chain, nodes)
    root = ElementTree.Element("mujoco", model=xml_text.characters(name))
    ElementTree.SubElement(root, "compiler", angle="radian")
    ElementTree.SubElement(root, "option", gravity=_words(row.gravity), timestep="0.001", integrator="implicitfast")
    world = ElementTree.SubElement(root, "worldbody")
    servos = _servos(held.chain, drives)
    bodies = _bodies(world, row, springs, _armature(servos))
    sites = [("load_point", nodes.setup.wrench_point), ("reading_axes", nodes.setup.wrench_axes)]
    names = nodes.setup.target_names
    sites += [(f"target_{one}", at) for one, at in zip(names, nodes.setup.targets, strict=True)]
    for site, at in sites:
        _site(bodies, row, site, at)
    _write_servos(root, servos)
    ElementTree.indent(root)
    comment = "\n".join(code_comment.escaped(line) for line in [*head, *_about_what_lacks(lacking)])
    text = f'<?xml version="1.0" encoding="utf-8"?>\n<!--\n{comment}\n-->\n'
    return MujocoModel(text + ElementTree.tostring(root, encoding="unicode") + "\n", tuple(lacking))


def _about_what_lacks(lacking: Sequence[str]) -> Iterator[str]:
    for entry in lacking:
        yield f"WITHOUT COUNTERPART HERE, omitted: {entry}"


def _springs_of(robot: CompliantRobot, placed: PlacedEffect) -> EffectSprings | str:
    """Return the springs of an effect, or why it has none."""
    if acts_next_to_drive(robot, placed):
        return _NEXT_TO_DRIVE
    matrix = matrix_of(robot, placed)
    if matrix is None:
        return "not proportional to its load"
    chain, count = robot.chain, len(matrix) // 6
    # what turns joints about their own axes, over the logged axes that the drives sit on
    about = np.array([6 * joint_node(k) + RZ for k in range(1, chain.n_joints + 1)])
    back = np.linalg.inv(chain.coupling)
    of_drives = back @ matrix[np.ix_(about, about)] @ back.T
    drives = np.diag(of_drives).copy()
    if np.abs(of_drives - np.diag(drives)).max() <= _NOTHING * np.abs(of_drives).max() and drives.min() >= 0.0:
        matrix = matrix.copy()
        matrix[np.ix_(about, about)] = 0.0
    else:
        drives = np.zeros(chain.n_joints)
    blocks = matrix.reshape(count, 6, count, 6)
    found: dict[int, list[NodeSpring]] = {}
    for node in range(count):
        if np.delete(blocks[node], node, axis=1).any():
            return "couples nodes with each other"
        if blocks[node, :, node].any():
            own = springs_of_block(blocks[node, :, node])
            if own is None:
                return "couples loads and motions along one axis, or is not symmetric"
            found[node] = own
    return EffectSprings(drives, found)


def springs_of_block(block: Floats) -> list[NodeSpring] | None:
    """Return hinges and slides whose compliances add up to a node's (6, 6) compliance; None where none do."""
    size = np.sqrt(np.outer(np.abs(np.diag(block)), np.abs(np.diag(block)))) + 1e-300
    if np.abs(block - block.T).max() > _NOTHING * np.abs(block).max():
        return None
    turning, crossing = block[3:, 3:], block[:3, 3:]
    sizes, axes = np.linalg.eigh(turning)
    there = sizes > _NOTHING * max(float(sizes.max(initial=0.0)), 1e-300)
    if (sizes < -_NOTHING * np.abs(sizes).max()).any() or np.abs(size).max() <= 0.0:
        return None
    found, left = [], block[:3, :3].copy()
    for compliance, axis in zip(sizes[there], axes.T[there], strict=True):
        way = crossing @ axis / compliance
        if abs(way @ axis) > _NOTHING * max(float(np.linalg.norm(way)), 1e-6):
            return None  # it moves along its own axis as it turns: a screw
        # axis × (0 − point) = way for a point perpendicular to the axis
        found.append(NodeSpring(True, axis, np.cross(axis, way), float(compliance)))
        left -= compliance * np.outer(way, way)
        crossing = crossing - compliance * np.outer(way, axis)
    if np.abs(crossing).max() > _NOTHING * np.abs(block).max():
        return None
    sizes, axes = np.linalg.eigh(0.5 * (left + left.T))
    if sizes.min() < -_NOTHING * max(float(np.abs(block[:3, :3]).max()), 1e-300):
        return None
    there = sizes > _NOTHING * max(float(np.abs(block[:3, :3]).max()), 1e-300)
    slides = [
        NodeSpring(False, axis, np.zeros(3), float(c)) for c, axis in zip(sizes[there], axes.T[there], strict=True)
    ]
    return [*slides, *found]


def _servos(chain: Chain, drives: Floats) -> list[Servo]:
    """Return a servo for each drive, which holds the logged angle that it sits on."""
    servos = []
    for k, (name, row) in enumerate(zip(chain.joint_names, np.linalg.inv(chain.coupling), strict=True)):
        gain = 1.0 / float(drives[k]) if drives[k] > 0.0 else RIGID
        servos.append(Servo(xml_text.characters(name), row, gain))
    return servos


def _armature(servos: Sequence[Servo]) -> Floats:
    """Return (J,) kg·m² about each joint."""
    return np.asarray(sum(servo.gain * servo.over**2 for servo in servos) / RATE**2)


def _write_servos(root: ElementTree.Element, servos: Sequence[Servo]) -> None:
    tendons, actuators = ElementTree.Element("tendon"), ElementTree.SubElement(root, "actuator")
    for servo in servos:
        turned = np.flatnonzero(np.abs(servo.over) > _NOTHING)
        at = {"joint": f"joint{int(turned[0]) + 1}"}
        if len(turned) > 1 or servo.over[turned[0]] != 1.0:
            at = {"tendon": f"drive {servo.name}"}
            tendon = ElementTree.SubElement(tendons, "fixed", name=at["tendon"])
            for joint in turned:
                ElementTree.SubElement(tendon, "joint", joint=f"joint{joint + 1}", coef=_word(float(servo.over[joint])))
        kp, kv = _word(servo.gain), _word(2.0 * servo.gain / RATE)
        ElementTree.SubElement(actuators, "position", {"name": servo.name, **at, "kp": kp, "kv": kv})
    if len(tendons):
        root.insert(list(root).index(actuators), tendons)


def _bodies(
    world: ElementTree.Element, row: NodeChain, springs: dict[int, list[NodeSpring]], armature: Floats
) -> list[ElementTree.Element]:
    """Write the bodies of all nodes; return the ground and, by row of the chain, the element that moves with each."""
    elements, parent = [world], world
    for index, node in enumerate(row.nodes):
        number = int(row.joint[index]) + 1
        parent = ElementTree.SubElement(parent, "body", {"name": f"node{node}", **_place(row.fixed[index])})
        free = MOST_FREEDOMS
        if number:
            ElementTree.SubElement(
                parent, "joint", name=f"joint{number}", type="hinge", axis="0 0 1",
                armature=_word(float(armature[number - 1])),
            )  # fmt: skip
            free -= 1
        for count, spring in enumerate(springs.get(node, ())):
            if free == 0:
                _inertial(parent, 0.0, np.zeros(3))
                parent = ElementTree.SubElement(parent, "body", name=f"node{node}_{count}")
                free = MOST_FREEDOMS
            _joint_of(parent, f"node{node}_spring{count + 1}", spring)
            free -= 1
        mass = float(row.mass[index])
        _inertial(parent, mass, row.mass_moment[index] / mass if mass > 0.0 else np.zeros(3))
        if index + 1 < len(row.nodes) and np.linalg.norm(row.fixed[index + 1][:3, 3]) > 1e-3:
            ends = _words(np.append(np.zeros(3), row.fixed[index + 1][:3, 3]))
            ElementTree.SubElement(
                parent, "geom", type="capsule", fromto=ends, size="0.04", contype="0", conaffinity="0", mass="0"
            )
        elements.append(parent)
    return elements


def _joint_of(body: ElementTree.Element, name: str, spring: NodeSpring) -> None:
    stiffness = 1.0 / spring.compliance
    ElementTree.SubElement(
        body, "joint", name=name, type="hinge" if spring.hinge else "slide", axis=_words(spring.axis),
        pos=_words(spring.point), stiffness=_word(stiffness), armature=_word(stiffness / RATE**2),
        damping=_word(2.0 * stiffness / RATE),
    )  # fmt: skip


def _inertial(body: ElementTree.Element, mass: float, centre: Floats) -> None:
    inertia = " ".join([_word(max(GYRATION_M2 * mass, MASSLESS))] * 3)
    ElementTree.SubElement(body, "inertial", pos=_words(centre), mass=_word(max(mass, MASSLESS)), diaginertia=inertia)


def _site(bodies: Sequence[ElementTree.Element], row: NodeChain, name: str, at: Attachment) -> None:
    index, transform = row.placed(at)
    ElementTree.SubElement(bodies[index + 1], "site", {"name": xml_text.characters(name), **_place(transform)})


def _place(transform: Floats) -> dict[str, str]:
    return {"pos": _words(transform[:3, 3]), "quat": _words(quaternion_from_rotation(transform[:3, :3]))}


def _words(values: Floats) -> str:
    return " ".join(_word(float(value)) for value in values)


def _word(value: float) -> str:
    # Adding zero turns −0 into 0.
    return repr(float(value) + 0.0)

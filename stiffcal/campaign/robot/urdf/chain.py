"""URDF: the joints from base to tip, as numbers; a small reader of its own.

Why own: the run-time must not need a robotics library, and only the kinematic tree and the inertials matter here.
Tested against pinocchio. See the URDF XML specification, elements `joint` and `link`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stiffcal.campaign.robot.robot_file import MOST_JOINTS
from stiffcal.campaign.robot.urdf.elements import UrdfJoint, UrdfLink, UrdfMimic
from stiffcal.campaign.robot.urdf.tree import MOST_NAMED, UrdfTree, read_tree
from stiffcal.campaign.toml.name_checks import check_name
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode

PRISMATIC = "prismatic"
MOVING = ("revolute", "continuous", PRISMATIC)
"""The kinds of joints that a chain can have."""


@dataclass(frozen=True)
class UrdfRobot:
    """The path from base to tip, and what is attached to it."""

    name: str
    """The robot's name."""
    path: tuple[UrdfJoint, ...]
    """Joints from base to tip in order, fixed ones included."""
    links: dict[str, UrdfLink]
    """All links by name."""
    children: dict[str, tuple[UrdfJoint, ...]]
    """Link name to the joints that leave it, whole tree."""
    base: str
    """Name of the base link."""
    tip: str
    """Name of the tip link."""

    @property
    def moving(self) -> tuple[UrdfJoint, ...]:
        """The joints of the path that move: revolute, continuous and prismatic ones."""
        return tuple(joint for joint in self.path if joint.kind in MOVING)


def read_urdf(path: Path, display_name: str, base_link: str | None = None, tip_link: str | None = None) -> UrdfRobot:
    """Read a URDF.

    Parameters
    ----------
    path : where it lies.
    display_name : how to call it in a fault.
    base_link, tip_link : ends of the chain; left out: the root, and the leaf behind the most moving joints.

    Raises
    ------
    InputError
        Not there, not XML, no chain between the links, a chain that is part of a closed loop, or a joint on it of
        another kind.
    """
    tree = read_tree(path, display_name)
    robot = chain_between(tree, base_link, tip_link)
    tree.check_serial(robot.path)
    _check_path(robot, display_name)
    return robot


def possible_tips(tree: UrdfTree) -> list[str]:
    """Return the links that could be the tip: the leaves behind the most moving joints.

    Raises
    ------
    InputError
        Several links could be the base, or each link is followed by another one.
    """
    return _leaves(_end(None, tree.roots, tree, "base_link"), tree)


def chain_between(tree: UrdfTree, base_link: str | None = None, tip_link: str | None = None) -> UrdfRobot:
    """Return the chain between two links as `read_urdf` does; what kind of joints lie on it is not checked.

    Raises
    ------
    InputError
        A link that is not there, no chain between the two, or a closed loop in place of a tip.
    """
    base = _end(base_link, tree.roots, tree, "base_link")
    tip = _end(tip_link, _leaves(base, tree) if tip_link is None else (), tree, "tip_link")
    return UrdfRobot(tree.name, tree.path(base, tip), tree.links, tree.children, base, tip)


def _leaves(base: str, tree: UrdfTree) -> list[str]:
    """Return the leaves behind the most moving joints; raise `InputError` where joints lead round and round."""
    leaves: dict[str, int] = {}
    visited: set[str] = set()
    waiting = [(base, 0)]
    while waiting:
        link, moving = waiting.pop()
        if link in visited:
            continue
        visited.add(link)
        below = tree.children.get(link, ())
        waiting.extend((joint.child, moving + (joint.kind != "fixed")) for joint in below)
        if not below:
            leaves[link] = moving
    if not leaves:
        names = ", ".join(
            [joint.name for link in tree.links if link in visited for joint in tree.children[link]][:MOST_NAMED]
        )
        reason = f"each link is followed by another one: joints such as {names} form a closed loop without a tip"
        mend = "delete the joint that leads back towards the base, or write tip_link in the robot file"
        raise InputError.at(FaultCode.URDF_LOOP, tree.file, "", reason, mend)
    most = max(leaves.values())
    return sorted(name for name, moving in leaves.items() if moving == most)


def _end(wanted: str | None, ends: Sequence[str], tree: UrdfTree, key: str) -> str:
    if wanted is not None:
        if wanted not in tree.links:
            raise InputError.at(
                FaultCode.LINK_UNKNOWN,
                tree.file,
                key,
                f'there is no link "{wanted}"',
                "name one of " + ", ".join(tree.links),
            )
        return wanted
    if len(ends) != 1:
        names = ", ".join(ends) or "none"
        raise InputError.at(
            FaultCode.URDF_INVALID,
            tree.file,
            "",
            f"{len(ends)} links could be the {key}: {names}",
            f"write {key} in the robot file",
        )
    return ends[0]


def _mend_for_chain(robot: UrdfRobot, joint: UrdfJoint) -> str:
    """Return how the chain can do without a joint of another kind."""
    place = robot.path.index(joint)
    if not any(other.kind in MOVING for other in robot.path[:place]):
        return f"begin the chain after it: {toml_text.pair('base_link', joint.child)} in the robot file"
    if not any(other.kind in MOVING for other in robot.path[place:]):
        return f"end the chain before it: {toml_text.pair('tip_link', joint.parent)} in the robot file"
    return 'if it did not move, make its type "fixed" in the URDF, with its position in <origin>'


def _mend_for_mimic(robot: UrdfRobot, joint: UrdfJoint, mimic: UrdfMimic) -> str:
    """Return how the robot file states what a joint follows, or that the chain must do without it."""
    if mimic.joint not in {other.name for other in robot.moving}:
        return 'that joint is not on the chain: if it did not move, make the type of both "fixed" in the URDF'
    pairs = [toml_text.pair("name", joint.name), toml_text.pair("logged", {mimic.joint: mimic.multiplier})]
    pairs += [f"theta_deg = {math.degrees(mimic.offset):.6g}"] if mimic.offset else []
    return f"delete its <mimic> in the URDF, and write in the robot file [[joints]] with {', '.join(pairs)}"


def _check_path(robot: UrdfRobot, display_name: str) -> None:
    check_name(robot.name, display_name, "robot")
    for link in (robot.base, *(joint.child for joint in robot.path)):
        check_name(link, display_name, f"link {link}")
    for joint in robot.path:
        place = f"joint {joint.name}"
        check_name(joint.name, display_name, place)
        if joint.kind not in (*MOVING, "fixed"):
            raise InputError.at(
                FaultCode.URDF_INVALID,
                display_name,
                place,
                f"the stiffness of a {joint.kind} joint cannot be identified",
                _mend_for_chain(robot, joint),
            )
        if joint.kind != "fixed" and joint.mimic is not None:
            raise InputError.at(
                FaultCode.URDF_INVALID,
                display_name,
                place,
                f"a joint of the chain follows another ({joint.mimic.joint})",
                _mend_for_mimic(robot, joint, joint.mimic),
            )
        if joint.kind != "fixed" and not any(joint.axis):
            raise InputError.at(
                FaultCode.URDF_INVALID, display_name, place, "the joint's axis is zero", "correct <axis xyz=…/>"
            )
    if len(robot.moving) > MOST_JOINTS:
        reason = f"{len(robot.moving)} moving joints between {robot.base} and {robot.tip}, more than {MOST_JOINTS}"
        raise InputError.at(
            FaultCode.SIZE_EXCEEDED, display_name, "", reason, "choose other links: base_link, tip_link"
        )
    if not robot.moving:
        raise InputError.at(
            FaultCode.URDF_INVALID,
            display_name,
            "",
            f"no moving joint between {robot.base} and {robot.tip}",
            "choose other links",
        )

"""The links of a URDF and what joins them: a tree, of which the chain from base to tip is a part.

A chain is taken for a serial arm only where nothing else joins two of its links: a platform on three limbs, or the
rod of a parallel linkage, would carry part of the load and hold part of the motion. Loops that hang on one link of the
chain (a gripper's fingers), or lie before the base, join no two links of it: they ride along as a mass.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from stiffcal.campaign.robot.urdf.elements import UrdfJoint, UrdfLink, joint_of, link_of, parse_urdf
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

MOST_NAMED = 8
"""Joints of a loop that a sentence lists."""


@dataclass(frozen=True)
class UrdfTree:
    """All links and joints of a URDF, each name once."""

    file: str
    """How a fault calls the file."""
    name: str
    """The robot's name."""
    joints: tuple[UrdfJoint, ...]
    """All joints, as written."""
    links: dict[str, UrdfLink]
    """All links by name."""
    closures: tuple[tuple[str, str, str], ...]
    """Joints that are written as closing a loop (``<loop_joint>``): name and the two links."""

    @cached_property
    def children(self) -> dict[str, tuple[UrdfJoint, ...]]:
        """Link name to the joints that leave it."""
        leaving: dict[str, list[UrdfJoint]] = {}
        for joint in self.joints:
            leaving.setdefault(joint.parent, []).append(joint)
        return {link: tuple(below) for link, below in leaving.items()}

    @cached_property
    def roots(self) -> tuple[str, ...]:
        """The links that are no joint's child, sorted."""
        return tuple(sorted(set(self.links) - {joint.child for joint in self.joints}))

    def path(self, base: str, tip: str) -> tuple[UrdfJoint, ...]:
        """Return the joints from one link to another.

        Raises
        ------
        InputError : there is no such chain.
        """
        reached: dict[str, UrdfJoint | None] = {base: None}
        waiting = deque([base])
        while waiting and tip not in reached:
            for joint in self.children.get(waiting.popleft(), ()):
                if joint.child not in reached:
                    reached[joint.child] = joint
                    waiting.append(joint.child)
        if tip not in reached:
            reason = f"no chain of joints connects it with {base}"
            raise InputError.at(FaultCode.URDF_INVALID, self.file, f"link {tip}", reason, "choose other links")
        path: list[UrdfJoint] = []
        last = reached[tip]
        while last is not None:
            path.append(last)
            last = reached[last.parent]
        return tuple(reversed(path))

    def check_serial(self, path: Sequence[UrdfJoint]) -> None:
        """Check that nothing but the joints of a path joins two of its links.

        Parameters
        ----------
        path : joints, base to tip.

        Raises
        ------
        InputError : the path is part of a closed loop.
        """
        if not path:
            return
        own = {joint.name for joint in path}
        joined = [(joint.name, joint.parent, joint.child) for joint in self.joints if joint.name not in own]
        # what has no parent stands on the ground, as the base does
        joined += [*self.closures, *(("", path[0].parent, root) for root in self.roots)]
        neighbours: dict[str, list[tuple[str, str]]] = {}
        for name, one, other in joined:
            neighbours.setdefault(one, []).append((name, other))
            neighbours.setdefault(other, []).append((name, one))
        place_of = {path[0].parent: 0} | {joint.child: k + 1 for k, joint in enumerate(path)}
        for start, place in place_of.items():
            around = _joined_beyond(start, neighbours, place_of)
            if around is None:
                continue
            end, others = around
            first, last = sorted((place, place_of[end]))
            names = list(dict.fromkeys([*(joint.name for joint in path[first:last]), *others]))
            more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
            raise InputError.at(
                FaultCode.URDF_LOOP,
                self.file,
                f"link {path[last - 1].child}",
                f"joints {', '.join(names[:MOST_NAMED])}{more} form a closed loop, and stiffnesses are identified of "
                "serial arms only",
                "set base_link and tip_link in the robot file to a chain that is in no loop; for a parallel linkage "
                "that only guides, delete the joint that closes it and state the joint that follows with `logged`",
            )


def _joined_beyond(
    start: str, neighbours: dict[str, list[tuple[str, str]]], ends: dict[str, int]
) -> tuple[str, list[str]] | None:
    """Return another of the ends to which a link is joined, and by which joints; None where it is to none.

    What was walked through is taken out of `neighbours`: it leads to no other end.
    """
    came_by: dict[str, tuple[str, str]] = {}
    waiting = deque([start])
    while waiting:
        link = waiting.popleft()
        for name, other in neighbours.pop(link, ()):
            if other in came_by or other == start:
                continue
            came_by[other] = name, link
            if other in ends:
                names = []
                while other != start:
                    name, previous = came_by[other]
                    names += [name] if name else []
                    other = previous
                return next(end for end in came_by if end in ends), names
            waiting.append(other)
    return None


def read_tree(path: Path, display_name: str) -> UrdfTree:
    """Read all links and joints of a URDF.

    Parameters
    ----------
    path : where it lies. display_name : how to call it in a fault.

    Raises
    ------
    InputError
        Not there, not XML, a name twice, a joint of a link that is not there, or no link that is no joint's child.
    """
    root = parse_urdf(path, display_name)
    joints = tuple(joint_of(element, display_name) for element in root.findall("joint"))
    links = [link_of(element, display_name) for element in root.findall("link")]
    _check_single([link.name for link in links], "link", display_name)
    _check_single([joint.name for joint in joints], "joint", display_name)
    by_name = {link.name: link for link in links}
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in by_name:
                reason = f'the URDF has no link "{end}"'
                mend = f'add <link name="{end}"/>, or correct the name'
                raise InputError.at(FaultCode.LINK_UNKNOWN, display_name, f"joint {joint.name}", reason, mend)
    tree = UrdfTree(display_name, root.get("name", "robot"), joints, by_name, tuple(_closures(root)))
    if by_name and not tree.roots:
        names = ", ".join(joint.name for joint in joints[:MOST_NAMED])
        reason = f"every link is a joint's child: joints such as {names} form a closed loop without a base"
        mend = "delete the joint whose child is the base"
        raise InputError.at(FaultCode.URDF_LOOP, display_name, "", reason, mend)
    return tree


def _check_single(names: Sequence[str], kind: str, display_name: str) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            reason = f'two {kind}s have the name "{name}"'
            raise InputError.at(FaultCode.NAME_DUPLICATE, display_name, f"{kind} {name}", reason, "rename one of them")
        seen.add(name)


def _closures(root: ElementTree.Element) -> Iterator[tuple[str, str, str]]:
    for element in root.findall("loop_joint"):
        ends = [end.get("link", "") for end in (element.find("link1"), element.find("link2")) if end is not None]
        if len(ends) == 2:
            yield element.get("name", "loop_joint"), ends[0], ends[1]

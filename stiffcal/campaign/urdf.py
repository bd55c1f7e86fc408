"""URDF: the joints from base to tip, as numbers; a small reader of its own.

Why own: the run-time must not need a robotics library, and only the kinematic tree and the inertials matter here.
Tested against pinocchio. See the URDF XML specification, elements `joint` and `link`.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from stiffcal.campaign.name_checks import check_name
from stiffcal.campaign.robot_file import MOST_JOINTS
from stiffcal.campaign.sizes import implausible_length, mass_mistake
from stiffcal.campaign.typed import WrongValueError
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import read_regular
from stiffcal.limits import URDF, URDF_NODES

Triple: TypeAlias = tuple[float, float, float]

MOST_NESTED = 100  # elements in elements: a robot has five
MOST_RAD = 200.0 * math.pi  # a hundred turns
_ZERO: Triple = (0.0, 0.0, 0.0)
TURNING = ("revolute", "continuous")
"""The kinds of joints that can be identified."""


@dataclass(frozen=True)
class UrdfJoint:
    """One joint element."""

    name: str
    """The joint's name, as written."""
    kind: str
    """Its type, as written."""
    parent: str
    """Name of the parent link."""
    child: str
    """Name of the child link."""
    xyz: Triple
    """m, from the parent link to the joint."""
    rpy: Triple
    """rad about fixed x, y, z, from the parent link to the joint."""
    axis: Triple
    """In the joint's frame, as written."""
    limits: tuple[float, float] | None
    """rad, None where not given."""
    mimics: bool
    """Follows another joint."""


@dataclass(frozen=True)
class UrdfLink:
    """One link element: mass in kg (None without inertial) and centre of mass in the link's frame, m."""

    name: str
    mass: float | None
    com: Triple


@dataclass(frozen=True)
class UrdfRobot:
    """The path from base to tip, and what hangs on it."""

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
    def turning(self) -> tuple[UrdfJoint, ...]:
        """The revolute and continuous joints of the path."""
        return tuple(joint for joint in self.path if joint.kind in TURNING)


def read_urdf(path: Path, file: str, base_link: str | None = None, tip_link: str | None = None) -> UrdfRobot:
    """Read a URDF.

    Parameters
    ----------
    path : where it lies.
    file : how to call it in a fault.
    base_link, tip_link : ends of the chain; left out: the root, and the leaf behind the most turning joints.

    Raises
    ------
    InputError
        Not there, not XML, no chain between the links, or a joint on it that does not turn.
    """
    robot = chain_of(path, file, base_link, tip_link)
    _check_path(robot, file)
    return robot


def possible_tips(path: Path, file: str) -> list[str]:
    """Return the links that could be the tip: the leaves behind the most moving joints.

    Raises
    ------
    InputError
        As `read_urdf`, what the chain's joints are apart.
    """
    root = _parse(path, file)
    joints = [_joint(element, file) for element in root.findall("joint")]
    links = {link.name for link in (_link(element, file) for element in root.findall("link"))}
    children: dict[str, tuple[UrdfJoint, ...]] = {}
    for joint in joints:
        children[joint.parent] = (*children.get(joint.parent, ()), joint)
    base = _end(None, sorted(links - {joint.child for joint in joints}), {}, file, "base_link")
    return _leaves(base, children)


def chain_of(path: Path, file: str, base_link: str | None = None, tip_link: str | None = None) -> UrdfRobot:
    """Read a URDF as `read_urdf` does; what kind of joints lie on the chain is not checked."""
    root = _parse(path, file)
    joints = [_joint(element, file) for element in root.findall("joint")]
    links = {link.name: link for link in (_link(element, file) for element in root.findall("link"))}
    leaving: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        leaving.setdefault(joint.parent, []).append(joint)
    children = {link: tuple(below) for link, below in leaving.items()}
    above = {joint.child: joint for joint in joints}
    base = _end(base_link, sorted(set(links) - set(above)), links, file, "base_link")
    tip = _end(tip_link, _leaves(base, children), links, file, "tip_link")
    chain: list[UrdfJoint] = []
    link = tip
    while link != base:
        if link not in above or len(chain) > len(joints):
            raise InputError.at(
                FaultCode.URDF_INVALID,
                file,
                f"link {tip}",
                f"no chain of joints leads there from {base}",
                "name other links",
            )
        chain.insert(0, above[link])
        link = above[link].parent
    return UrdfRobot(root.get("name", "robot"), tuple(chain), links, children, base, tip)


class _Builder(ElementTree.TreeBuilder):
    """Builds the tree of a URDF; refuses what is none before it takes the machine's memory."""

    def __init__(self, file: str) -> None:
        super().__init__()
        self._file = file
        self._nodes = self._depth = 0

    def doctype(self, *_: str | None) -> None:
        """Refuse a document type: its entities can be as large as one likes, or name other files."""
        raise InputError.at(
            FaultCode.SYNTAX_INVALID,
            self._file,
            "<!DOCTYPE>",
            "a URDF has no document type",
            "delete it and its entities",
        )

    def start(self, tag: str, attributes: dict[str, str], /) -> ElementTree.Element:
        """Count an element in."""
        self._nodes += 1
        self._depth += 1
        URDF_NODES.check(self._nodes, self._file)
        if self._depth > MOST_NESTED:
            reason = f"more than {MOST_NESTED} elements lie in one another"
            raise InputError.at(FaultCode.SIZE_EXCEEDED, self._file, f"<{tag}>", reason, "write them side by side")
        return super().start(tag, attributes)

    def end(self, tag: str, /) -> ElementTree.Element:
        """Leave an element."""
        self._depth -= 1
        return super().end(tag)


def _parse(path: Path, file: str) -> ElementTree.Element:
    try:
        parser = ElementTree.XMLParser(target=_Builder(file))
        parser.feed(read_regular(path, file, limit=URDF))
        root = parser.close()
    except FileNotFoundError:
        raise InputError.at(
            FaultCode.FILE_MISSING, file, "", "no such file", "correct urdf in the robot file"
        ) from None
    except OSError as error:
        raise InputError.at(
            FaultCode.FILE_UNREADABLE, file, "", f"cannot be read: {error.strerror}", "correct urdf in the robot file"
        ) from None
    except ElementTree.ParseError as error:
        line, column = error.position
        reason = f"this is not XML: {str(error).split(':')[0]}"
        raise InputError.at(
            FaultCode.SYNTAX_INVALID, file, f"line {line}, column {column + 1}", reason, "correct that line"
        ) from None
    except (ValueError, LookupError) as error:  # of an encoding that Python does not know
        raise InputError.at(
            FaultCode.SYNTAX_INVALID, file, "line 1", f"this is not XML: {error}", "save the file as UTF-8"
        ) from None
    if root.tag != "robot":
        raise InputError.at(
            FaultCode.URDF_INVALID,
            file,
            f"<{root.tag}>",
            "this is not a URDF",
            "expand xacro files first; the root is <robot>",
        )
    return root


def _triple(text: str | None, default: Triple, file: str, place: str) -> Triple:
    if text is None:
        return default
    try:
        x, y, z = (float(number) for number in text.split())
    except ValueError:
        raise InputError.at(
            FaultCode.NUMBER_INVALID, file, place, f'"{text}" is not three numbers', "write x y z"
        ) from None
    if not all(math.isfinite(number) for number in (x, y, z)):
        raise InputError.at(
            FaultCode.NUMBER_INVALID, file, place, f'"{text}" is not three finite numbers', "write x y z"
        )
    return x, y, z


def _lengths(text: str | None, file: str, place: str) -> Triple:
    """Return a place in m."""
    lengths = _triple(text, _ZERO, file, place)
    for length in lengths:
        _refuse(implausible_length(length), file, place)
    return lengths


def _angles(text: str | None, file: str, place: str) -> Triple:
    """Return three angles in rad."""
    angles = _triple(text, _ZERO, file, place)
    for angle in angles:
        if abs(angle) > MOST_RAD:
            mend = f"write the angles in rad: if {angle:.6g} is in degrees, {math.radians(angle):.6g}"
            raise InputError.at(
                FaultCode.VALUE_INVALID, file, place, f"rpy: {angle:.6g} rad is more than a hundred turns", mend
            )
    return angles


def _refuse(mistake: WrongValueError | None, file: str, place: str) -> None:
    if mistake is not None:
        raise InputError.at(FaultCode.VALUE_INVALID, file, place, mistake.reason, mistake.mend)


def _number(text: str | None, file: str, place: str) -> float | None:
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        raise InputError.at(
            FaultCode.NUMBER_INVALID, file, place, f'"{text}" is not a number', "write a number"
        ) from None
    if math.isnan(value):
        raise InputError.at(FaultCode.NUMBER_INVALID, file, place, f'"{text}" is not a number', "write a number")
    return value


def _joint(element: ElementTree.Element, file: str) -> UrdfJoint:
    name = element.get("name", "?")
    place = f"joint {name}"
    parent, child, origin = element.find("parent"), element.find("child"), element.find("origin")
    axis, limit = element.find("axis"), element.find("limit")
    if parent is None or child is None:
        raise InputError.at(
            FaultCode.URDF_INVALID,
            file,
            place,
            "parent or child is missing",
            "add <parent link=…/> and <child link=…/>",
        )
    kind = element.get("type", "fixed")
    limits = None
    if kind == "revolute" and limit is not None:
        low, high = (_number(limit.get(key, "0"), file, place) or 0.0 for key in ("lower", "upper"))
        limits = (low, high) if high > low else None
    return UrdfJoint(
        name,
        kind,
        parent.get("link", ""),
        child.get("link", ""),
        _lengths(None if origin is None else origin.get("xyz"), file, f"{place}, origin xyz"),
        _angles(None if origin is None else origin.get("rpy"), file, f"{place}, origin rpy"),
        _triple(None if axis is None else axis.get("xyz"), (1.0, 0.0, 0.0), file, f"{place}, axis"),
        limits,
        element.find("mimic") is not None,
    )


def _link(element: ElementTree.Element, file: str) -> UrdfLink:
    name = element.get("name", "?")
    inertial = element.find("inertial")
    if inertial is None:
        return UrdfLink(name, None, _ZERO)
    mass, origin = inertial.find("mass"), inertial.find("origin")
    place = f"link {name}"
    value = None if mass is None else _number(mass.get("value"), file, f"{place}, mass")
    if value is not None:
        _refuse(mass_mistake(value), file, f"{place}, mass")
    return UrdfLink(
        name, value, _lengths(None if origin is None else origin.get("xyz"), file, f"{place}, inertial xyz")
    )


def _leaves(base: str, children: dict[str, tuple[UrdfJoint, ...]]) -> list[str]:
    """Return the leaves behind the most turning joints."""
    leaves: dict[str, int] = {}
    visited: set[str] = set()
    waiting = [(base, 0)]
    while waiting:
        link, turning = waiting.pop()
        if link in visited:
            continue
        visited.add(link)
        below = children.get(link, ())
        waiting.extend((joint.child, turning + (joint.kind != "fixed")) for joint in below)
        if not below:
            leaves[link] = turning
    most = max(leaves.values(), default=0)
    return sorted(name for name, turning in leaves.items() if turning == most)


def _end(wanted: str | None, ends: list[str], links: dict[str, UrdfLink], file: str, key: str) -> str:
    if wanted is not None:
        if wanted not in links:
            raise InputError.at(
                FaultCode.LINK_UNKNOWN, file, key, f'there is no link "{wanted}"', "name one of " + ", ".join(links)
            )
        return wanted
    if len(ends) != 1:
        names = ", ".join(ends) or "none"
        raise InputError.at(
            FaultCode.URDF_INVALID,
            file,
            "",
            f"{len(ends)} links could be the {key}: {names}",
            f"write {key} in the robot file",
        )
    return ends[0]


def _mend_for_chain(robot: UrdfRobot, joint: UrdfJoint) -> str:
    """Return how the chain can do without a joint that does not turn."""
    place = robot.path.index(joint)
    if not any(other.kind in TURNING for other in robot.path[:place]):
        return f'begin the chain behind it: base_link = "{joint.child}" in the robot file'
    if not any(other.kind in TURNING for other in robot.path[place:]):
        return f'end the chain before it: tip_link = "{joint.parent}" in the robot file'
    return 'where it stood still, make its type "fixed" in the URDF, moved into its place by <origin>'


def _check_path(robot: UrdfRobot, file: str) -> None:
    check_name(robot.name, file, "robot")
    for link in (robot.base, *(joint.child for joint in robot.path)):
        check_name(link, file, f"link {link}")
    for joint in robot.path:
        place = f"joint {joint.name}"
        check_name(joint.name, file, place)
        if joint.kind not in ("revolute", "continuous", "fixed"):
            raise InputError.at(
                FaultCode.URDF_INVALID,
                file,
                place,
                f"the stiffness of a {joint.kind} joint cannot be identified",
                _mend_for_chain(robot, joint),
            )
        if joint.kind != "fixed" and joint.mimics:
            raise InputError.at(
                FaultCode.URDF_INVALID,
                file,
                place,
                "a joint of the chain mimics another",
                "write it as logged in the robot file",
            )
        if joint.kind != "fixed" and not any(joint.axis):
            raise InputError.at(
                FaultCode.URDF_INVALID, file, place, "the joint's axis is zero", "correct <axis xyz=…/>"
            )
    if len(robot.turning) > MOST_JOINTS:
        reason = f"{len(robot.turning)} joints turn between {robot.base} and {robot.tip}, more than {MOST_JOINTS}"
        raise InputError.at(FaultCode.SIZE_EXCEEDED, file, "", reason, "name other links: base_link, tip_link")
    if not robot.turning:
        raise InputError.at(
            FaultCode.URDF_INVALID, file, "", f"no joint turns between {robot.base} and {robot.tip}", "name other links"
        )

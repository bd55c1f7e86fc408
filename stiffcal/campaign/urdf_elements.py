"""The elements of a URDF as numbers: XML that may be hostile, lengths and angles that may be in another unit."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from stiffcal.campaign.sizes import implausible_length, mass_mistake
from stiffcal.campaign.typed import WrongValueError
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import read_regular
from stiffcal.limits import URDF, URDF_NODES

Triple: TypeAlias = tuple[float, float, float]

MOST_NESTED = 100  # elements in elements: a robot has five
MOST_RAD = 200.0 * math.pi  # a hundred turns
MOST_SCALED = 1e4  # a mesh in km, were there one, is scaled by a thousand
_ZERO: Triple = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class UrdfMimic:
    """What a joint follows: its position is multiplier × that of the other joint + offset."""

    joint: str
    """Name of the joint that is followed."""
    multiplier: float
    """Share of its position."""
    offset: float
    """rad, m of a prismatic joint."""


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
    """rad, m of a prismatic joint, None where not given."""
    mimic: UrdfMimic | None
    """What it follows, None where it moves by itself."""


@dataclass(frozen=True)
class UrdfMesh:
    """A mesh that shows a link, its numbers as written: what is only drawn spoils no fit."""

    file: str
    """Its name, as written."""
    scale: str | None
    xyz: str | None
    rpy: str | None

    def placement(self, display_name: str, fault_place: str) -> tuple[Triple, Triple, Triple]:
        """Return its place in the link's frame, m, rad about fixed x, y, z, and its scale along its own axes.

        Raises
        ------
        InputError : a number is none or implausible.
        """
        xyz = _position(self.xyz, display_name, f"{fault_place}, origin xyz")
        rpy = _angles(self.rpy, display_name, f"{fault_place}, origin rpy")
        scale = _triple(self.scale, (1.0, 1.0, 1.0), display_name, f"{fault_place}, scale")
        if max(map(abs, scale)) > MOST_SCALED:
            reason, mend = f"a mesh {max(map(abs, scale)):.3g} times as large", "write 0.001 for a mesh in mm"
            raise InputError.at(FaultCode.VALUE_INVALID, display_name, f"{fault_place}, scale", reason, mend)
        return xyz, rpy, scale


@dataclass(frozen=True)
class UrdfLink:
    """One link element: mass in kg (None without inertial), centre of mass in the link's frame, m, and its meshes."""

    name: str
    mass: float | None
    com: Triple
    visuals: tuple[UrdfMesh, ...] = ()
    """What it looks like."""
    collisions: tuple[UrdfMesh, ...] = ()
    """What it is taken for where collisions are looked for."""


class _Builder(ElementTree.TreeBuilder):
    """Builds the tree of a URDF; refuses what is none before it takes the machine's memory."""

    def __init__(self, display_name: str) -> None:
        super().__init__()
        self._display_name = display_name
        self._nodes = self._depth = 0

    def doctype(self, *_: str | None) -> None:
        """Refuse a document type: its entities can be as large as one likes, or name other files."""
        raise InputError.at(
            FaultCode.SYNTAX_INVALID,
            self._display_name,
            "<!DOCTYPE>",
            "a URDF must not have a document type",
            "delete it and its entities",
        )

    def start(self, tag: str, attributes: dict[str, str], /) -> ElementTree.Element:
        """Count an element in."""
        self._nodes += 1
        self._depth += 1
        URDF_NODES.check(self._nodes, self._display_name)
        if self._depth > MOST_NESTED:
            reason = f"more than {MOST_NESTED} nested elements"
            raise InputError.at(FaultCode.SIZE_EXCEEDED, self._display_name, f"<{tag}>", reason, "reduce the nesting")
        return super().start(tag, attributes)

    def end(self, tag: str, /) -> ElementTree.Element:
        """Leave an element."""
        self._depth -= 1
        return super().end(tag)


def parse_urdf(path: Path, display_name: str) -> ElementTree.Element:
    """Return the root of a URDF.

    Raises
    ------
    InputError
        There is no such file, it is no XML or no URDF, or it is larger than any robot's.
    """
    try:
        parser = ElementTree.XMLParser(target=_Builder(display_name))
        parser.feed(read_regular(path, display_name, limit=URDF))
        root = parser.close()
    except FileNotFoundError:
        raise InputError.at(
            FaultCode.FILE_MISSING, display_name, "", "no such file", "correct urdf in the robot file"
        ) from None
    except OSError as error:
        raise InputError.at(
            FaultCode.FILE_UNREADABLE,
            display_name,
            "",
            f"cannot be read: {error.strerror}",
            "correct urdf in the robot file",
        ) from None
    except ElementTree.ParseError as error:
        line, column = error.position
        reason = f"not valid XML: {str(error).split(':')[0]}"
        raise InputError.at(
            FaultCode.SYNTAX_INVALID, display_name, f"line {line}, column {column + 1}", reason, "correct that line"
        ) from None
    except (ValueError, LookupError) as error:  # of an encoding that Python does not know
        raise InputError.at(
            FaultCode.SYNTAX_INVALID, display_name, "line 1", f"not valid XML: {error}", "save the file as UTF-8"
        ) from None
    if root.tag != "robot":
        raise InputError.at(
            FaultCode.URDF_INVALID,
            display_name,
            f"<{root.tag}>",
            "not a URDF",
            "expand xacro files first; the root is <robot>",
        )
    return root


def _triple(text: str | None, default: Triple, display_name: str, fault_place: str) -> Triple:
    if text is None:
        return default
    try:
        x, y, z = (float(number) for number in text.split())
    except ValueError:
        raise InputError.at(
            FaultCode.NUMBER_INVALID, display_name, fault_place, f'"{text}" is not three numbers', "write x y z"
        ) from None
    if not all(math.isfinite(number) for number in (x, y, z)):
        raise InputError.at(
            FaultCode.NUMBER_INVALID, display_name, fault_place, f'"{text}" is not three finite numbers', "write x y z"
        )
    return x, y, z


def _position(text: str | None, display_name: str, fault_place: str) -> Triple:
    """Return a position, m; zero where the text is missing, InputError where a length is implausible."""
    position = _triple(text, _ZERO, display_name, fault_place)
    for length in position:
        _refuse(implausible_length(length), display_name, fault_place)
    return position


def _angles(text: str | None, display_name: str, fault_place: str) -> Triple:
    """Return three angles, rad; zero where the text is missing, InputError beyond a hundred turns."""
    angles = _triple(text, _ZERO, display_name, fault_place)
    for angle in angles:
        if abs(angle) > MOST_RAD:
            mend = f"write the angles in rad: if {angle:.6g} is in degrees, {math.radians(angle):.6g}"
            raise InputError.at(
                FaultCode.VALUE_INVALID,
                display_name,
                fault_place,
                f"rpy: {angle:.6g} rad is more than a hundred turns",
                mend,
            )
    return angles


def _refuse(mistake: WrongValueError | None, display_name: str, fault_place: str) -> None:
    if mistake is not None:
        raise InputError.at(FaultCode.VALUE_INVALID, display_name, fault_place, mistake.reason, mistake.mend)


def _number(text: str | None, display_name: str, fault_place: str) -> float | None:
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        raise InputError.at(
            FaultCode.NUMBER_INVALID, display_name, fault_place, f'"{text}" is not a number', "write a number"
        ) from None
    if math.isnan(value):
        raise InputError.at(
            FaultCode.NUMBER_INVALID, display_name, fault_place, f'"{text}" is not a number', "write a number"
        )
    return value


def joint_of(element: ElementTree.Element, display_name: str) -> UrdfJoint:
    """Return a joint element; InputError where it lacks a link or a number is none."""
    name = element.get("name", "?")
    fault_place = f"joint {name}"
    parent, child, origin = element.find("parent"), element.find("child"), element.find("origin")
    axis, limit = element.find("axis"), element.find("limit")
    if parent is None or child is None:
        raise InputError.at(
            FaultCode.URDF_INVALID,
            display_name,
            fault_place,
            "parent or child is missing",
            "add <parent link=…/> and <child link=…/>",
        )
    kind = element.get("type", "fixed")
    limits = None
    if kind in ("revolute", "prismatic") and limit is not None:
        low, high = (_number(limit.get(key, "0"), display_name, fault_place) or 0.0 for key in ("lower", "upper"))
        limits = (low, high) if high > low else None
    return UrdfJoint(
        name,
        kind,
        parent.get("link", ""),
        child.get("link", ""),
        _position(None if origin is None else origin.get("xyz"), display_name, f"{fault_place}, origin xyz"),
        _angles(None if origin is None else origin.get("rpy"), display_name, f"{fault_place}, origin rpy"),
        _triple(None if axis is None else axis.get("xyz"), (1.0, 0.0, 0.0), display_name, f"{fault_place}, axis"),
        limits,
        _mimic_of(element.find("mimic"), display_name, fault_place),
    )


def _mimic_of(element: ElementTree.Element | None, display_name: str, fault_place: str) -> UrdfMimic | None:
    if element is None:
        return None
    multiplier, offset = (
        _number(element.get(key, default), display_name, f"{fault_place}, mimic {key}") or 0.0
        for key, default in (("multiplier", "1"), ("offset", "0"))
    )
    return UrdfMimic(element.get("joint", ""), multiplier, offset)


def link_of(element: ElementTree.Element, display_name: str) -> UrdfLink:
    """Return a link element; InputError where a number is none or implausible."""
    name = element.get("name", "?")
    inertial, meshes = element.find("inertial"), (_meshes_of(element, "visual"), _meshes_of(element, "collision"))
    if inertial is None:
        return UrdfLink(name, None, _ZERO, *meshes)
    mass, origin = inertial.find("mass"), inertial.find("origin")
    fault_place = f"link {name}"
    value = None if mass is None else _number(mass.get("value"), display_name, f"{fault_place}, mass")
    if value is not None:
        _refuse(mass_mistake(value), display_name, f"{fault_place}, mass")
    return UrdfLink(
        name,
        value,
        _position(None if origin is None else origin.get("xyz"), display_name, f"{fault_place}, inertial xyz"),
        *meshes,
    )


def _meshes_of(link: ElementTree.Element, kind: str) -> tuple[UrdfMesh, ...]:
    """Return the meshes of a link's elements of a kind; boxes, cylinders and spheres are none."""
    found = []
    for element in link.findall(kind):
        mesh, origin = element.find("geometry/mesh"), element.find("origin")
        if mesh is not None and mesh.get("filename"):
            place = (None, None) if origin is None else (origin.get("xyz"), origin.get("rpy"))
            found.append(UrdfMesh(mesh.get("filename", ""), mesh.get("scale"), *place))
    return tuple(found)

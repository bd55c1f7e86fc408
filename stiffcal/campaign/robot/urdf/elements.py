"""The elements of a URDF as numbers: XML that may be hostile, lengths and angles that may be in another unit."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

from stiffcal.campaign.robot.sizes import mass_mistake
from stiffcal.campaign.robot.urdf.numbers import ZERO, Triple, angles_of, number_of, position_of, refuse, triple_of
from stiffcal.campaign.robot.urdf.shapes import UrdfShape, shapes_of
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import read_regular
from stiffcal.limits import URDF, URDF_NODES
from stiffcal.xml_trees import tree_of


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
class UrdfLink:
    """One link element: mass in kg (None without inertial), centre of mass in the link's frame, m, and its shapes."""

    name: str
    mass: float | None
    com: Triple
    visuals: tuple[UrdfShape, ...] = ()
    """What it looks like."""
    collisions: tuple[UrdfShape, ...] = ()
    """What it is taken for where collisions are looked for."""


def parse_urdf(path: Path, display_name: str) -> ElementTree.Element:
    """Return the root of a URDF.

    Raises
    ------
    InputError
        There is no such file, it is no XML or no URDF, or it is larger than any robot's.
    """
    try:
        content = read_regular(path, display_name, limit=URDF)
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
    root = tree_of(content, display_name, "a URDF", URDF_NODES)
    if root.tag != "robot":
        raise InputError.at(
            FaultCode.URDF_INVALID,
            display_name,
            f"<{root.tag}>",
            "not a URDF",
            "expand xacro files first; the root is <robot>",
        )
    return root


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
        low, high = (number_of(limit.get(key, "0"), display_name, fault_place) or 0.0 for key in ("lower", "upper"))
        limits = (low, high) if high > low else None
    return UrdfJoint(
        name,
        kind,
        parent.get("link", ""),
        child.get("link", ""),
        position_of(None if origin is None else origin.get("xyz"), display_name, f"{fault_place}, origin xyz"),
        angles_of(None if origin is None else origin.get("rpy"), display_name, f"{fault_place}, origin rpy"),
        triple_of(None if axis is None else axis.get("xyz"), (1.0, 0.0, 0.0), display_name, f"{fault_place}, axis"),
        limits,
        _mimic_of(element.find("mimic"), display_name, fault_place),
    )


def _mimic_of(element: ElementTree.Element | None, display_name: str, fault_place: str) -> UrdfMimic | None:
    if element is None:
        return None
    multiplier, offset = (
        number_of(element.get(key, default), display_name, f"{fault_place}, mimic {key}") or 0.0
        for key, default in (("multiplier", "1"), ("offset", "0"))
    )
    return UrdfMimic(element.get("joint", ""), multiplier, offset)


def link_of(element: ElementTree.Element, display_name: str) -> UrdfLink:
    """Return a link element; InputError where a number is none or implausible."""
    name = element.get("name", "?")
    inertial, shapes = element.find("inertial"), (shapes_of(element, "visual"), shapes_of(element, "collision"))
    if inertial is None:
        return UrdfLink(name, None, ZERO, *shapes)
    mass, origin = inertial.find("mass"), inertial.find("origin")
    fault_place = f"link {name}"
    value = None if mass is None else number_of(mass.get("value"), display_name, f"{fault_place}, mass")
    if value is not None:
        refuse(mass_mistake(value), display_name, f"{fault_place}, mass")
    return UrdfLink(
        name,
        value,
        position_of(None if origin is None else origin.get("xyz"), display_name, f"{fault_place}, inertial xyz"),
        *shapes,
    )

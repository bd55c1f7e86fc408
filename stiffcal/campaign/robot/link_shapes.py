"""The shapes by which a URDF shows the robot's links: solids, and meshes as far as they lie in the campaign folder."""

from __future__ import annotations

import os
import posixpath
from pathlib import Path, PurePosixPath

import numpy as np

from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.campaign.robot.transforms import translation
from stiffcal.campaign.robot.urdf.chain import read_urdf
from stiffcal.campaign.robot.urdf.elements import UrdfLink
from stiffcal.campaign.robot.urdf.riders import riding_links
from stiffcal.campaign.robot.urdf.shapes import UrdfShape
from stiffcal.campaign.toml.name_checks import check_name
from stiffcal.campaign.toml.reach import escapes, leads_outside, link_fault
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import ENTRIES
from stiffcal.mechanics.rotations import rotation_from_rpy
from stiffcal.meshes.client import READABLE, PlacedShape

OF_PACKAGES = ("package", "model")
"""Schemes of addresses whose first part is the name of a folder somewhere: of ROS, and of Gazebo."""


def link_shapes(robot: RobotFile, folder: Path, robot_file: str) -> list[PlacedShape]:
    """Return the shapes of the robot's links that can be drawn, base to tip; none without a URDF.

    What stands on the base next to the chain (a fence, another arm) is left out; what joints carry (a cover, fingers)
    is drawn at its zero.

    Parameters
    ----------
    folder : the campaign folder. robot_file : the path of robot.toml from there.

    Raises
    ------
    InputError : a mesh lies outside the folder, is of a format that is not read, or has a place that is none.
    """
    if robot.urdf is None:
        return []
    file = posixpath.normpath((PurePosixPath(robot_file.replace("\\", "/")).parent / robot.urdf).as_posix())
    urdf = read_urdf(folder / file, file, robot.base_link, robot.tip_link)
    of_chain = {urdf.base, *(joint.child for joint in urdf.path)}
    found: list[PlacedShape] = []
    for body, joint in enumerate((None, *urdf.moving)):
        for link, place in riding_links(urdf, joint):
            if body == 0 and link.name not in of_chain:
                continue
            for shape, source in _drawn(link, folder, file):
                xyz, rpy, scale = shape.placement(file, f"link {link.name}")
                own = translation(xyz)
                own[:3, :3] = rotation_from_rpy(np.asarray(rpy)) * scale
                found.append(PlacedShape(body, source, place @ own))
                ENTRIES.check(len(found), file, "meshes")
    return found


def _drawn(link: UrdfLink, folder: Path, urdf: str) -> list[tuple[UrdfShape, str]]:
    """Return the shapes of a link that can be drawn, with what they are drawn from.

    Those for collisions stand in where what the link looks like is not there whole: where a mesh is not in the folder,
    or of a format that is not read.
    """
    strange = ""
    parts: list[tuple[UrdfShape, str]] = []
    for shapes in (link.visuals, link.collisions):
        sources = [(shape, _path_of(shape, folder, urdf, link.name) if shape.file else shape.kind) for shape in shapes]
        found = [(shape, source) for shape, source in sources if source is not None]
        unread = [source for shape, source in found if shape.file and _ending(source) not in READABLE]
        if found and not unread:
            if len(found) == len(sources):
                return found
            parts = parts or found
        strange = strange or "".join(unread[:1])
    if strange and not parts:
        reason = f"meshes are read in the formats {', '.join(sorted(READABLE))}"
        mend = "convert it, and name the new file in the URDF"
        raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, strange, "", reason, mend)
    return parts


def _ending(path: str) -> str:
    return PurePosixPath(path).suffix.lower()


def _path_of(mesh: UrdfShape, folder: Path, urdf: str, link: str) -> str | None:
    """Return where a mesh lies, as a path from the campaign folder; None where it is not in there.

    Raises
    ------
    InputError : its name leads out of the folder, by itself or by a link, or holds characters that are refused.
    """
    check_name(mesh.file, urdf, f"link {link}, mesh")
    for path in map(posixpath.normpath, _possible_paths(mesh.file.replace("\\", "/"), urdf)):
        if escapes(path):
            reason = f'"{mesh.file}" lies outside the campaign folder'
            mend = "copy it into the folder, and write its path from the URDF"
            raise InputError.at(FaultCode.FILE_OUTSIDE, urdf, f"link {link}, mesh", reason, mend)
        goal = leads_outside(folder, path)
        if goal is not None:
            raise InputError(link_fault(urdf, f"link {link}, mesh", path, goal))
        if os.path.lexists(folder / path):
            return path
    return None


def _possible_paths(name: str, urdf: str) -> list[str]:
    """Return where a mesh may lie: next to the URDF, or in the folder of its package, which may be any around it."""
    scheme, colon, rest = name.partition("://")
    around = PurePosixPath(urdf).parent
    if not colon:
        return [(around / name).as_posix()]
    if scheme not in OF_PACKAGES:
        return [f"/{rest}"]
    in_package = rest.partition("/")[2]
    places = [around, *around.parents]
    return [(place / path).as_posix() for place in places for path in (rest, in_package) if path]

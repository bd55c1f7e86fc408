"""A campaign whose robot has meshes: those of a six-axis arm, made of round bodies by code."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffcal.campaign.loading import load_campaign
from stiffcal.mechanics.chain import Chain
from tests.laboratory.robots import SIX_AXES, modified_dh

SIDES, RINGS = 48, 16
RADII = (0.17, 0.15, 0.12, 0.11, 0.08, 0.06, 0.05)
"""Of base and links, m: a medium arm."""
MM = 1e3
ROBOT = """schema = "stiffcal/robot/1"
name = "medium six-axis"
urdf = "arm.urdf"

[flange]
xyz_m = [0.0, 0.0, 0.14]
"""


def tube(
    start: Iterable[float], end: Iterable[float], radii: tuple[float, float], sides: int = SIDES
) -> NDArray[np.float64]:
    """Return the triangles (T, 3, 3) of a round body between two points, its ends closed, outward normals."""
    first, last = np.array(start, dtype=float), np.array(end, dtype=float)
    along = (last - first) / np.linalg.norm(last - first)
    side = np.cross(along, [1.0, 0.0, 0.0] if abs(along[0]) < 0.9 else [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    circle = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * np.cross(along, side)
    share = np.linspace(0.0, 1.0, RINGS + 1)[:, None, None]
    rings = first + share * (last - first) + (radii[0] + share * (radii[1] - radii[0])) * circle
    rings = np.concatenate([np.broadcast_to(first, (1, sides, 3)), rings, np.broadcast_to(last, (1, sides, 3))])
    a, b = rings[:-1], rings[1:]
    next_a, next_b = (np.roll(ring, -1, axis=1) for ring in (a, b))
    corners = [(a, next_a, b), (next_a, next_b, b)]
    triangles = np.concatenate([np.stack(three, axis=2).reshape(-1, 3, 3) for three in corners])
    area = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    return np.asarray(triangles[area > 0.0])


def bodies_of(chain: Chain) -> list[NDArray[np.float64]]:
    """Return the triangles of base and links, each in its own frame, m."""
    ends = [step[:3, 3] for step in chain.fixed] + [chain.flange[:3, 3]]
    bodies = []
    for k, end in enumerate(ends):
        parts = [tube([0.0, 0.0, -0.9 * RADII[k]], [0.0, 0.0, 0.9 * RADII[k]], (RADII[k], RADII[k]))] if k else []
        if k == 0:
            parts.append(tube([0.0, 0.0, 0.0], [0.0, 0.0, 0.05], (0.3, 0.3)))
        if np.linalg.norm(end) > 1e-6:
            parts.append(tube(np.zeros(3), end, (0.8 * RADII[k], 0.8 * RADII[min(k + 1, 6)])))
        bodies.append(np.concatenate(parts))
    return bodies


def binary_stl(triangles: NDArray[np.float64]) -> bytes:
    """Return a binary STL."""
    records = np.zeros(len(triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records["corners"] = triangles
    return b"solid made by code".ljust(80) + len(triangles).to_bytes(4, "little") + records.tobytes()


def text_stl(triangles: NDArray[np.float64]) -> bytes:
    """Return an STL of text."""
    corner = "\n".join(["vertex {:.9g} {:.9g} {:.9g}"] * 3)
    facet = f"facet normal 0 0 0\nouter loop\n{corner}\nendloop\nendfacet\n"
    return ("solid a b\n" + "".join(facet.format(*one.ravel()) for one in triangles) + "endsolid a b\n").encode()


def obj_text(triangles: NDArray[np.float64]) -> bytes:
    """Return an OBJ; every second triangle counts its corners backwards, as files may."""
    lines = ["# made by code"]
    for k, one in enumerate(triangles):
        lines += ["v {:.9g} {:.9g} {:.9g}".format(*corner) for corner in one]
        lines.append("f -3 -2/1 -1//2" if k % 2 else f"f {3 * k + 1}/1/1 {3 * k + 2} {3 * k + 3}")
    return ("\n".join(lines) + "\n").encode()


def dae_text(triangles: NDArray[np.float64], unit: float = 1.0, node: str = "", up: str = "Z_UP") -> bytes:
    """Return a COLLADA of one geometry, its faces with normals next to the points.

    Parameters
    ----------
    triangles : (T, 3, 3) in `unit`, m. node : elements of its node before the geometry.
    """
    numbers = " ".join(f"{number:.9g}" for number in triangles.ravel())
    corners = " ".join(f"{k} 0" for k in range(3 * len(triangles)))
    params = "".join(f'<param name="{name}" type="float"/>' for name in "XYZ")
    accessor = '<accessor source="#{0}-array" count="{1}" stride="3">' + params + "</accessor>"

    def source(name: str, text: str, count: int) -> str:
        array = f'<float_array id="{name}-array" count="{3 * count}">{text}</float_array>'
        technique = f"<technique_common>{accessor.format(name, count)}</technique_common>"
        return f'<source id="{name}">{array}{technique}</source>'

    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="of its own" meter="{unit}"/><up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="part"><mesh>
{source("at", numbers, 3 * len(triangles))}{source("normal", "0 0 1", 1)}
<vertices id="corners"><input semantic="POSITION" source="#at"/></vertices>
<triangles count="{len(triangles)}"><input semantic="VERTEX" source="#corners" offset="0"/>
<input semantic="NORMAL" source="#normal" offset="1"/><p>{corners}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node id="whole">{node}<instance_geometry url="#part"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
""".encode()


def urdf_text(package: str) -> str:
    """Return the robot of `robot_text` as a URDF whose links have meshes in mm, `package`/part0.STL and so on."""
    links, joints = [], []
    for k in range(len(SIX_AXES) + 1):
        mesh = f'<mesh filename="{package}/part{k}.STL" scale="0.001 0.001 0.001"/>'
        visual = f'<visual><origin xyz="0 0 0" rpy="0 0 0"/><geometry>{mesh}</geometry></visual>'
        inertial = ""
        if k:
            mass, com = SIX_AXES[k - 1][4:]
            place = " ".join(f"{number:.17g}" for number in com)
            inertial = f'<inertial><origin xyz="{place}"/><mass value="{mass}"/></inertial>'
        links.append(f'<link name="{f"link_A{k}" if k else "base"}">{inertial}{visual}</link>')
    for k, (a, alpha, d, theta, _, _) in enumerate(SIX_AXES, start=1):
        xyz = " ".join(f"{number:.17g}" for number in modified_dh(a, np.radians(alpha), d)[:3, 3])
        ends = f'<parent link="{f"link_A{k - 1}" if k > 1 else "base"}"/><child link="link_A{k}"/>'
        origin = f'<origin xyz="{xyz}" rpy="{np.radians(alpha):.17g} 0 {np.radians(theta):.17g}"/>'
        joints.append(f'<joint name="A{k}" type="continuous">{origin}{ends}<axis xyz="0 0 1"/></joint>')
    return '<robot name="medium six-axis">\n' + "\n".join([*links, *joints]) + "\n</robot>\n"


def give_meshes(folder: Path, package: str = "package://arm_description/meshes") -> Path:
    """Let a campaign of `write_small_campaign` have its robot from a URDF with meshes, binary STL, in the folder.

    Parameters
    ----------
    folder : the campaign. package : what the names of the meshes begin with in the URDF.
    """
    chain = load_campaign(folder, check_files=False).chain
    (folder / "arm.urdf").write_text(urdf_text(package), encoding="utf-8")
    (folder / "robot.toml").write_text(ROBOT, encoding="utf-8")
    meshes = folder / "arm_description" / "meshes"
    meshes.mkdir(parents=True)
    for k, triangles in enumerate(bodies_of(chain)):
        (meshes / f"part{k}.STL").write_bytes(binary_stl(MM * triangles))
    return folder

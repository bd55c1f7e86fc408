"""What a URDF shows of a link: meshes, boxes, cylinders and spheres."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

from stiffcal.campaign.robot.sizes import implausible_length
from stiffcal.campaign.robot.urdf.numbers import Triple, angles_of, number_of, position_of, refuse, triple_of
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.wording import significant

MOST_SCALED = 1e4  # a mesh in km, were there one, is scaled by a thousand
SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}
"""Attributes of the solids that a URDF describes by their sizes, m."""


@dataclass(frozen=True)
class UrdfShape:
    """A mesh or a solid, its numbers as written: what is only drawn spoils no fit."""

    kind: str
    """"mesh", or a solid of `SIZES`."""
    file: str
    """Of a mesh, as written; "" of a solid."""
    attributes: dict[str, str]
    xyz: str | None
    rpy: str | None

    def placement(self, display_name: str, fault_place: str) -> tuple[Triple, Triple, Triple]:
        """Return its place in the link's frame, m, rad about fixed x, y, z, and its scale along its own axes.

        A mesh is scaled from what its file holds, a box from a cube of 1 m, a cylinder from one along z of radius and
        length 1 m, a sphere from one of radius 1 m; solids are about their middle.

        Raises
        ------
        InputError : a number is none or implausible.
        """
        fault_place = f"{fault_place}, {self.kind}"
        xyz = position_of(self.xyz, display_name, f"{fault_place}, origin xyz")
        rpy = angles_of(self.rpy, display_name, f"{fault_place}, origin rpy")
        return xyz, rpy, (self._scale if self.kind == "mesh" else self._sizes)(display_name, fault_place)

    def _scale(self, display_name: str, fault_place: str) -> Triple:
        fault_place = f"{fault_place}, scale"
        scale = triple_of(self.attributes.get("scale"), (1.0, 1.0, 1.0), display_name, fault_place)
        largest = max(map(abs, scale))
        if largest > MOST_SCALED:
            reason, mend = f"a mesh {significant(largest)} times as large", "write 0.001 for a mesh in mm"
            raise InputError.at(FaultCode.VALUE_INVALID, display_name, fault_place, reason, mend)
        return scale

    def _sizes(self, display_name: str, fault_place: str) -> Triple:
        places = {name: f"{fault_place}, {name}" for name in SIZES[self.kind]}
        if self.kind == "box":
            sizes = triple_of(self.attributes.get("size", ""), (0.0, 0.0, 0.0), display_name, places["size"])
        else:
            read = {name: number_of(self.attributes.get(name, ""), display_name, places[name]) for name in places}
            radius, length = read["radius"] or 0.0, read.get("length") or 0.0
            sizes = (radius, radius, length if self.kind == "cylinder" else radius)
        for size in sizes:
            refuse(implausible_length(size), display_name, fault_place)
            if size < 0.0:
                reason, mend = f"a size of {size:.6g} m", "write a positive length in m"
                raise InputError.at(FaultCode.VALUE_INVALID, display_name, fault_place, reason, mend)
        return sizes


def shapes_of(link: ElementTree.Element, kind: str) -> tuple[UrdfShape, ...]:
    """Return the shapes of a link's elements of a kind, "visual" or "collision"; what no URDF knows is left out."""
    found = []
    for element in link.findall(kind):
        origin = element.find("origin")
        place = (None, None) if origin is None else (origin.get("xyz"), origin.get("rpy"))
        for shape in element.findall("geometry/*"):
            file = shape.get("filename", "") if shape.tag == "mesh" else ""
            if file or shape.tag in SIZES:
                found.append(UrdfShape(shape.tag, file, dict(shape.attrib), *place))
    return tuple(found)

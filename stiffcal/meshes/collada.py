"""COLLADA: the geometries of a scene, each where its nodes put it, in m.

The axis that a file calls up is of no concern: what shows a URDF (RViz, MoveIt, Gazebo) takes coordinates as they are,
and robots are made to look right there. Jaco of Kinova has links with Y up next to links with Z up, all in one frame.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.meshes.collada_geometry import Document
from stiffcal.meshes.surface import MEND, Surface, checked, damaged, together
from stiffcal.xml_trees import tree_of

MOST_NODES = 10_000
"""Of a scene: what is named twice, within what is named twice, grows without end."""
NOT_READ = frozenset(("instance_controller", "skew", "lookat"))
"""Elements that place a part in a way that no robot needs; without them parts would be missing, or elsewhere."""


def surface_of(content: bytes, display_name: str) -> Surface:
    """Return the surface of a file, m by the unit that it states; lines are left out.

    Raises
    ------
    InputError : it is damaged or empty, a coordinate is no finite number, or it refers to other files.
    """
    root = tree_of(content, display_name, "a mesh")
    for element in root.iter():  # each version has a space of names of its own
        element.tag = element.tag.rpartition("}")[2]
    if root.tag != "COLLADA":
        raise damaged(display_name, f"the root is <{root.tag[:50]}>, not <COLLADA>")
    scene = _Scene(Document(display_name, {element.get("id", ""): element for element in root.iter()}), display_name)
    with np.errstate(all="ignore"):  # what is not finite is seen in what comes out
        whole = together([geometry.placed(place) for geometry, place in scene.placed(root)])
    return checked(whole.points, whole.triangles, display_name)


class _Scene:
    """The geometries that a file shows, each read once."""

    def __init__(self, document: Document, display_name: str) -> None:
        self._document, self._display_name = document, display_name
        self._read: dict[Element, Surface] = {}

    def placed(self, root: Element) -> Iterator[tuple[Surface, Floats]]:
        """Yield geometries with their places, (4, 4), m."""
        unit, shown = root.find("asset/unit"), root.find("scene/instance_visual_scene")
        metre = 1.0 if unit is None else self._document.numbers(unit.get("meter", "1"), "<unit>", 1)[0]
        scenes = root.findall("library_visual_scenes/visual_scene") if shown is None else [self._document.target(shown)]
        waiting = [(scene, np.diag([metre, metre, metre, 1.0])) for scene in scenes]
        count = 0
        while waiting:
            node, place = waiting.pop()
            count += 1
            if count > MOST_NODES:
                reason = f"more than {MOST_NODES} nodes, counted each time that they are named"
                raise InputError.at(FaultCode.SIZE_EXCEEDED, self._display_name, "", reason, MEND)
            place = place @ self._transform(node)
            for child in node:
                if child.tag == "instance_geometry":
                    yield self._geometry(self._document.target(child)), place
                elif child.tag in ("node", "instance_node"):
                    inner = child if child.tag == "node" else self._document.target(child)
                    waiting.append((inner, place))

    def _geometry(self, element: Element) -> Surface:
        if element not in self._read:
            self._read[element] = self._document.surface(element)
        return self._read[element]

    def _transform(self, node: Element) -> Floats:
        """Return the (4, 4) transform from a node to what it is in."""
        whole = np.eye(4)
        for element in node:
            place = f"<{element.tag[:50]}>"
            if element.tag == "matrix":
                whole = whole @ self._document.numbers(element.text, place, 16).reshape(4, 4)
            elif element.tag == "translate":
                whole[:3, 3] += whole[:3, :3] @ self._document.numbers(element.text, place, 3)
            elif element.tag == "scale":
                whole[:3, :3] = whole[:3, :3] * self._document.numbers(element.text, place, 3)
            elif element.tag == "rotate":
                whole[:3, :3] = whole[:3, :3] @ _turn(self._document.numbers(element.text, place, 4))
            elif element.tag in NOT_READ:
                raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, self._display_name, place, "is not read", MEND)
        return whole


def _turn(numbers: Floats) -> Floats:
    """Return the (3, 3) turn of an axis and an angle, degrees; none about an axis without length."""
    length = float(np.linalg.norm(numbers[:3]))
    return rotation_from_vector(numbers[:3] * (np.radians(numbers[3]) / length if length > 0.0 else 0.0))

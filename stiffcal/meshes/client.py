"""Asking the child process for the surfaces of a robot's bodies."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.bounded_work.client import Work
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import MESHES
from stiffcal.meshes import answering
from stiffcal.meshes.solids import SOLIDS
from stiffcal.meshes.surface import MEND, Surface

READABLE = frozenset(answering.FORMATS)
"""Endings of files that are read, in small letters."""
LONGEST_M = 100.0
"""From the origin of its body to the farthest point of a mesh; ten times the reach of the largest robots."""


@dataclass(frozen=True)
class PlacedShape:
    """A mesh or a solid that shows a part of the robot."""

    body: int
    """0 the base, k what joint k moves."""
    source: str
    """A mesh's path from the campaign folder, checked, that it leads to no other place; or the name of a solid."""
    place: Floats
    """(4, 4) from coordinates of the source, scaled, to the frame of the body, m."""


def read_bodies(folder: Path, shapes: Sequence[PlacedShape], most: int, display_name: str) -> dict[int, Surface]:
    """Return a surface for each body that has shapes, in the body's frame, m.

    Parameters
    ----------
    folder : the campaign folder. shapes : one at least. most : triangles of all bodies together.
    display_name : of the file that names the shapes, for faults of all of them.

    Raises
    ------
    InputError : a mesh is missing, damaged, too large, or in another unit than the robot.
    """
    size = 0
    for file in {shape.source for shape in shapes} - SOLIDS.keys():
        with suppress(OSError):
            size += (folder / file).stat().st_size
    MESHES.check(size, display_name, "meshes")
    values = {
        "root": str(folder),
        "most": most,
        "shapes": [{"body": shape.body, "source": shape.source, "place": shape.place.tolist()} for shape in shapes],
    }
    ((head, rest),) = Work(answering.__name__, values, size, display_name, MEND, "meshes").answers()
    for shape, reach in zip(shapes, head["reaches"], strict=True):
        if reach > LONGEST_M:
            raise _too_long(shape.source, reach, display_name)
    bodies, at = {}, 0
    for body, n_points, n_triangles in head["bodies"]:
        points = np.frombuffer(rest, "<f8", 3 * n_points, at).reshape(-1, 3)
        at += points.nbytes
        triangles = np.frombuffer(rest, "<i8", 3 * n_triangles, at).reshape(-1, 3)
        at += triangles.nbytes
        bodies[int(body)] = Surface(points, triangles)
    return {body: surface for body, surface in bodies.items() if len(surface.triangles)}


def _too_long(source: str, reach: float, urdf: str) -> InputError:
    is_solid = source in SOLIDS
    reason = f"the {source if is_solid else 'mesh'} reaches {reach:.6g} m from the origin of its link"
    mend = (
        "write its size and its place in m"
        if is_solid
        else 'if it is in mm, write scale="0.001 0.001 0.001" in its <mesh> of the URDF'
    )
    return InputError.at(FaultCode.UNIT_IMPLAUSIBLE, urdf if is_solid else source, "", reason, mend)

"""A surface of triangles, and what every reader of one checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

LARGEST = 1e9
"""Of a coordinate, in whatever unit: beyond it products of four lengths are no numbers any more."""
MEND = "export the mesh again, as binary STL"


@dataclass(frozen=True)
class Surface:
    """Triangles in space."""

    points: Floats
    """(V, 3) in the unit of its file, or m once it is placed."""
    triangles: Integers
    """(T, 3) indices of points."""

    def placed(self, place: Floats) -> Surface:
        """Return it in another frame; `place`: (4, 4), scale included."""
        return Surface(self.points @ place[:3, :3].T + place[:3, 3], self.triangles)


def together(surfaces: Sequence[Surface]) -> Surface:
    """Return surfaces as one, in the frame that they share."""
    points, triangles = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)]
    start = 0
    for one in surfaces:
        points.append(one.points)
        triangles.append(one.triangles + start)
        start += len(one.points)
    return Surface(np.concatenate(points), np.concatenate(triangles))


def checked(points: Floats, triangles: Integers, display_name: str) -> Surface:
    """Return a surface.

    Raises
    ------
    InputError : there are no triangles, a triangle has a corner that is not there, or a number is not finite or beyond
        `LARGEST`.
    """
    if not len(triangles):
        raise InputError.at(FaultCode.FILE_EMPTY, display_name, "", "a mesh without triangles", MEND)
    if int(triangles.min()) < 0 or int(triangles.max()) >= len(points):
        raise damaged(display_name, f"a triangle has a corner that is none of its {len(points)} points")
    if not (np.abs(points) <= LARGEST).all():
        reason = f"a coordinate is not a number up to {LARGEST:.0e}"
        raise InputError.at(FaultCode.NUMBER_INVALID, display_name, "", reason, MEND)
    return Surface(points, triangles)


def damaged(display_name: str, reason: str, place: str = "") -> InputError:
    """Return the error of a mesh that contradicts its format."""
    return InputError.at(FaultCode.FILE_DAMAGED, display_name, place, reason, MEND)

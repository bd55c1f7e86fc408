"""The solids that a URDF describes by their sizes, of size 1 about their middle."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.meshes.surface import Surface

SIDES, RINGS = 48, 24
"""Of what is round: no edge is seen in a picture."""


def box() -> Surface:
    """Return a cube of edges of 1."""
    points = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [three for a, b, c, d in faces for three in ((a, b, c), (a, c, d))]
    return Surface(points, np.array(triangles, dtype=np.int64))


def cylinder() -> Surface:
    """Return a cylinder of radius 1 about z, and of length 1."""
    return _turned(np.array([[0.0, -0.5], [1.0, -0.5], [1.0, 0.5], [0.0, 0.5]]))


def sphere() -> Surface:
    """Return a sphere of radius 1."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, RINGS + 1)
    outline = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    outline[[0, -1], 0] = 0.0
    return _turned(outline)


def _turned(outline: Floats) -> Surface:
    """Return what an outline, (R, 2) radii and heights upwards, both ends on the axis, describes about z."""
    angle = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    round_ = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = [np.column_stack([radius * round_, np.full(SIDES, height)]) for radius, height in outline[1:-1]]
    points = np.concatenate([*rings, [[0.0, 0.0, outline[0, 1]], [0.0, 0.0, outline[-1, 1]]]])
    a = np.arange(SIDES)
    b = np.roll(a, -1)
    last, low, high = SIDES * (len(rings) - 1), len(points) - 2, len(points) - 1
    triangles = [np.column_stack([b, a, np.full(SIDES, low)])]
    for start in range(0, last, SIDES):
        triangles += [np.column_stack([start + a, start + b, start + SIDES + b])]
        triangles += [np.column_stack([start + a, start + SIDES + b, start + SIDES + a])]
    triangles.append(np.column_stack([last + a, last + b, np.full(SIDES, high)]))
    return Surface(points, np.concatenate(triangles))


SOLIDS = {"box": box, "cylinder": cylinder, "sphere": sphere}
"""What makes a solid, by its name in a URDF."""

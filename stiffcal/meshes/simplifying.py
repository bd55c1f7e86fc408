"""Fewer triangles for a picture: corners in one cell of a grid become one.

The corner that stands for a cell is the point nearest to the planes of all triangles that meet there, so that edges and
corners of a link stay where they are (Lindstrom, Out-of-core simplification of large polygonal models, SIGGRAPH 2000).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.meshes.surface import Surface

FINEST = 2048
"""Cells along the longest side in the finest grid: half a pixel of a large picture."""
ASIDE = 0.618
"""Cells by which the grid is moved: corners at round numbers, equal but for rounding, lie in one cell then."""
FLAT = 1e-3
"""Share of the largest eigenvalue of a cell's planes below which a direction is not determined by them."""


def simplified(surfaces: Sequence[Surface], most: int) -> list[Surface]:
    """Return surfaces with at most so many triangles together, all on one grid; details below a cell are lost.

    Parameters
    ----------
    surfaces : in one unit, each in a frame of its own. most : triangles, 1 at least.
    """
    longest = max((float(np.ptp(surface.points, axis=0).max()) for surface in surfaces), default=0.0)
    if longest <= 0.0:
        return [Surface(surface.points[:0], surface.triangles[:0]) for surface in surfaces]
    finest = [_clustered(surface, longest / FINEST) for surface in surfaces]
    if sum(len(surface.triangles) for surface in finest) <= most:
        return finest
    few, many = 1, FINEST  # cells along the longest side: enough triangles go with the first, too few with the second
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (middle, many) if _count(finest, longest / middle) <= most else (few, middle)
    return [_clustered(surface, longest / few) for surface in finest]


def _count(surfaces: Sequence[Surface], cell: float) -> int:
    """Return how many triangles keep three corners on a grid."""
    return sum(int(np.count_nonzero(_is_whole(_cells(one.points, cell)[1][one.triangles]))) for one in surfaces)


def _is_whole(corners: Integers) -> np.ndarray:
    a, b, c = corners.T
    return np.asarray((a != b) & (b != c) & (c != a))


def _cells(points: Floats, cell: float) -> tuple[Integers, Integers]:
    """Return the cells of points: (V, 3) numbers along the axes, and (V,) one number each."""
    places = np.floor((points - points.min(axis=0, initial=np.inf)) / cell + ASIDE).astype(np.int64)
    return places, places @ np.array([1, 1 << 20, 1 << 40])


def _clustered(surface: Surface, cell: float) -> Surface:
    """Return a surface with one point in each cell of a grid, without triangles that become lines or equal ones."""
    if not len(surface.triangles):
        return surface
    _, keys = _cells(surface.points, cell)
    _, first, cell_of = np.unique(keys, return_index=True, return_inverse=True)
    corners = cell_of[surface.triangles]
    kept = corners[_is_whole(corners)]
    _, single = np.unique(np.sort(kept, axis=1), axis=0, return_index=True)
    kept = kept[np.sort(single)]
    used, renumbered = np.unique(kept, return_inverse=True)
    points = _corner_points(surface, cell_of, len(first))
    return Surface(points[used], renumbered.reshape(kept.shape))


def _corner_points(surface: Surface, cell_of: Integers, count: int) -> Floats:
    """Return for each cell the point nearest to the planes of its triangles, within a box about the cell's own points.

    Where planes nearly agree they cross far away: without the box a ridge would become spikes.
    """
    size = np.bincount(cell_of, minlength=count)[:, np.newaxis]
    in_order = surface.points[np.argsort(cell_of, kind="stable")]
    starts = np.concatenate([[0], np.cumsum(size[:-1, 0])])
    low, high = np.minimum.reduceat(in_order, starts), np.maximum.reduceat(in_order, starts)
    middle = np.stack([np.bincount(cell_of, column, minlength=count) for column in surface.points.T], axis=1) / size
    at = surface.points[surface.triangles]
    normal = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])  # as long as the triangle is large
    planes, offsets = np.zeros((count, 3, 3)), np.zeros((count, 3))
    for corner in range(3):
        cells = cell_of[surface.triangles[:, corner]]
        height = np.einsum("ti,ti->t", normal, at[:, corner] - middle[cells])
        for i in range(3):
            offsets[:, i] += np.bincount(cells, normal[:, i] * height, minlength=count)
            for j in range(3):
                planes[:, i, j] += np.bincount(cells, normal[:, i] * normal[:, j], minlength=count)
    values, axes = np.linalg.eigh(planes)
    is_known = values > FLAT * values[:, -1:]
    along = np.einsum("cji,cj->ci", axes, offsets)
    step = np.einsum("cij,cj->ci", axes, np.divide(along, values, out=np.zeros_like(along), where=is_known))
    return np.asarray(np.clip(middle + step, low, high), dtype=np.float64)

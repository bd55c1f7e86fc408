"""A mesh of a drawn section: triangles between an outline and its holes.

Conforming Delaunay triangulation: the outlines are cut into pieces until the circle over each piece holds no other
point, for then each is an edge of the Delaunay triangulation of the points (Gabriel's condition; Edelsbrunner and Tan
1993). Why our own: the usual mesher's licence shuts out commercial users.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers
from stiffcal.mechanics.section import turn

# Cutting in half this often without an end means a corner too sharp to mesh.
MAX_CUTS = 40


class SectionError(ValueError):
    """The drawing is no section; the message states why."""


def inner_outline(outline: Floats, wall: float) -> Floats:
    """Return the outline moved inwards by a wall thickness: the hole of a hollow section.

    Parameters
    ----------
    outline : (k, 2) in order around the section, m.
    wall : m.

    Raises
    ------
    SectionError : the walls meet.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> inner_outline(square, 0.1).round(3).tolist()
    [[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]]
    """
    points = np.asarray(outline, dtype=np.float64)
    if signed_area(points) < 0.0:
        points = points[::-1]
    edges = np.roll(points, -1, axis=0) - points
    along = edges / np.linalg.norm(edges, axis=1)[:, None]
    inward = np.column_stack([-along[:, 1], along[:, 0]])
    normal_before = np.roll(inward, 1, axis=0)
    # Each corner moves to where the two moved edges meet.
    bend = 1.0 + np.sum(inward * normal_before, axis=1)
    if np.any(bend < 1e-6):
        raise SectionError("the outline folds back on itself")
    offset_points = points + wall * (inward + normal_before) / bend[:, None]
    along_edges = np.sum((np.roll(offset_points, -1, axis=0) - offset_points) * along, axis=1)
    if (
        np.any(along_edges <= 0.0)
        or signed_area(offset_points) <= 0.0
        or not _all_inside(offset_points, points, 0.99 * wall)
    ):
        raise SectionError(f"a wall of {wall:g} m leaves no hollow inside the outline")
    return np.asarray(offset_points)


def _all_inside(inner: Floats, outer: Floats, distance: float) -> bool:
    """Return whether points lie inside a polygon, at least so far from its edges."""
    return bool(np.all(inside([outer], inner)) and np.all(edge_distance([outer], inner) >= distance))


def signed_area(points: Floats) -> float:
    """Return the area of a polygon, m², positive where it runs counter-clockwise."""
    return float(0.5 * np.sum(turn(points, np.roll(points, -1, axis=0))))


def inside(loops: list[Floats], points: Floats) -> NDArray[np.bool_]:
    """Return True for the points inside an odd number of the loops (outline and holes)."""
    count = np.zeros(len(points), dtype=np.int64)
    for loop in loops:
        for a, b in pairwise(np.vstack([loop, loop[:1]])):
            crosses = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
            if not crosses.any():
                continue
            at = a[0] + (points[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            count += crosses & (points[:, 0] < at)
    return np.asarray(count % 2 == 1)


def edge_distance(loops: list[Floats], points: Floats) -> Floats:
    """Return the distance of points from the nearest edge of the loops, m."""
    nearest = np.full(len(points), np.inf)
    for loop in loops:
        for a, b in pairwise(np.vstack([loop, loop[:1]])):
            along = b - a
            share = np.clip((points - a) @ along / (along @ along), 0.0, 1.0)
            nearest = np.minimum(nearest, np.linalg.norm(a + share[:, None] * along - points, axis=1))
    return nearest


def section_mesh(loops: list[Floats], size: float) -> tuple[Floats, Integers]:
    """Return nodes (p, 2) and triangles (t, 3) between outline and holes.

    Parameters
    ----------
    loops : the outline, then its holes: (k, 2) each, m.
    size : largest edge, m.

    Raises
    ------
    SectionError : loops that cross each other, or corners too sharp.
    """
    from scipy.spatial import Delaunay

    area = abs(signed_area(loops[0])) - sum(abs(signed_area(hole)) for hole in loops[1:])
    for hole in loops[1:]:
        if not np.all(inside([loops[0]], hole)):
            raise SectionError("a hole reaches out of the outline")
    if area <= 1e-12 * abs(signed_area(loops[0])):
        raise SectionError("the holes are larger than the outline")
    points = _cut_edges(loops, size)
    nodes = np.concatenate([points, _points_between(loops, size)])
    triangles = Delaunay(nodes).simplices.astype(np.int64)
    corners = nodes[triangles]
    twice = turn(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    keep = (np.abs(twice) > 1e-9 * size**2) & inside(loops, corners.mean(axis=1))
    triangles, twice = triangles[keep], twice[keep]
    if abs(0.5 * np.sum(np.abs(twice)) - area) > 1e-6 * area:
        raise SectionError("the outline crosses itself or a hole")
    triangles[twice < 0.0] = triangles[twice < 0.0][:, ::-1]
    used, numbers = np.unique(triangles, return_inverse=True)
    return nodes[used], numbers.reshape(triangles.shape).astype(np.int64)


def _cut_edges(loops: list[Floats], size: float) -> Floats:
    """Cut all edges until none is longer than ``size`` and no point lies in the circle over a piece."""
    from scipy.spatial import cKDTree

    pieces: list[tuple[Floats, Floats]] = []
    for loop in loops:
        for a, b in pairwise(np.vstack([loop, loop[:1]])):
            count = max(1, int(np.ceil(np.linalg.norm(b - a) / size)))
            marks = a + np.linspace(0.0, 1.0, count + 1)[:, None] * (b - a)
            pieces.extend(pairwise(marks))
    start, end = np.array([p[0] for p in pieces]), np.array([p[1] for p in pieces])
    for _ in range(MAX_CUTS):
        points = np.unique(np.round(np.concatenate([start, end]), 12), axis=0)
        middle, radius = (start + end) / 2.0, np.linalg.norm(end - start, axis=1) / 2.0
        tree = cKDTree(points)
        neighbours = tree.query_ball_point(middle, radius * (1.0 - 1e-6), return_length=True)
        crowded = np.asarray(neighbours) > 0
        if not crowded.any():
            return points
        start, end = (
            np.concatenate([start[~crowded], start[crowded], middle[crowded]]),
            np.concatenate([end[~crowded], middle[crowded], end[crowded]]),
        )
    raise SectionError("a corner of the outline is too sharp, or it touches itself")


def _points_between(loops: list[Floats], size: float) -> Floats:
    """Return points of a triangular lattice well inside, far enough from the edges not to crowd their pieces."""
    low, high = loops[0].min(axis=0), loops[0].max(axis=0)
    rows = np.arange(low[1], high[1], size * np.sqrt(0.75))
    columns = np.arange(low[0], high[0] + size, size)
    lattice = np.array([[x + (size / 2.0 if i % 2 else 0.0), y] for i, y in enumerate(rows) for x in columns])
    lattice = lattice.reshape(-1, 2)
    lattice = lattice[inside(loops, lattice)]
    return lattice[edge_distance(loops, lattice) > 0.6 * size]

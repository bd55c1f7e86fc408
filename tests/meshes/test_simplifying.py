"""Fewer triangles, and still the same body."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffcal.meshes.simplifying import simplified
from stiffcal.meshes.surface import Surface
from tests.laboratory.mesh_robot import tube

RADIUS, LONG = 0.2, 1.0
SIDES = 240
"""Of the tube: its triangles are far smaller than any cell here."""


def surface_of(triangles: NDArray[np.float64]) -> Surface:
    return Surface(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def fine_box(parts: int = 24) -> NDArray[np.float64]:
    """Return the triangles of a cube from 0 to 1, each side cut into squares."""
    ticks = np.linspace(0.0, 1.0, parts + 1)
    u, v = np.meshgrid(ticks[:-1], ticks[:-1], indexing="ij")
    step = ticks[1]
    a, b, c, d = (np.stack([u + i * step, v + j * step], axis=-1) for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)))
    flat = np.concatenate([np.stack(three, axis=-2).reshape(-1, 3, 2) for three in ((a, b, c), (b, d, c))])
    sides = [np.insert(flat, axis, level, axis=2) for axis in range(3) for level in (0.0, 1.0)]
    return np.concatenate(sides)


@pytest.mark.parametrize("most", [300, 1000, 4000])
def test_a_tube_stays_a_tube_and_has_no_more_triangles_than_allowed(most: int) -> None:
    whole = surface_of(tube([0.0, 0.0, 0.0], [0.0, 0.0, LONG], (RADIUS, RADIUS), SIDES))
    assert len(whole.triangles) > 4000
    (less,) = simplified([whole], most)
    assert 0.3 * most < len(less.triangles) <= most
    # its surface has the size of a cylinder's, 2πr(r + l): triangles of the mean area span an angle of 2·sqrt(area)/r
    at = less.points[less.triangles]
    area = 0.5 * np.linalg.norm(np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]), axis=1).sum()
    exact = 2.0 * np.pi * RADIUS * (RADIUS + LONG)
    angle = 2.0 * np.sqrt(exact / len(less.triangles)) / RADIUS
    assert area == pytest.approx(exact, rel=angle**2 / 6.0)
    assert np.abs(less.points[:, 2] - 0.5).max() == pytest.approx(0.5, abs=0.01)


def test_edges_and_corners_of_a_box_stay_where_they_are() -> None:
    (less,) = simplified([surface_of(fine_box())], 700)
    assert len(less.triangles) <= 700
    for corner in np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T:
        assert np.linalg.norm(less.points - corner, axis=1).min() < 1e-9
    # every point lies on the box, not within it
    assert np.minimum(np.abs(less.points), np.abs(less.points - 1.0)).min(axis=1).max() < 1e-9


def test_few_triangles_stay_as_they_are_but_for_common_corners() -> None:
    box = fine_box(2)
    (less,) = simplified([surface_of(box)], 10_000)
    assert (len(less.triangles), len(less.points)) == (len(box), 26)
    assert (
        np.abs(np.sort(less.points[less.triangles].reshape(-1, 9), axis=0) - np.sort(box.reshape(-1, 9), axis=0)).max()
        < 1e-12
    )


def test_bodies_share_one_grid_and_one_number_of_triangles() -> None:
    large, small = fine_box(), 0.1 * fine_box()
    found = simplified([surface_of(large), surface_of(small)], 900)
    assert sum(len(one.triangles) for one in found) <= 900
    assert len(found[1].triangles) < 0.1 * len(found[0].triangles)


@pytest.mark.parametrize("points", [np.zeros((3, 3)), np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]])])
def test_triangles_without_area_leave_no_number_that_is_none(points: NDArray[np.float64]) -> None:
    (less,) = simplified([Surface(points.astype(float), np.array([[0, 1, 2]]))], 100)
    assert np.isfinite(less.points).all()


def test_ribs_become_no_spikes() -> None:
    ribbed = tube([0.0, 0.0, 0.0], [0.0, 0.0, LONG], (RADIUS, RADIUS), SIDES)
    ribbed[..., :2] *= 1.0 + 0.06 * np.sign(np.sin(50.0 * ribbed[..., 2:] + 0.5))
    (less,) = simplified([surface_of(ribbed)], 500)
    assert np.abs(less.points[:, :2]).max() <= np.abs(ribbed[..., :2]).max() + 1e-12

"""Solids of a URDF: closed, of the sizes that they have, and placed as meshes are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.meshes.client import PlacedShape, read_bodies
from stiffcal.meshes.solids import RINGS, SIDES, SOLIDS
from tests.laboratory.mesh_robot import dae_text, tube

ROUND = SIDES / np.pi * np.sin(np.pi / SIDES) * np.cos(np.pi / SIDES)
"""Area of the polygon in a circle, as a share of the circle's."""


@pytest.mark.parametrize(
    ("name", "volume", "half"),
    [
        ("box", 1.0, (0.5, 0.5, 0.5)),
        ("cylinder", np.pi * ROUND, (1.0, 1.0, 0.5)),
        ("sphere", 4.0 / 3.0 * np.pi * ROUND, (1.0, 1.0, 1.0)),
    ],
)
def test_a_solid_is_closed_and_has_its_volume(name: str, volume: float, half: tuple[float, ...]) -> None:
    solid = SOLIDS[name]()
    edges = np.concatenate([solid.triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    there, back = ({tuple(edge) for edge in ends} for ends in (edges, edges[:, ::-1]))
    assert len(there) == len(edges)  # each edge once in each direction: closed, and all normals outwards or all inwards
    assert there == back
    a, b, c = np.moveaxis(solid.points[solid.triangles], 1, 0)
    found = float(np.einsum("ti,ti->", a, np.cross(b, c))) / 6.0
    flat = 0.7 * (np.pi / RINGS) ** 2 if name == "sphere" else 1e-12  # of the chords of the outline
    assert volume * (1.0 - flat) <= found <= volume * (1.0 + 1e-12)
    assert np.abs(np.abs(solid.points).max(axis=0) - half).max() < 1e-12


def test_solids_and_meshes_of_a_body_become_one_surface(tmp_path: Path) -> None:
    (tmp_path / "part.dae").write_bytes(dae_text(tube([0.0, 0.0, 0.0], [0.0, 0.0, 0.4], (0.1, 0.1))))
    box = np.diag([0.2, 0.4, 0.6, 1.0])
    box[:3, 3] = (0.0, 0.0, 0.7)
    shapes = [PlacedShape(1, "part.dae", np.eye(4)), PlacedShape(1, "box", box), PlacedShape(3, "sphere", 0.1 * box)]
    found = read_bodies(tmp_path, shapes, 2000, "arm.urdf")
    assert sorted(found) == [1, 3]
    ends = np.stack([found[1].points.min(axis=0), found[1].points.max(axis=0)])
    assert np.abs(ends - [[-0.1, -0.2, 0.0], [0.1, 0.2, 1.0]]).max() < 0.01

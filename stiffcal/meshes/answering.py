"""In the child process: the files of a robot's meshes become one simplified surface for each body that they show."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import numpy as np

from stiffcal.bounded_work.messages import Document, joined
from stiffcal.files import read_regular
from stiffcal.limits import MESHES
from stiffcal.meshes import obj, stl
from stiffcal.meshes.simplifying import simplified
from stiffcal.meshes.surface import Surface

FORMATS = {".stl": stl.surface_of, ".obj": obj.surface_of}
"""What reads a file, by its ending in small letters."""


def prepare(values: Document) -> None:
    """Import nothing further: the formats are read here, with numpy alone."""


def answers(values: Document) -> Generator[tuple[bytes, int], None, None]:
    """Yield one message with all bodies, and 0: nothing is unpacked."""
    most = values["most"]
    files: dict[str, Surface] = {}
    bodies: dict[int, list[Surface]] = {}
    reaches = []
    for entry in values["meshes"]:
        file = entry["file"]
        if file not in files:
            content = read_regular(Path(values["root"]) / file, file, limit=MESHES)
            (files[file],) = simplified([FORMATS[Path(file).suffix.lower()](content, file)], most)
        placed = files[file].placed(np.array(entry["place"]))
        reaches.append(float(np.abs(placed.points).max(initial=0.0)))
        bodies.setdefault(entry["body"], []).append(placed)
    found = simplified([_together(surfaces) for surfaces in bodies.values()], most)
    head = {
        "kind": "bodies",
        "bodies": [[body, len(one.points), len(one.triangles)] for body, one in zip(bodies, found, strict=True)],
        "reaches": reaches,
    }
    arrays = [array for one in found for array in (one.points.astype("<f8"), one.triangles.astype("<i8"))]
    yield joined(head, arrays), 0


def _together(surfaces: list[Surface]) -> Surface:
    starts = np.cumsum([0, *(len(one.points) for one in surfaces[:-1])])
    return Surface(
        np.concatenate([one.points for one in surfaces]),
        np.concatenate([one.triangles + start for one, start in zip(surfaces, starts, strict=True)]),
    )

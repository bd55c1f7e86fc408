"""In the child process: the shapes of a robot become one simplified surface for each body that they show."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import numpy as np

from stiffcal.bounded_work.messages import Document, joined
from stiffcal.files import read_regular
from stiffcal.limits import MESHES
from stiffcal.meshes import collada, obj, stl
from stiffcal.meshes.simplifying import simplified
from stiffcal.meshes.solids import SOLIDS
from stiffcal.meshes.surface import Surface, together

FORMATS = {".dae": collada.surface_of, ".obj": obj.surface_of, ".stl": stl.surface_of}
"""What reads a file, by its ending in small letters."""


def prepare(values: Document) -> None:
    """Import nothing further: the formats are read here, with numpy alone."""


def answers(values: Document) -> Generator[tuple[bytes, int], None, None]:
    """Yield one message with all bodies, and 0: nothing is unpacked."""
    most = values["most"]
    read: dict[str, Surface] = {}
    bodies: dict[int, list[Surface]] = {}
    reaches = []
    for entry in values["shapes"]:
        source = entry["source"]
        if source not in read:
            read[source] = _surface(Path(values["root"]), source, most)
        placed = read[source].placed(np.array(entry["place"]))
        reaches.append(float(np.abs(placed.points).max(initial=0.0)))
        bodies.setdefault(entry["body"], []).append(placed)
    found = simplified([together(surfaces) for surfaces in bodies.values()], most)
    head = {
        "kind": "bodies",
        "bodies": [[body, len(one.points), len(one.triangles)] for body, one in zip(bodies, found, strict=True)],
        "reaches": reaches,
    }
    arrays = [array for one in found for array in (one.points.astype("<f8"), one.triangles.astype("<i8"))]
    yield joined(head, arrays), 0


def _surface(root: Path, source: str, most: int) -> Surface:
    """Return a solid by its name, or what a file holds, with at most so many triangles."""
    if source in SOLIDS:
        return SOLIDS[source]()
    content = read_regular(root / source, source, limit=MESHES)
    (found,) = simplified([FORMATS[Path(source).suffix.lower()](content, source)], most)
    return found

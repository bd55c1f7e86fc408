"""OBJ of Wavefront: corners (``v``) and faces of three or more of them (``f``); all else is of no concern here."""

from __future__ import annotations

import numpy as np

from stiffcal.meshes.surface import Surface, checked, damaged


def surface_of(content: bytes, display_name: str) -> Surface:
    """Return the surface of a file, its faces cut into triangles from their first corner.

    Raises
    ------
    InputError : it is damaged or empty, or a coordinate is no finite number.
    """
    points: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for number, line in enumerate(content.split(b"\n"), start=1):
        words = line.split()
        try:
            if words[:1] == [b"v"]:
                x, y, z = map(float, words[1:4])
                points.append([x, y, z])
            elif words[:1] == [b"f"]:
                face = [_index(word, len(points)) for word in words[1:]]
                triangles += [(face[0], face[k], face[k + 1]) for k in range(1, len(face) - 1)]
        except ValueError as error:
            raise damaged(display_name, str(error)[:100], f"line {number}") from None
    shape = np.array(points, dtype=np.float64).reshape(-1, 3)
    return checked(shape, np.array(triangles, dtype=np.int64).reshape(-1, 3), display_name)


def _index(word: bytes, n_points: int) -> int:
    """Return a corner's index from 0; files count from 1, or backwards from the last one with −1."""
    number = int(word.split(b"/", 1)[0])
    if abs(number) > n_points:
        raise ValueError(f"a face has corner {number} of {n_points}")
    return number - 1 if number > 0 else n_points + number

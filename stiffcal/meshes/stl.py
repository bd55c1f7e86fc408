"""STL: triangles without common corners, in binary (50 bytes each behind a head of 84) or as text."""

from __future__ import annotations

import re

import numpy as np

from stiffcal.meshes.surface import Surface, checked, damaged

_HEAD, _COUNT_AT = 84, 80
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)


def surface_of(content: bytes, display_name: str) -> Surface:
    """Return the surface of a file.

    Raises
    ------
    InputError : it is damaged, cut off, empty, or a coordinate is no finite number.
    """
    count = int.from_bytes(content[_COUNT_AT:_HEAD], "little")
    if len(content) >= _HEAD and len(content) == _HEAD + _RECORD.itemsize * count:
        # by its length and not by its first word: binary files begin with "solid" too
        records = np.frombuffer(content, _RECORD, count, _HEAD)
        with np.errstate(invalid="ignore"):  # a NaN that signals is refused as others are
            corners = records["corners"].astype(np.float64)
        return _soup(corners.reshape(-1, 3), display_name)
    if content[:5].lower() == b"solid" and b"\0" not in content[:_HEAD]:  # the count of a binary one has a zero byte
        return _text(content, display_name)
    stated = f"it states {count} triangles, and has bytes for {max(len(content) - _HEAD, 0) / _RECORD.itemsize:.6g}"
    raise damaged(display_name, stated)


def _text(content: bytes, display_name: str) -> Surface:
    corners = _VERTEX.findall(content)
    if len(corners) % 3:
        raise damaged(display_name, f"{len(corners)} corners make no whole triangles")
    try:
        points = np.array(corners, dtype=np.bytes_).astype(np.float64).reshape(-1, 3)
    except ValueError as error:
        raise damaged(display_name, f"a coordinate is no number: {str(error)[:100]}") from None
    return _soup(points, display_name)


def _soup(points: np.ndarray, display_name: str) -> Surface:
    return checked(points, np.arange(len(points)).reshape(-1, 3), display_name)

"""The triangles of a geometry of COLLADA: points of a source, and groups of faces that name them by numbers."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.meshes.surface import MEND, Surface, damaged, together

FACES = frozenset(("triangles", "polylist", "polygons", "trifans", "tristrips"))
"""Groups of faces; the others are of lines."""


class Document:
    """A file's elements by their names.

    Parameters
    ----------
    named : elements by their id, the id without its "#".
    """

    def __init__(self, display_name: str, named: Mapping[str, Element]) -> None:
        self._display_name, self._named = display_name, named

    def target(self, element: Element, attribute: str = "url") -> Element:
        """Return the element to which an attribute refers.

        Raises
        ------
        InputError : it refers to another file, or to what is not there.
        """
        address = element.get(attribute, "")
        if not address.startswith("#"):
            reason, code = f'it refers to "{address[:100]}", which is no part of it', FaultCode.CONTENT_UNSUPPORTED
            raise InputError.at(code, self._display_name, f"<{element.tag[:50]}>", reason, MEND)
        found = self._named.get(address[1:])
        if found is None:
            raise damaged(self._display_name, f'nothing in it has the id "{address[1:101]}"', f"<{element.tag[:50]}>")
        return found

    def numbers(self, text: str | None, place: str, count: int | None = None) -> Floats:
        """Return numbers in a text: so many, or as many as there are.

        Raises
        ------
        InputError : one is none, or there are more or fewer.
        """
        words = (text or "").split()
        try:
            found = np.array(words, dtype=np.float64)
        except ValueError as error:
            raise damaged(self._display_name, str(error)[:100], place) from None
        if count is not None and len(found) != count:
            raise damaged(self._display_name, f"{len(found)} numbers instead of {count}", place)
        return found

    def surface(self, geometry: Element) -> Surface:
        """Return the triangles of a geometry, in its own coordinates.

        Raises
        ------
        InputError : it is damaged.
        """
        parts = []
        for mesh in geometry.findall("mesh"):
            for group in mesh:
                if group.tag in FACES:
                    points, triangles = self._points(group), self._triangles(group)
                    if triangles.size and not 0 <= triangles.min() <= triangles.max() < len(points):
                        reason = f"a triangle has a corner that is none of its {len(points)} points"
                        raise damaged(self._display_name, reason, f"<{group.tag}>")
                    parts.append(Surface(points, triangles))
        return together(parts)

    def _points(self, group: Element) -> Floats:
        """Return the points, (V, 3), that a group's faces name."""
        vertices = self.target(self._input(group, "VERTEX"), "source")
        source = self.target(self._input(vertices, "POSITION"), "source")
        values, accessor = source.find("float_array"), source.find("technique_common/accessor")
        if values is None:
            raise damaged(self._display_name, "points without <float_array>", "<source>")
        found = self.numbers(values.text, "<float_array>")
        stride, start = 3, 0
        if accessor is not None:
            stride, start = self._whole(accessor, "stride", 1), self._whole(accessor, "offset", 0)
        if stride < 3 or start < 0 or start > len(found):
            raise damaged(self._display_name, f"points of {stride} numbers, from number {start} on", "<accessor>")
        rows = (len(found) - start) // stride
        return found[start : start + rows * stride].reshape(rows, stride)[:, :3]

    def _triangles(self, group: Element) -> Integers:
        """Return the corners of a group's triangles, (T, 3) numbers of points."""
        inputs = group.findall("input")
        stride = 1 + max(self._whole(one, "offset", 0) for one in inputs)
        offset = self._whole(self._input(group, "VERTEX"), "offset", 0)
        if not 0 <= offset < stride:
            raise damaged(self._display_name, "a negative offset", f"<{group.tag}>")
        runs = [self._integers(element.text, f"<{group.tag}>")[offset::stride] for element in group.iter("p")]
        corners = np.concatenate([np.zeros(0, dtype=np.int64), *runs])
        if group.tag == "triangles":
            return corners[: len(corners) // 3 * 3].reshape(-1, 3)
        if group.tag == "polylist":
            counts = self._integers(group.findtext("vcount"), "<vcount>")
        else:
            counts = np.array([len(run) for run in runs], dtype=np.int64)
        if (counts < 0).any() or counts.sum() > len(corners):
            raise damaged(self._display_name, "more corners are counted than there are", f"<{group.tag}>")
        return _strips(corners, counts) if group.tag == "tristrips" else _fans(corners, counts)

    def _input(self, element: Element, semantic: str) -> Element:
        for one in element.findall("input"):
            if one.get("semantic") == semantic:
                return one
        raise damaged(self._display_name, f"it has no input of {semantic}", f"<{element.tag[:50]}>")

    def _whole(self, element: Element, attribute: str, default: int) -> int:
        return int(self._integers(element.get(attribute, str(default)), f"<{element.tag}>, {attribute}", 1)[0])

    def _integers(self, text: str | None, place: str, count: int | None = None) -> Integers:
        numbers = self.numbers(text, place, count)
        if not (np.abs(numbers) < 1 << 53).all():
            raise damaged(self._display_name, "a number that counts nothing", place)
        return numbers.astype(np.int64)


def _fans(corners: Integers, counts: Integers) -> Integers:
    """Return the triangles of faces of so many corners each, cut from their first corner."""
    each = np.maximum(counts - 2, 0)
    first = np.repeat(np.cumsum(counts) - counts, each)
    step = np.arange(each.sum()) - np.repeat(np.cumsum(each) - each, each)
    return np.stack([corners[first], corners[first + step + 1], corners[first + step + 2]], axis=1)


def _strips(corners: Integers, counts: Integers) -> Integers:
    """Return the triangles of strips: each three corners that follow each other."""
    each = np.maximum(counts - 2, 0)
    at = np.repeat(np.cumsum(counts) - counts, each) + np.arange(each.sum()) - np.repeat(np.cumsum(each) - each, each)
    return np.stack([corners[at], corners[at + 1], corners[at + 2]], axis=1)

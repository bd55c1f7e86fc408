"""The elements of a MAT file of version 5, walked through before a library takes them at their word.

What stands in a damaged file as a size leads scipy's reader out of its memory: the program would end without a word.
Source: MathWorks, MAT-File Format (version 5): a tag of type and size, then the data, padded to eight bytes.
"""

from __future__ import annotations

import math
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffcal.files import open_regular
from stiffcal.limits import check_unpacked

HEADER = 128
MATRIX, COMPRESSED = 14, 15
CELL, STRUCT, OBJECT, CHARACTERS, SPARSE = 1, 2, 3, 4, 5
FUNCTION, OPAQUE = 16, 17
SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 16: 1, 17: 2, 18: 4}
MOST_NESTED = 40
PIECE = 1 << 24
MOST_BYTES = 1 << 31  # MATLAB itself bounds a variable of this version to 2 GB


class DamagedElementError(ValueError):
    """The file's elements do not fit into one another."""


@dataclass(frozen=True)
class _Element:
    kind: int
    data: memoryview
    end: int


def check_elements(path: Path, display_name: str = "") -> None:
    """Walk through a file; raises `DamagedElementError` where sizes, kinds and dimensions contradict each other."""
    with open_regular(path) as file:
        head = file.read(HEADER)
        order = {b"IM": "<", b"MI": ">"}.get(head[126:128])
        if order is None:  # version 4, or none: the library reports this itself
            return
        packed = unpacked = 0
        while tag := file.read(8):
            if len(tag) < 8:
                raise DamagedElementError("the file ends in the middle of a variable")
            kind, size = struct.unpack(order + "II", tag)
            data = file.read(size) if size <= MOST_BYTES else b""
            if kind not in (MATRIX, COMPRESSED) or len(data) < size or size > MOST_BYTES:
                raise DamagedElementError("the file ends in the middle of a variable, or its sizes are damaged")
            if kind == COMPRESSED:
                packed += size
                content = _unpacked(data, unpacked, packed, display_name or str(path))
                unpacked += len(content)
                inner = _element(memoryview(content), 0, order)
                if inner.kind != MATRIX:
                    raise DamagedElementError("a packed variable contains no variable")
                data = bytes(inner.data)
            _check_matrix(memoryview(data), order, 0)


def _unpacked(data: bytes, before: int, packed: int, display_name: str) -> bytes:
    """Return a packed variable's content.

    Parameters
    ----------
    data : as it lies in the file.
    before : bytes that the variables before it have unpacked to.
    packed : bytes that they and this one take in the file.
    display_name : the file as messages name it.
    """
    unpacking = zlib.decompressobj()
    pieces, unpacked, remaining = [], 0, data
    try:
        while remaining and unpacked <= MOST_BYTES:
            pieces.append(unpacking.decompress(remaining, PIECE))
            unpacked += len(pieces[-1])
            check_unpacked(before + unpacked, packed, display_name)
            remaining = unpacking.unconsumed_tail
    except zlib.error as error:
        raise DamagedElementError(f"a packed variable is damaged ({error})") from None
    if remaining or not unpacking.eof:
        raise DamagedElementError("a packed variable is cut off, or larger than 2 GB")
    return b"".join(pieces)


def _element(data: memoryview, at: int, order: str) -> _Element:
    if at + 8 > len(data):
        raise DamagedElementError("a variable ends before its parts")
    first, size = struct.unpack_from(order + "II", data, at)
    if first >> 16:  # up to four bytes within the tag
        kind, size = first & 0xFFFF, first >> 16
        if size > 4:
            raise DamagedElementError("a short part is too long")
        return _Element(kind, data[at + 4 : at + 4 + size], at + 8)
    if at + 8 + size > len(data):
        raise DamagedElementError("a part is larger than its variable")
    return _Element(first, data[at + 8 : at + 8 + size], at + 8 + (size + 7 & ~7))


def _check_matrix(data: memoryview, order: str, depth: int) -> None:
    if depth > MOST_NESTED:
        raise DamagedElementError("variables are nested too deeply")
    if not len(data):  # an empty cell
        return
    flags = _element(data, 0, order)
    if flags.kind != 6 or len(flags.data) != 8:
        raise DamagedElementError("a variable has no type")
    (word,) = struct.unpack_from(order + "I", flags.data)
    kind, is_complex = word & 0xFF, bool(word & 0x800)
    if kind in (FUNCTION, OPAQUE):  # a form of MATLAB's own, refused by name later
        return
    shape = _element(data, flags.end, order)
    dimensions = np.frombuffer(shape.data, order + "i4").tolist() if len(shape.data) % 4 == 0 else []
    if shape.kind != 5 or len(dimensions) < 2 or len(dimensions) > 32 or min(dimensions) < 0:
        raise DamagedElementError("a variable has no size")
    name = _element(data, shape.end, order)
    _numbers(name, (1, 2, 16))
    count, at = math.prod(dimensions), name.end
    if kind in (CELL, STRUCT, OBJECT):
        if kind == OBJECT:
            at = _element(data, at, order).end
        fields = 1
        if kind != CELL:
            fields, at = _fields(data, at, order)
        for _ in range(count * fields):
            element = _element(data, at, order)
            if element.kind != MATRIX:
                raise DamagedElementError("a cell or field is not a variable")
            _check_matrix(element.data, order, depth + 1)
            at = element.end
        return
    if kind == SPARSE:
        _check_sparse(data, at, order, dimensions)
        return
    if kind not in range(CHARACTERS, FUNCTION):
        raise DamagedElementError(f"a variable of unknown type {kind}")
    for _ in range(2 if is_complex else 1):
        element = _element(data, at, order)
        n_numbers = _numbers(element, tuple(SIZES))
        # text in UTF-8 may take several bytes a letter
        if n_numbers != count and not (kind == CHARACTERS and n_numbers >= count):
            raise DamagedElementError(f"{n_numbers} numbers in a variable of {count}")
        at = element.end


def _check_sparse(data: memoryview, at: int, order: str, dimensions: list[int]) -> None:
    rows = _element(data, at, order)
    starts = _element(data, rows.end, order)
    values = _element(data, starts.end, order)
    n_numbers = _numbers(values, tuple(SIZES))
    if rows.kind != 5 or starts.kind != 5 or len(rows.data) % 4 or len(starts.data) != 4 * (dimensions[1] + 1):
        raise DamagedElementError("a sparse matrix has no indices")
    row, start = np.frombuffer(rows.data, order + "i4"), np.frombuffer(starts.data, order + "i4")
    inside = start[0] == 0 and (np.diff(start) >= 0).all() and start[-1] <= min(row.size, n_numbers)
    if not inside or ((row < 0) | (row >= max(dimensions[0], 1))).any():
        raise DamagedElementError("a sparse matrix has indices out of range")


def _numbers(element: _Element, kinds: tuple[int, ...]) -> int:
    if element.kind not in kinds or len(element.data) % SIZES[element.kind]:
        raise DamagedElementError("a part has the wrong type")
    return len(element.data) // SIZES[element.kind]


def _fields(data: memoryview, at: int, order: str) -> tuple[int, int]:
    """Return the number of a struct's fields, and the offset of the first."""
    width = _element(data, at, order)
    names = _element(data, width.end, order)
    if width.kind != 5 or len(width.data) != 4:
        raise DamagedElementError("a struct's names have no length")
    (length,) = struct.unpack(order + "i", width.data)
    if not 0 < length <= 4096 or len(names.data) % length:
        raise DamagedElementError("a struct's names have no length")
    return len(names.data) // length, names.end

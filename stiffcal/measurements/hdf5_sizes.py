"""How much an HDF5 file makes its reader hold, and large chunks read once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stiffcal.limits import PIECE, ROWS, check_unpacked

Read: TypeAlias = Callable[[int, int], NDArray[Any]]
CACHED = 1 << 20  # bytes of a chunk that the library keeps unpacked by itself


def check_sizes(datasets: Mapping[str, Any], n_rows: int, display_name: str) -> None:
    """Raise an `InputError` where the columns that are read hold more than is allowed.

    Parameters
    ----------
    datasets : column to its h5py dataset; several columns may lie in one.
    n_rows : rows of each.
    display_name : the file as messages name it.
    """
    ROWS.check(n_rows, display_name)
    distinct = {dataset.id.id: dataset for dataset in datasets.values()}
    at_once = unpacked = packed = 0
    for dataset in distinct.values():
        at_once += chunk_bytes(dataset)
        unpacked += dataset.size * dataset.dtype.itemsize
        packed += dataset.id.get_storage_size()
    PIECE.check(at_once, display_name)
    check_unpacked(unpacked, packed, display_name)


def chunk_bytes(dataset: Any) -> int:
    """Return the bytes of one unpacked chunk of a dataset; 0 where it lies in one piece."""
    return 0 if dataset.chunks is None else math.prod(dataset.chunks) * int(dataset.dtype.itemsize)


def by_chunk(read: Read, dataset: Any, axis: int, n_rows: int) -> Read:
    """Return a function that reads some rows, and takes those of a large chunk together.

    The library would unpack such a chunk again for every few rows, hours on end.

    Parameters
    ----------
    read : gives rows `start` to before `end`.
    dataset : where they lie.
    axis : along which they lie.
    """
    if chunk_bytes(dataset) <= CACHED or dataset.dtype.hasobject:
        return read
    step = int(dataset.chunks[axis])
    last_read: dict[int, NDArray[Any]] = {}

    def rows(start: int, end: int) -> NDArray[Any]:
        parts = []
        for number in range(start // step, -(-end // step)):
            first = number * step
            if number not in last_read:
                last_read.clear()
                last_read[number] = read(first, min(first + step, n_rows))
            parts.append(last_read[number][max(start - first, 0) : end - first])
        return parts[0] if len(parts) == 1 else np.concatenate(parts) if parts else read(start, end)

    return rows

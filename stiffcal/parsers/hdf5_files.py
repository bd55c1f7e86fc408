"""HDF5 files, opened only where nothing in them leads to another file, and large chunks read once.

A link, a dataset that is put together from others and one whose numbers lie outside can name any file of the machine,
the file itself included: reading such a dataset is reading a secret, waiting on a pipe for ever, or a circle. The
library opens what they name as soon as a name is looked up, so every link of the file is looked at first, and every
dataset before its shape is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

import h5py
import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

Read: TypeAlias = Callable[[int, int], NDArray[Any]]
CACHED = 1 << 20  # bytes of a chunk that the library keeps unpacked by itself


@contextmanager
def open_hdf5(path: Path, display_name: str) -> Iterator[h5py.File]:
    """Open a file.

    Raises
    ------
    InputError
        Something in it leads to another file.
    """
    with h5py.File(path, "r") as file:
        _refuse_ways_out(file.id, display_name)
        yield file


def checked(item: Any, display_name: str) -> Any:
    """Return an object that a reference led to: it need have no name, by which it would have been looked at."""
    if isinstance(item, h5py.Dataset):
        _refuse_dataset(item.id, "a dataset without a name", display_name)
    return item


def member_of(group: h5py.Group, name: str) -> Any | None:
    """Return the object of a name or path; None where there is none, a soft link leads nowhere or in a circle."""
    try:
        return group[name]
    except (KeyError, OSError, RuntimeError):
        return None


def members_of(group: h5py.Group) -> dict[str, Any]:
    """Return the objects of a group by name."""
    return {name: item for name in group if (item := member_of(group, name)) is not None}


def _refuse_ways_out(root: Any, display_name: str) -> None:
    """Raise an `InputError` where a link or dataset leads out of the file; each object is looked at once."""
    waiting, seen = [root], {_place(h5py.h5o.get_info(root))}
    while waiting:
        group = waiting.pop()
        for name in group:
            link = group.links.get_info(name).type
            if link == h5py.h5l.TYPE_SOFT:  # within the file: it can lead on only by a link that is refused here
                continue
            shown = name.decode("utf-8", "replace")
            if link != h5py.h5l.TYPE_HARD:
                raise _refused(shown, "is in another file, to which this one only links", display_name)
            item = h5py.h5o.get_info(group, name)
            if _place(item) in seen:
                continue
            seen.add(_place(item))
            if item.type == h5py.h5o.TYPE_GROUP:
                waiting.append(h5py.h5o.open(group, name))
            elif item.type == h5py.h5o.TYPE_DATASET:
                _refuse_dataset(h5py.h5o.open(group, name), shown, display_name)


def _place(item: Any) -> tuple[int, int]:
    return int(item.fileno), int(item.addr)


def _refuse_dataset(dataset: Any, name: str, display_name: str) -> None:
    settings = dataset.get_create_plist()
    if settings.get_layout() == h5py.h5d.VIRTUAL:
        raise _refused(name, "takes its values from other datasets (it is a virtual dataset)", display_name)
    if settings.get_external_count() > 0:
        raise _refused(name, "has its values in another file", display_name)


def _refused(name: str, what: str, display_name: str) -> InputError:
    mend = "copy its values into this file, e.g. with h5copy or h5repack"
    return InputError.at(FaultCode.FILE_OUTSIDE, display_name, name, f"{name!r} {what}", mend)


def by_chunk(read: Read, dataset: Any, axis: int, n_rows: int) -> Read:
    """Return a function that reads some rows, and takes those of a large chunk together.

    The library would unpack such a chunk again for every few rows, hours on end.

    Parameters
    ----------
    read : gives rows `start` to before `end`.
    dataset : where they lie.
    axis : along which they lie.
    """
    chunk = 0 if dataset.chunks is None else math.prod(dataset.chunks) * int(dataset.dtype.itemsize)
    if chunk <= CACHED or dataset.dtype.hasobject:
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

"""The heaps of an HDF5 file, in which words of any length lie, looked through before the library reads from them.

An object in a damaged heap whose stated size is zero, or more than there is, leads libhdf5 in a circle for ever (found
with 2.0), where nothing can call it back. So each heap is walked here first, as the library does it.

Source: The HDF Group, HDF5 File Format Specification, III.E "Disk Format: Level 1E - Global Heap".
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import IO, Any

from stiffcal.files import open_regular

SIGNATURE = b"GCOL\x01"
FILE_SIGNATURE = b"\x89HDF\r\n\x1a\n"
SMALLEST = 4096
OBJECT_HEAD = 16  # also where lengths have four bytes: it is padded to eight
PIECE = 1 << 22
# A smaller file is looked through whole, so that its own word for where data lie need not be believed.
SMALL_FILE = 1 << 26
MOST_BYTES = 1 << 29  # more than the words of a batch

Region = tuple[int, int]
"""Offset and number of bytes."""


class DamagedHeapError(OSError):
    """A heap's objects do not fit into it."""


def check_heaps(path: Path, data: Iterable[Region] = ()) -> None:
    """Walk through every heap; raises `DamagedHeapError` for one on which the library would not come to an end.

    Parameters
    ----------
    path : the file.
    data : where numbers lie, which need not be searched in a large file.
    """
    size = path.stat().st_size
    with open_regular(path, buffering=0) as file:
        layout = "<Q" if _bytes_of_length(file) != 4 else "<I"
        for start, end in _between(data if size > SMALL_FILE else (), size):
            for at in _signatures(file, start, end):
                _check_heap(file, at, size, layout)


def _bytes_of_length(file: IO[bytes]) -> int:
    """Return the number of bytes of a size in this file, as its first block states: eight in all but odd files."""
    at = 0
    while head := _read(file, at, 16):
        if head.startswith(FILE_SIGNATURE) and len(head) == 16:
            return head[14] if head[8] < 2 else head[10]
        at = max(2 * at, 512)
    return 8


def _read(file: IO[bytes], at: int, count: int) -> bytes:
    file.seek(at)
    return file.read(count)


def _between(data: Iterable[Region], size: int) -> Iterator[Region]:
    """Yield (start, end) of what lies between the regions."""
    at = 0
    for start, count in sorted(data):
        if start > at:
            yield at, start
        at = max(at, start + count)
    if at < size:
        yield at, size


def _signatures(file: IO[bytes], start: int, end: int) -> Iterator[int]:
    """Yield where heaps begin."""
    kept = len(SIGNATURE) - 1  # a signature may lie across two pieces
    while start < end:
        piece = _read(file, start, min(PIECE, end - start) + kept)
        at = piece.find(SIGNATURE)
        while at >= 0:
            yield start + at
            at = piece.find(SIGNATURE, at + 1)
        start += PIECE


def _check_heap(file: IO[bytes], at: int, file_size: int, layout: str) -> None:
    number = struct.calcsize(layout)
    head = _read(file, at, 8 + number)
    size = struct.unpack(layout, head[8:])[0] if len(head) == 8 + number else 0
    if not SMALLEST <= size <= file_size - at:  # the library reports this itself
        return
    position, end = at + OBJECT_HEAD, at + size
    while end - position >= OBJECT_HEAD:
        head = _read(file, position, 8 + number)
        index, object_size = struct.unpack("<H", head[:2])[0], struct.unpack(layout, head[8:])[0]
        needed = object_size if index == 0 else OBJECT_HEAD + (object_size + 7) // 8 * 8
        if needed == 0 or position + needed > end:
            raise DamagedHeapError(f"the words that lie at byte {position} are damaged")
        position += needed


def attribute_of(item: Any, name: str, absent: Any = None) -> Any:
    """Return an attribute of an h5py object, or `absent`; raises `DamagedHeapError` where the library would be lost."""
    if name not in item.attrs:
        return absent
    _check_objects(item, item.attrs.get_id(name).dtype)
    with bounded_memory():
        return item.attrs[name]


@contextmanager
def bounded_memory() -> Iterator[None]:
    """Let what stands in a damaged word as its length fail, where it is up to 4 GB that the library would take.

    On systems without such a limit nothing is done.
    """
    try:
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except (ImportError, OSError):
        yield
        return
    with _ONE_AT_A_TIME:
        soft, hard = resource.getrlimit(resource.RLIMIT_AS)
        most = pages * resource.getpagesize() + MOST_BYTES
        resource.setrlimit(resource.RLIMIT_AS, (most if soft == resource.RLIM_INFINITY else min(most, soft), hard))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


_ONE_AT_A_TIME = Lock()


def check_words(dataset: Any) -> None:
    """Raise `DamagedHeapError` where a dataset's words lie in heaps and one of those is damaged."""
    _check_objects(dataset, dataset.dtype)


def _check_objects(item: Any, dtype: Any) -> None:
    """Look through the heaps of an h5py object's file where values of `dtype` lie in them."""
    if not dtype.hasobject:
        return
    path = Path(item.file.filename)
    status = path.stat()
    if _SOUND.get(path) == (status.st_mtime_ns, status.st_size):
        return
    check_heaps(path, _regions(item.parent) if status.st_size > SMALL_FILE else ())
    _SOUND.clear()  # logs are read one after the other
    _SOUND[path] = (status.st_mtime_ns, status.st_size)


_SOUND: dict[Path, tuple[int, int]] = {}


def _regions(group: Any) -> list[Region]:
    """Return the offsets of a group's datasets in the file."""
    regions: list[Region] = []
    for item in group.values():
        kind = getattr(item, "dtype", None)
        if kind is None or kind.hasobject:
            continue
        if item.chunks is not None:
            item.id.chunk_iter(lambda chunk: regions.append((chunk.byte_offset, chunk.size)))
        elif (start := item.id.get_offset()) is not None:
            regions.append((start, item.id.get_storage_size()))
    return regions

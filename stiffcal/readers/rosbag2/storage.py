"""The files that a bag is made of, checked before a library opens them: nothing outside, nothing that never ends."""

from __future__ import annotations

import os
import re
import shutil
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_regular, open_regular
from stiffcal.limits import PIECE, UNPACKED, check_unpacked

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
MOST_METADATA = 16 << 20
MOST_SETTINGS = 1 << 20  # bytes of a topic's settings
MOST_NESTED = 50  # lists and tables in one another in metadata.yaml
STEP = 1 << 22
CHUNK, MESSAGE = "a chunk", "a message"
"""Parts of a bag, as the places of faults in them."""
COPY = "copy the bag again from its origin"


class QuotedPath(type(Path())):  # type: ignore[misc]  # pathlib's own class differs between systems
    """A path that is quoted where it is written out: rosbags opens ``file:<path>?immutable=1``.

    A name with ``%2f``, ``?`` or ``#`` in it would lead to another file than the one that was checked.
    """

    def __str__(self) -> str:
        return quote(os.fsencode(self.__fspath__()))

    def __fspath__(self) -> str:
        return str(super().__str__())


def check_bag(path: Path, display_name: str) -> None:
    """Check the files of a bag.

    Parameters
    ----------
    path : the bag's folder or file.
    display_name : how to call it.

    Raises
    ------
    InputError
        A file is no regular one, an SQLite file computes rather than holds its messages, or was left half-written; a
        packed file unpacks to more than is allowed.
    """
    if not path.is_dir():
        _check_file(path, display_name)
        return
    for file in sorted(path.iterdir()):
        _check_file(file, f"{display_name}/{file.name}")
    _check_metadata(path / "metadata.yaml", f"{display_name}/metadata.yaml")


def _check_file(path: Path, display_name: str) -> None:
    try:
        check_regular(path, display_name)
        if path.is_dir():
            return
        with open_regular(path, display_name) as file:
            start = file.read(16)
    except FileNotFoundError:
        raise InputError.at(FaultCode.FILE_KIND, display_name, "", "this link leads nowhere", COPY) from None
    if start.startswith(ZSTD_MAGIC):
        _check_packed(path, display_name)
    elif start.startswith(b"SQLite format 3"):
        _check_database(path, display_name)


def _check_metadata(path: Path, display_name: str) -> None:
    """Bound the size and depth of metadata.yaml, for which the library's parser would need minutes."""
    with open_regular(path, display_name) as file:
        content = file.read(MOST_METADATA + 1)
    if len(content) > MOST_METADATA:
        raise InputError.at(FaultCode.SIZE_EXCEEDED, display_name, "", f"more than {MOST_METADATA >> 20} MiB", COPY)
    if _too_deeply_nested(content.decode("utf-8", "replace")):
        raise InputError.at(FaultCode.SIZE_EXCEEDED, display_name, "", "lists are nested too deeply", COPY)


def _too_deeply_nested(text: str) -> bool:
    """Return True where lists or tables of a YAML text are nested deeper than `MOST_NESTED`, roughly counted."""
    level = deepest = 0
    for mark in re.findall(r"[\[\]{}]", text):
        level += 1 if mark in "[{" else -1
        deepest = max(deepest, level)
    indented = max((len(line) - len(line.lstrip(" ")) for line in text.splitlines()), default=0)
    in_a_row = any(mark * (MOST_NESTED + 1) in text for mark in ("- ", "? ", "-\t"))
    return deepest > MOST_NESTED or indented > 4 * MOST_NESTED or in_a_row


def _check_packed(path: Path, display_name: str) -> None:
    """Unpack a file to nowhere: the library would write all of it to the disk first."""
    import pyarrow as pa

    unpacked, packed = 0, path.stat().st_size
    room = min(UNPACKED.most, shutil.disk_usage(tempfile.gettempdir()).free)
    with pa.CompressedInputStream(pa.OSFile(str(path)), "zstd") as stream:
        while piece := stream.read(STEP):
            unpacked += len(piece)
            check_unpacked(unpacked, packed, display_name)
            if unpacked > room:
                mend = "free some space, set another folder in TMPDIR, or unpack the bag yourself"
                raise InputError.at(
                    FaultCode.SIZE_EXCEEDED,
                    display_name,
                    "",
                    "unpacked, it exceeds the space for temporary files",
                    mend,
                )


def _check_database(path: Path, display_name: str) -> None:
    """Refuse a database whose rows are computed, or whose newest rows lie in a file of their own.

    Views, generated columns and virtual tables are programs: one can yield rows for ever, or a row of gigabytes.
    """
    for ending in ("-wal", "-journal"):
        journal = path.with_name(path.name + ending)
        if journal.exists() and journal.stat().st_size > 0:
            reason = f"the recorder was interrupted: part of the messages is in {journal.name}"
            mend = f"""put both into one file in a copy: sqlite3 {path.name} "PRAGMA wal_checkpoint(TRUNCATE)\""""
            raise InputError.at(FaultCode.FILE_INCOMPLETE, display_name, "", reason, mend)
    with closing(sqlite3.connect(f"file:{QuotedPath(path)}?mode=ro&immutable=1", uri=True)) as database:
        database.execute("PRAGMA trusted_schema = OFF")
        for kind, name, root in database.execute("SELECT type, name, rootpage FROM sqlite_master"):
            if kind not in ("table", "index") or not root:
                raise InputError.at(
                    FaultCode.CONTENT_UNSUPPORTED,
                    display_name,
                    str(name),
                    f"the bag contains a {kind} that computes its rows",
                    COPY,
                )
            if kind == "index":
                columns = database.execute("SELECT cid FROM pragma_index_info(?)", (name,))
                computed = any(number < 0 for (number,) in columns)
            else:
                columns = database.execute("SELECT hidden FROM pragma_table_xinfo(?)", (name,))
                computed = any(hidden for (hidden,) in columns)
            if computed:
                raise InputError.at(
                    FaultCode.CONTENT_UNSUPPORTED,
                    display_name,
                    str(name),
                    "the bag contains computed columns",
                    COPY,
                )


@cache
def fence_rosbags() -> None:
    """Bound what rosbags unpacks and parses while it opens a bag; what a recorder writes goes through as before.

    It unpacks all of a chunk before it compares its size with the stated one, and its parser of YAML needs seconds for
    some bytes of a topic's settings.
    """
    from rosbags.rosbag2 import metadata, reader, storage_mcap, storage_sqlite3

    storage_mcap.DECOMPRESSORS.update({"lz4": _unlz4, "zstd": unzstd})
    parse = metadata.parse_qos

    def parse_qos(settings: Any) -> Any:
        if isinstance(settings, str) and (len(settings) > MOST_SETTINGS or _too_deeply_nested(settings)):
            raise ValueError("the settings of a topic are not a plain list")
        return parse(settings)

    for module in (reader, storage_mcap, storage_sqlite3):
        module.parse_qos = parse_qos  # type: ignore[attr-defined]


def _unlz4(data: bytes, size: int) -> bytes:
    from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

    PIECE.check(size, CHUNK)
    check_unpacked(size, len(data), CHUNK)
    unpacking = LZ4FrameDecompressor()
    content = unpacking.decompress(data, max_length=size + 1)
    if not unpacking.eof and len(content) <= size:
        content += unpacking.decompress(b"", max_length=1)
    return bytes(content)


def unzstd(data: bytes, size: int | None = None) -> bytes:
    """Unpack a chunk or message; with `size`, to one byte more at most, which its reader then finds wrong.

    Raises
    ------
    InputError
        It unpacks to more than is allowed.
    """
    import pyarrow as pa

    most = PIECE.most if size is None else size
    PIECE.check(most, CHUNK)
    check_unpacked(0 if size is None else size, len(data), CHUNK)
    pieces, unpacked = [], 0
    with pa.CompressedInputStream(pa.BufferReader(data), "zstd") as stream:
        while unpacked <= most and (piece := stream.read(min(STEP, most + 1 - unpacked))):
            pieces.append(piece)
            unpacked += len(piece)
            check_unpacked(unpacked, len(data), MESSAGE)
    PIECE.check(unpacked, MESSAGE)
    return b"".join(pieces)


def check_chunks(reader: Any, path: Path, display_name: str) -> None:
    """Refuse an MCAP file whose index lists chunks that overlap: one could be read any number of times."""
    for chunks in _chunks_of(reader):
        end = unpacked = 0
        for chunk in sorted(chunks, key=lambda chunk: chunk.chunk_start_offset):
            if chunk.chunk_start_offset < end or chunk.compressed_size > chunk.chunk_length:
                raise InputError.at(FaultCode.FILE_DAMAGED, display_name, "", "its index lists a chunk twice", COPY)
            end = chunk.chunk_start_offset + chunk.chunk_length
            unpacked += chunk.uncompressed_size
        if chunks:
            packed = sum(file.stat().st_size for file in path.iterdir()) if path.is_dir() else path.stat().st_size
            check_unpacked(unpacked, packed, display_name)


def _chunks_of(reader: Any) -> Iterator[list[Any]]:
    storage = reader.storage
    for file in getattr(storage, "storages", None) or [storage]:
        yield getattr(file, "chunks", [])

"""The files that a bag is made of, checked before a library opens them: nothing outside, nothing that never ends."""

from __future__ import annotations

import os
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any
from urllib.parse import quote

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_regular, open_regular

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
        A file is no regular one, an SQLite file computes rather than holds its messages, or was left half-written.
    """
    if not path.is_dir():
        _check_file(path, display_name)
        return
    for file in sorted(path.iterdir()):
        _check_file(file, f"{display_name}/{file.name}")


def _check_file(path: Path, display_name: str) -> None:
    try:
        check_regular(path, display_name)
        if path.is_dir():
            return
        with open_regular(path, display_name) as file:
            start = file.read(16)
    except FileNotFoundError:
        raise InputError.at(FaultCode.FILE_KIND, display_name, "", "this link leads nowhere", COPY) from None
    if start.startswith(b"SQLite format 3"):
        _check_database(path, display_name)


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


def checked_chunks(reader: Any, display_name: str) -> int:
    """Return the bytes that all chunks of an MCAP file unpack to, by its index; 0 without one, and of other bags.

    The library holds each chunk to what the index states of it.

    Raises
    ------
    InputError
        The index lists chunks that overlap: one could be read any number of times.
    """
    unpacked = 0
    storage = reader.storage
    for file in getattr(storage, "storages", None) or [storage]:
        end = 0
        for chunk in sorted(getattr(file, "chunks", ()), key=lambda chunk: chunk.chunk_start_offset):
            if chunk.chunk_start_offset < end or chunk.compressed_size > chunk.chunk_length:
                raise InputError.at(FaultCode.FILE_DAMAGED, display_name, "", "its index lists a chunk twice", COPY)
            end = chunk.chunk_start_offset + chunk.chunk_length
            unpacked += chunk.uncompressed_size
    return unpacked


def checked_ros1_chunks(reader: Any, size: int, display_name: str) -> int:
    """Return the bytes that the chunks of a bag of ROS 1 hold unpacked, by their heads.

    Raises
    ------
    InputError
        Its index lists chunks that overlap or reach beyond the file, or a message twice.
    """
    from rosbags.rosbag1.reader import Header

    end = unpacked = 0
    for begin, chunk in sorted(reader.chunks.items()):
        if chunk.datapos < end or chunk.datapos + chunk.datasize > size:
            reason = "its index lists a chunk twice, or one that is not there"
            raise InputError.at(FaultCode.FILE_DAMAGED, display_name, "", reason, COPY)
        end = chunk.datapos + chunk.datasize
        reader.bio.seek(begin)
        unpacked += Header.read(reader.bio).get_uint32("size")
    listed = [(entry.chunk_pos, entry.offset) for index in reader.indexes.values() for entry in index]
    if len(set(listed)) < len(listed):
        raise InputError.at(FaultCode.FILE_DAMAGED, display_name, "", "its index lists a message twice", COPY)
    return unpacked

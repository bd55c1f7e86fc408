"""Text logs and tables that are packed by gzip, bzip2, xz or zstd, as streams of what they hold."""

from __future__ import annotations

import bz2
import lzma
from typing import IO, cast

UNPACKING_ERRORS = (EOFError, OSError, lzma.LZMAError)
"""What reading from an `unpacked_stream` raises where the file is damaged or cut off."""


def unpacked_stream(file: IO[bytes]) -> IO[bytes]:
    """Return what a file holds, unpacked where it begins like a file of gzip, bzip2, xz or zstd; else the file itself.

    Parameters
    ----------
    file : opened, at its beginning, where it can be set back to.
    """
    start = file.read(6)
    file.seek(0)
    if start.startswith(b"BZh") and start[3:4].isdigit():
        return cast("IO[bytes]", bz2.BZ2File(file))
    if start == b"\xfd7zXZ\x00":
        return cast("IO[bytes]", lzma.LZMAFile(file))
    # Not by Python's gzip, which takes forty times as long over a file of many small members.
    for first_bytes, packing in ((b"\x1f\x8b", "gzip"), (b"\x28\xb5\x2f\xfd", "zstd")):
        if start.startswith(first_bytes):
            import pyarrow as pa

            return cast("IO[bytes]", pa.CompressedInputStream(pa.PythonFile(file, mode="r"), packing))
    return file

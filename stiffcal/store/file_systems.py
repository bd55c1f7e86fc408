"""Which file systems show a change of a file in its times, also one that is written through a memory mapping."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from pathlib import Path

from stiffcal.files import open_regular

SHOWS_MAPPED_WRITES = frozenset({"ext2", "ext3", "ext4"})
"""Types of file systems, as Linux names them (one driver), on which it was tried: once a page is written back, the next
write through a mapping moves the time of change. On tmpfs it does not; on a network another machine's writes may come
late.
"""
_MOUNTS = Path("/proc/self/mountinfo")
_ESCAPE = re.compile(r"\\([0-7]{3})")


def shows_mapped_writes(path: Path) -> bool:
    """Return whether a file lies on a file system that shows every change in its times, False where that is not known.

    Examples
    --------
    >>> shows_mapped_writes(Path("/proc/self/mountinfo"))
    False
    """
    try:
        lines = _MOUNTS.read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    except OSError:  # no Linux
        return False
    place, kind, longest = os.path.realpath(path), "", 0
    for line in lines:
        fields, _, source = line.partition(" - ")
        mount = _ESCAPE.sub(lambda match: chr(int(match[1], 8)), fields.split(" ")[4])
        inside = place == mount or place.startswith(mount.rstrip("/") + "/")
        if inside and len(mount) >= longest:  # of two at one place the later one hides the earlier
            kind, longest = source.split(" ", 1)[0], len(mount)
    return kind in SHOWS_MAPPED_WRITES


def write_back(path: Path) -> bool:
    """Have the system write a file's changed pages to the disk; return False where it does not.

    While a page waits for that, writes to it through a mapping leave the file's times as they are.
    """
    with suppress(OSError), open_regular(path, buffering=0) as file:
        os.fsync(file.fileno())
        return True
    return False

"""Locks that end with the process that holds them, so that a killed one leaves none behind."""

from __future__ import annotations

import json
import os
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from stiffcal.errors import InputError, one_line
from stiffcal.fault_codes import FaultCode
from stiffcal.files import try_lock
from stiffcal.plain_files import kind_of, open_inside

POLL_S = 0.05
_MOST_BYTES = 4096
_BEGIN = b'{"pid": '


@contextmanager
def writer_lock(path: Path, command: str, wait_s: float, display_name: str) -> Iterator[None]:
    """Hold the lock file `path` while writing.

    Raises
    ------
    InputError
        If another process still holds it after `wait_s` seconds; it is named. Or the file holds what is no lock.
    """
    descriptor = _opened(path, display_name)
    try:
        end = time.monotonic() + wait_s
        while not try_lock(descriptor):
            if time.monotonic() >= end:
                reason = f"{_holder(path)} is writing to it"
                raise InputError.at(
                    FaultCode.STORE_LOCKED, display_name, "", reason, "wait until it has ended, then do this again"
                )
            time.sleep(POLL_S)
        _check_own(path, descriptor, display_name)
        holder = json.dumps({"pid": os.getpid(), "command": command}).encode()
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, holder, 0) if hasattr(os, "pwrite") else os.write(descriptor, holder)
        yield
    finally:
        os.close(descriptor)


def _check_own(path: Path, descriptor: int, display_name: str) -> None:
    """Refuse a file of this name that no writer has written; a computer that lost its power leaves zeros, or a part."""
    begin = os.read(descriptor, len(_BEGIN))
    os.lseek(descriptor, 0, os.SEEK_SET)
    if not _BEGIN.startswith(begin) and begin.strip(b"\0"):
        reason, mend = "this is a file that stiffcal did not write", "move it, or put the store elsewhere with --store"
        raise InputError.at(FaultCode.FILE_EXISTS, display_name, path.name, reason, mend)


def _opened(path: Path, display_name: str) -> int:
    """Open the lock file, made where it is not there.

    Raises
    ------
    InputError
        It is a link, a pipe or anything else that is no plain file: what is written into it would go elsewhere.
    """
    with suppress(FileNotFoundError):
        status = path.lstat()
        if not stat.S_ISREG(status.st_mode):
            raise InputError.at(
                FaultCode.STORE_DAMAGED,
                display_name,
                path.name,
                f"this is {kind_of(status)}, not a plain file",
                "remove it",
            )
    flags = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
    return os.open(path, os.O_RDWR | os.O_CREAT | flags, 0o666)


def _holder(path: Path) -> str:
    try:
        with open_inside(path.parent, path.name) as file:
            holder = json.loads(file.read(_MOST_BYTES))
        return f"another stiffcal ({one_line(str(holder['command']), 40)}, process {int(holder['pid'])})"
    except (OSError, ValueError, KeyError, TypeError, RecursionError, OverflowError):
        return "another stiffcal"

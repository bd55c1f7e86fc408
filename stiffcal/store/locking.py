"""Locks that end with the process that holds them, so that a killed one leaves none behind."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.files import try_lock

POLL_S = 0.05


@contextmanager
def writer_lock(path: Path, command: str, wait_s: float, shown: str) -> Iterator[None]:
    """Hold the lock file `path` while writing.

    Raises
    ------
    InputError
        If another process still holds it after `wait_s` seconds; it is named.
    """
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        end = time.monotonic() + wait_s
        while not try_lock(descriptor):
            if time.monotonic() >= end:
                reason = f"{_holder(path)} is writing to it"
                raise InputError.at(shown, "", reason, "wait until it has ended, then do this again")
            time.sleep(POLL_S)
        who = json.dumps({"pid": os.getpid(), "command": command}).encode()
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, who, 0) if hasattr(os, "pwrite") else os.write(descriptor, who)
        yield
    finally:
        os.close(descriptor)


def _holder(path: Path) -> str:
    try:
        who = json.loads(path.read_text("utf-8"))
        return f"another stiffcal ({who['command']}, process {who['pid']})"
    except (OSError, ValueError, KeyError, TypeError):
        return "another stiffcal"

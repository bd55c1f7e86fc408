"""Generations that the record could not take: an empty file each, named by the digest, until it can.

Why: on a full disk, or where files may not grow any more, the record cannot be replaced, but an empty file can still be
made. Without it the results just computed would be nobody's, and the next command would compute all of them again.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from stiffcal.trust.content import SHA256
from stiffcal.trust.state import fault_of_owner

PENDING = "pending"


def add_pending(folder: Path, digests: Iterable[str]) -> bool:
    """Note generations in the state folder; return False where that cannot be done either.

    Parameters
    ----------
    folder : the state folder.
    digests : SHA-256 of the generations' indexes.
    """
    try:
        (folder / PENDING).mkdir(mode=0o700, exist_ok=True)
        for digest in digests:
            flags = os.O_WRONLY | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
            os.close(os.open(folder / PENDING / digest, flags, 0o600))
    except OSError:
        return False
    return _is_own(folder)


def is_pending(folder: Path, digest: str) -> bool:
    """Return whether a generation is noted in the state folder."""
    return SHA256.fullmatch(digest) is not None and _is_own(folder) and (folder / PENDING / digest).is_file()


def all_pending(folder: Path) -> tuple[str, ...]:
    """Return the digests of all generations that are noted in the state folder, in order."""
    if not _is_own(folder):
        return ()
    with suppress(OSError):
        return tuple(sorted(path.name for path in (folder / PENDING).iterdir() if SHA256.fullmatch(path.name)))
    return ()


def remove_pending(folder: Path, digests: Iterable[str]) -> None:
    """Remove notes of generations that the record holds by now."""
    with suppress(OSError):
        for digest in digests:
            (folder / PENDING / digest).unlink(missing_ok=True)
        (folder / PENDING).rmdir()


def _is_own(folder: Path) -> bool:
    try:
        status = (folder / PENDING).lstat()
    except OSError:
        return False
    return fault_of_owner(status) == ""

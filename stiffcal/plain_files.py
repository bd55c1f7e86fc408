"""Files below a folder, opened without following a link: the folder may come from somebody else.

Every part of a path below the folder has to be a plain folder, and the last one a regular file; a link, a pipe,
a socket or a device is an `OSError` at once, also where another user put it there.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import IO, cast

_COMMON = getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_NOFOLLOW", 0)
_FILE = os.O_RDONLY | _COMMON | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
_FOLDER = os.O_RDONLY | _COMMON | getattr(os, "O_DIRECTORY", 0)
_BY_DESCRIPTOR = os.open in os.supports_dir_fd and os.stat in os.supports_dir_fd


_REFUSALS = frozenset({
    errno.EACCES, errno.EPERM, errno.EIO, errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.EAGAIN, errno.EBUSY,
    errno.ETIMEDOUT, errno.ESTALE, errno.ENOTCONN,
})  # fmt: skip


class StrangeFileError(OSError):
    """Something below a folder is a link, a pipe or a device where a plain file or folder has to be."""


def is_refused(error: OSError) -> bool:
    """Return whether the system does not let something be read that may well be there and sound.

    What is refused is neither missing nor damaged: nothing may be computed again or removed because of it.

    Examples
    --------
    >>> is_refused(PermissionError(errno.EACCES, "Permission denied"))
    True
    >>> is_refused(FileNotFoundError(errno.ENOENT, "No such file or directory"))
    False
    """
    return error.errno in _REFUSALS


def is_there(path: Path) -> bool:
    """Return whether there is something of this name, be it a link to nothing.

    Raises
    ------
    OSError : the system does not say (`is_refused`).
    """
    try:
        path.lstat()
    except OSError as error:
        if is_refused(error):
            raise
        return False
    return True


def open_inside(root: Path, inside: str) -> IO[bytes]:
    """Open a regular file below a folder for reading.

    Parameters
    ----------
    root : the folder; it may be reached by links.
    inside : the path below it, parts separated by slashes.

    Raises
    ------
    OSError : it is not there, cannot be read, or a part of the path is a link or anything else that is not plain.

    Examples
    --------
    >>> with open_inside(Path(__file__).parent, "plain_files.py") as file:
    ...     len(file.read(3))
    3
    """
    pieces = inside.split("/")
    if not all(pieces) or {".", ".."} & set(pieces):
        raise StrangeFileError(errno.EINVAL, "not a path below the folder", inside)
    descriptor = _descriptor(root, pieces, inside) if _BY_DESCRIPTOR else _checked_by_path(root, pieces, inside)
    try:
        _check(os.fstat(descriptor), inside, folder=False)
        return cast("IO[bytes]", os.fdopen(descriptor, "rb"))
    except BaseException:
        os.close(descriptor)
        raise


def _descriptor(root: Path, parts: list[str], inside: str) -> int:
    place = os.open(root, _FOLDER & ~getattr(os, "O_NOFOLLOW", 0))
    try:
        for name in parts[:-1]:
            _check(os.stat(name, dir_fd=place, follow_symlinks=False), inside, folder=True)
            inner = os.open(name, _FOLDER, dir_fd=place)
            os.close(place)
            place = inner
        # The kind first: opening some devices has an effect.
        _check(os.stat(parts[-1], dir_fd=place, follow_symlinks=False), inside, folder=False)
        return os.open(parts[-1], _FILE, dir_fd=place)
    finally:
        os.close(place)


def _checked_by_path(root: Path, parts: list[str], inside: str) -> int:
    place = root
    for name in parts[:-1]:
        place /= name
        _check(place.lstat(), inside, folder=True)
    _check((place / parts[-1]).lstat(), inside, folder=False)
    return os.open(place / parts[-1], _FILE)


def _check(status: os.stat_result, inside: str, *, folder: bool) -> None:
    right = stat.S_ISDIR(status.st_mode) if folder else stat.S_ISREG(status.st_mode)
    if not right or is_junction(status):
        raise StrangeFileError(errno.EINVAL, f"this is {kind_of(status)}, not a plain {'folder' if folder else 'file'}")


def is_junction(status: os.stat_result) -> bool:
    """Return whether a status is that of a link of Windows, which looks like a folder."""
    return bool(getattr(status, "st_reparse_tag", 0))


def kind_of(status: os.stat_result) -> str:
    """Return the kind of a file, in words.

    Examples
    --------
    >>> kind_of(Path(__file__).stat())
    'a file'
    """
    kinds = (
        (stat.S_ISLNK, "a link"), (stat.S_ISDIR, "a folder"), (stat.S_ISREG, "a file"), (stat.S_ISFIFO, "a pipe"),
        (stat.S_ISSOCK, "a socket"), (stat.S_ISCHR, "a device"), (stat.S_ISBLK, "a device"),
    )  # fmt: skip
    if is_junction(status):
        return "a link"
    return next((words for matches, words in kinds if matches(status.st_mode)), "something else")


def is_plain_folder(path: Path) -> bool:
    """Return whether a path is a folder, and no link to one."""
    try:
        status = path.lstat()
    except (OSError, ValueError):
        return False
    return stat.S_ISDIR(status.st_mode) and not is_junction(status)

"""Opening regular files alone, writing files whole or not at all, and what the system refuses in words."""

from __future__ import annotations

import errno
import os
import re
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, NoReturn, cast

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import DOCUMENT, Limit

if sys.platform == "win32":
    import msvcrt

    def try_lock(descriptor: int, shared: bool = False) -> bool:
        """Lock an open file without waiting; False where another process holds it. No lock here is shared."""
        try:
            os.lseek(descriptor, 1 << 30, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return shared
        return True
else:
    import fcntl

    def try_lock(descriptor: int, shared: bool = False) -> bool:
        """Lock an open file without waiting; False where another process holds it in a way that excludes ours."""
        try:
            fcntl.flock(descriptor, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True


_SPACE, _RIGHT = "free some space, or choose another disk", "get permission, or choose another location"
MENDS = {
    errno.ENOSPC: _SPACE,
    errno.EDQUOT: _SPACE,
    errno.EFBIG: "choose a disk that takes larger files",
    errno.EACCES: _RIGHT,
    errno.EPERM: _RIGHT,
    errno.EROFS: "choose a writable location",
    errno.EIO: "check the disk",
    errno.ENOENT: "check whether it was moved or deleted in the meantime",
    errno.ENOMEM: "close other programs, or use a machine with more memory",
    errno.EAGAIN: "close other programs, or allow more processes",
    errno.EBUSY: "close the program that uses it",
    errno.ETXTBSY: "close the program that uses it",
    errno.EEXIST: "remove it, or choose another name",
    errno.ENXIO: "check whether the device is connected",
    errno.ETIMEDOUT: "check whether the network folder is still connected",
    errno.ENOTDIR: "correct the path",
    errno.EISDIR: "name a file in it",
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.ELOOP: "repair the links",
    errno.EMFILE: "close other programs, or allow more open files",
    errno.ENFILE: "close other programs, or allow more open files",
    errno.ESTALE: "check whether the network folder is still connected",
    errno.ENOTCONN: "check whether the network folder is still connected",
}
"""What a system refuses for reasons of its own, and what the user can do about it."""


def refusal(error: OSError, file: str | Path = "") -> InputError | None:
    """Return a refusal of the system as an `InputError`, None where the error is no such refusal.

    Parameters
    ----------
    error : as caught.
    file : how to call what was to be read or written; left out: the name in the error.

    Examples
    --------
    >>> print(refusal(OSError(errno.ENOSPC, "No space left on device"), "report.pdf"))
    report.pdf: cannot be read or written: No space left on device; free some space, or choose another disk \
[system-refusal]
    >>> refusal(OSError("a library's own"))
    """
    mend = MENDS.get(error.errno or 0)
    if mend is None:
        return None
    display_name = str(file) or os.fsdecode(error.filename if isinstance(error.filename, str | bytes) else "")
    reason = f"cannot be read or written: {os.strerror(error.errno or 0)}"
    return InputError.at(FaultCode.SYSTEM_REFUSAL, display_name or "a file", "", reason, mend)


_FLAGS = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_NOCTTY", 0)
_NONBLOCK = getattr(os, "O_NONBLOCK", 0)
_OF_THE_SYSTEM = ("/proc", "/sys")  # their files state no size, and some never end or wait for an event


def open_regular(path: Path, display_name: str = "", *, buffering: int = -1, follow: bool = True) -> IO[bytes]:
    """Open a file that somebody else may have put there: a regular file, or an error at once.

    A pipe would let the reader wait for ever, a device would never end. The file's kind is checked, it is opened
    without waiting, and its kind is checked again on the open handle. A file that the user names on the command line
    may be a pipe: use `Path.open`.

    Parameters
    ----------
    path : the file. shown : how to call it in a fault; absent: the path.
    buffering : as of `open`; 0 gives an `io.FileIO`.
    follow : False refuses a symbolic link as the last part of the path.

    Raises
    ------
    InputError : it is a pipe, socket, device, or a file of /proc or /sys.
    OSError : as `open` raises it: no such file, a folder, no right to read it.

    Examples
    --------
    >>> with open_regular(Path(__file__)) as file:
    ...     _ = file.read(10)
    >>> open_regular(Path("/dev/null"))
    Traceback (most recent call last):
    stiffcal.errors.InputError: /dev/null: this is a device, not a file; replace it by a regular file [file-kind]
    """
    descriptor = _descriptor(path, display_name or str(path), 0 if follow else getattr(os, "O_NOFOLLOW", 0))
    try:
        _check_kind(os.fstat(descriptor), path, display_name or str(path))
        return cast("IO[bytes]", os.fdopen(descriptor, "rb", buffering=buffering))
    except BaseException:
        os.close(descriptor)
        raise


def check_regular(path: Path, display_name: str = "") -> None:
    """Do as `open_regular` for a library that takes only a path; a folder passes.

    Raises
    ------
    InputError : it is a pipe, socket, device, or a file of /proc or /sys.
    OSError : no such file, no right to reach it.
    """
    status = path.stat()
    if not stat.S_ISDIR(status.st_mode):
        _check_kind(status, path, display_name or str(path))
        _check_place(path, display_name or str(path))


def read_regular(path: Path, display_name: str = "", *, limit: Limit = DOCUMENT, follow: bool = True) -> bytes:
    """Read a whole file as `open_regular` does, up to a limit of bytes.

    Raises
    ------
    InputError : it is no regular file, or larger than the limit.
    OSError : as `open_regular`.
    """
    with open_regular(path, display_name, buffering=0, follow=follow) as file:
        limit.check(os.fstat(file.fileno()).st_size, display_name or str(path))
        pieces, left = [], limit.most + 1
        while left > 0 and (piece := file.read(min(left, 1 << 22))):
            pieces.append(piece)
            left -= len(piece)
    content = b"".join(pieces)
    limit.check(len(content), display_name or str(path))
    return content


def is_given(path: Path) -> bool:
    """Return True for what a user can name on the command line to be read: a file, a pipe, a terminal.

    Examples
    --------
    >>> is_given(Path(__file__)), is_given(Path(__file__).parent)
    (True, False)
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False
    return stat.S_ISREG(mode) or stat.S_ISFIFO(mode) or stat.S_ISCHR(mode) or stat.S_ISSOCK(mode)


def _descriptor(path: Path, display_name: str, further: int) -> int:
    _check_kind(path.stat(), path, display_name)  # before it is opened: opening some devices has an effect
    _check_place(path, display_name)
    try:
        return os.open(path, _FLAGS | _NONBLOCK | further)
    except BlockingIOError:  # a file server has lent the file out: it gives it back to a reader that waits
        return os.open(path, _FLAGS | further)


def _check_kind(status: os.stat_result, path: Path, display_name: str) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):
        _refuse(status.st_mode, display_name)


def _check_place(path: Path, display_name: str) -> None:
    if os.name == "posix" and os.path.realpath(path).startswith(tuple(f"{place}/" for place in _OF_THE_SYSTEM)):
        raise InputError.at(
            FaultCode.FILE_KIND, display_name, "", "this is a file of the operating system, not on a disk", _REGULAR
        )


_REGULAR = "replace it by a regular file"
_OTHER_NAME = "name another file"


def _refuse(mode: int, display_name: str, mend: str = _REGULAR) -> NoReturn:
    kinds = ((stat.S_ISFIFO, "pipe"), (stat.S_ISSOCK, "socket"), (stat.S_ISCHR, "device"), (stat.S_ISBLK, "device"))
    kind = next((name for is_kind, name in kinds if is_kind(mode)), "special file")
    raise InputError.at(FaultCode.FILE_KIND, display_name, "", f"this is a {kind}, not a file", mend)


def is_of_the_system(goal: Path) -> bool:
    """Return whether a name is one of the running system, as /dev/stdout, and not of a disk."""
    folder = f"{os.path.realpath(goal.parent)}/"
    return os.name == "posix" and (
        folder in ("/dev/", "/dev/pts/") or folder.startswith(tuple(f"{place}/" for place in _OF_THE_SYSTEM))
    )


def check_goal(goal: Path) -> None:
    """Refuse to put a file where none can be, or in the place of what is none.

    With the rights of root, /dev/null would be lost.

    Raises
    ------
    InputError : its folder does not exist, or it is a pipe, a device or a name of the operating system.
    """
    if not goal.parent.is_dir():
        raise InputError.at(FaultCode.FILE_MISSING, str(goal), "", "its folder does not exist", "make the folder first")
    with suppress(OSError):
        mode = goal.stat().st_mode
        if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
            _refuse(mode, str(goal), _OTHER_NAME)
    if is_of_the_system(goal):
        raise InputError.at(
            FaultCode.FILE_KIND, str(goal), "", "this is a name of the operating system, not on a disk", _OTHER_NAME
        )


def check_stream(goal: Path) -> None:
    """Refuse what is no file, as `check_goal` does, for what is written to as it is: as /dev/stdout may be.

    A pipe that nobody reads would let the writer wait for ever, and a stranger may have put it into a folder.

    Raises
    ------
    InputError : it is a pipe, a socket or a device, and no name of the running system.
    """
    if goal.exists() and not is_of_the_system(goal):
        check_goal(goal)


def temporary_name(ending: str = "") -> str:
    """Return a name that nobody can foresee, for a file or folder that is being written."""
    import secrets  # brings OpenSSL along, which commands that only read do without

    return f".stiffcal-{secrets.token_hex(8)}{ending}"


def holds_something(folder: Path) -> bool:
    """Return whether anything is in a folder but temporary files, which a killed process leaves."""
    return any(re.match(r"\.stiffcal-[0-9a-f]{16}(\.|$)", path.name) is None for path in folder.iterdir())


@contextmanager
def replacing(goal: Path) -> Iterator[Path]:
    """Hand out a name next to the goal, and put what was written there in the goal's place at the end, in one step.

    Why chance in the name: a name that can be foreseen might lie there already, as a link to a file of the user's.

    Raises
    ------
    InputError : the goal's folder does not exist, the goal is no file (a pipe, a device), or the file cannot be
        written; the goal is then as it was.

    Examples
    --------
    >>> import tempfile
    >>> goal = Path(tempfile.mkdtemp()) / "states.csv"
    >>> with replacing(goal) as temporary:
    ...     _ = temporary.write_text("Fx")
    >>> goal.read_text(), len(list(goal.parent.iterdir()))
    ('Fx', 1)
    """
    temporary = goal.with_name(temporary_name(goal.suffix))
    try:
        check_goal(goal)
        yield temporary
        temporary.replace(goal)
    except OSError as error:
        text = error.strerror or (str(error).splitlines() or [type(error).__name__])[0]
        mend = MENDS.get(error.errno or 0, "choose a writable location")
        raise InputError.at(FaultCode.FILE_UNWRITABLE, str(goal), "", f"cannot be written ({text})", mend) from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def write_whole(goal: Path, text: str) -> None:
    """Write a text file in UTF-8, whole or not at all; raises `InputError` where that cannot be."""
    with replacing(goal) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")

"""Writing files whole or not at all, and what the system refuses in words."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from stiffcal.errors import InputError

_SPACE, _RIGHT = "free some space, or choose another disk", "get the right to, or choose another place"
MENDS = {
    errno.ENOSPC: _SPACE,
    errno.EDQUOT: _SPACE,
    errno.EFBIG: "choose a disk that takes larger files",
    errno.EACCES: _RIGHT,
    errno.EPERM: _RIGHT,
    errno.EROFS: "choose a place that can be written to",
    errno.EIO: "look whether the disk is in order",
    errno.ENOTDIR: "correct the path",
    errno.EISDIR: "name a file in it",
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.ELOOP: "mend the links",
    errno.EMFILE: "close other programs, or allow more open files",
    errno.ENFILE: "close other programs, or allow more open files",
    errno.ESTALE: "look whether the network folder is still there",
    errno.ENOTCONN: "look whether the network folder is still there",
}
"""What a system refuses for reasons of its own, and what the user can do about it."""


def refusal(error: OSError, file: str | Path = "") -> InputError | None:
    """Return what the system has refused as an error of the user's, or None where it is no such refusal.

    Parameters
    ----------
    error : as caught. file : how to call what was to be read or written; left out: the name in the error.

    Examples
    --------
    >>> print(refusal(OSError(errno.ENOSPC, "No space left on device"), "report.pdf"))
    report.pdf: cannot be read or written: No space left on device; free some space, or choose another disk
    >>> refusal(OSError("a library's own"))
    """
    mend = MENDS.get(error.errno or 0)
    if mend is None:
        return None
    shown = str(file) or os.fsdecode(error.filename if isinstance(error.filename, str | bytes) else "")
    reason = f"cannot be read or written: {os.strerror(error.errno or 0)}"
    return InputError.at(shown or "a file", "", reason, mend)


@contextmanager
def replacing(goal: Path) -> Iterator[Path]:
    """Hand out a name beside the goal, and put what was written there in the goal's place at the end, in one step.

    Raises
    ------
    InputError : the goal's folder does not exist, or the file cannot be written; the goal is then as it was.

    Examples
    --------
    >>> import tempfile
    >>> goal = Path(tempfile.mkdtemp()) / "states.csv"
    >>> with replacing(goal) as beside:
    ...     _ = beside.write_text("Fx")
    >>> goal.read_text(), len(list(goal.parent.iterdir()))
    ('Fx', 1)
    """
    beside = goal.with_name(f".{goal.name}.{os.getpid()}")
    try:
        if not goal.parent.is_dir():
            raise InputError.at(str(goal), "", "its folder does not exist", "make the folder first")
        yield beside
        beside.replace(goal)
    except OSError as error:
        words = error.strerror or (str(error).splitlines() or [type(error).__name__])[0]
        mend = MENDS.get(error.errno or 0, "choose a place that can be written")
        raise InputError.at(str(goal), "", f"cannot be written ({words})", mend) from error
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def write_whole(goal: Path, text: str) -> None:
    """Write a text file in UTF-8, whole or not at all; raises `InputError` where that cannot be."""
    with replacing(goal) as beside:
        beside.write_text(text, encoding="utf-8", newline="\n")

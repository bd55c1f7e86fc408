"""Files that a command writes where its user wants them: what stiffcal has not written is not overwritten.

What decides is the content: its SHA-256 is noted in the user's state folder whenever a command writes such a file, as
the name of an empty file. Not a mark in the file: a table has no place for one, and a run sheet that was filled in by
hand would still carry it.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import stat
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_goal, open_regular, replacing
from stiffcal.trust.notices import notice
from stiffcal.trust.record import RECORD, open_record
from stiffcal.trust.state import fault_of_owner, make_private

OUTPUTS = "outputs"
MOST_OUTPUTS = 10_000
"""As many as generations of stores; of more the oldest are forgotten, and their files count as not written."""
PICTURES, TABLES = (".svg", ".png", ".pdf"), (".csv", ".xlsx", ".parquet")
"""Endings of what most commands write."""
CHUNK = 1 << 20
_of_this_process: set[str] = set()


def was_written(file: Path) -> bool:
    """Return whether a file holds exactly what a command of this user has written, here or elsewhere."""
    folder, digest = _folder(), _digest(file)
    believed = folder is not None and _is_own(folder)
    return any(
        key in _of_this_process or (believed and folder is not None and (folder / key).is_file())
        for key in (digest, _at(digest, file))
    )


def check_not_foreign(file: Path, overwrite: bool = False, is_own: Callable[[Path], bool] = was_written) -> None:
    """Refuse to write to a file that holds something stiffcal did not write.

    What is no regular file (a pipe, a device) or is empty holds nothing that could be lost.

    Parameters
    ----------
    file : to write to. overwrite : the user wants it nevertheless. is_own : whether stiffcal wrote the content.

    Raises
    ------
    InputError : it holds something else.
    """
    try:
        status = file.stat()
    except OSError:
        return
    if overwrite or not stat.S_ISREG(status.st_mode) or not status.st_size or is_own(file):
        return
    mend = "give another name, remove this file, or add --overwrite"
    raise InputError.at(
        FaultCode.FILE_EXISTS, str(file), "", "the file holds something that stiffcal did not write", mend
    )


def check_output(goal: Path, endings: Sequence[str] | None = None, overwrite: bool = False) -> None:
    """Refuse what cannot be written, before the work that leads to it begins.

    Parameters
    ----------
    goal : to write. endings : of names that fit, lower case with their point; None: any.
    overwrite : see `check_not_foreign`.

    Raises
    ------
    InputError : the name ends otherwise, the folder does not exist, the goal is no file, or not ours to overwrite.
    """
    ending = goal.suffix.lower()
    if endings is not None and ending not in endings:
        reason = f"a name that ends in {ending} does not fit" if ending else "the name has no ending"
        mend = f"end the name in {', '.join(endings)}" if len(endings) == 1 else f"use one of {', '.join(endings)}"
        raise InputError.at(FaultCode.FORMAT_UNKNOWN, str(goal), "", reason, mend)
    check_goal(goal)
    check_not_foreign(goal, overwrite)


def chosen_output(named: Path | None, usual: Path, endings: Sequence[str], overwrite: bool = False) -> Path:
    """Return where a command writes: the file that the user has named, else the usual one of the campaign folder.

    Parameters
    ----------
    named : relative to the present folder, as the shell has it. usual : in the campaign folder, whose absence other
        checks report. endings, overwrite : as of `check_output`.

    Raises
    ------
    InputError : as `check_output`.
    """
    if named is None:
        check_not_foreign(usual, overwrite)
        return usual
    check_output(named, endings, overwrite)
    return named


@contextmanager
def written(goal: Path, overwrite: bool = False) -> Iterator[Path]:
    """Hand out a name to write to, and put what was written in the goal's place, as `files.replacing` does.

    Parameters
    ----------
    goal : to write. overwrite : see `check_not_foreign`.

    Raises
    ------
    InputError : as `check_not_foreign` and `files.replacing`; the goal is then as it was.
    """
    with replacing(goal) as temporary:
        yield temporary
        check_not_foreign(goal, overwrite)
        # Before it is in place: a file whose note is missing could not be written anew.
        _note(_digest(temporary))


def note_written(file: Path) -> None:
    """Remember what a file holds as written by stiffcal: an edit of what it had written, or can write again."""
    _note(_digest(file))


def check_copy(source: Path, goal: Path, overwrite: bool = False) -> None:
    """Do as `check_not_foreign` where the file will be a copy: what is a copy already is not lost."""
    check_not_foreign(goal, overwrite, lambda file: was_written(file) or _digest(file) == _digest(source))


def write_copy(source: Path, goal: Path, overwrite: bool = False) -> None:
    """Copy a file, as `written` does; the same content elsewhere stays the user's."""
    with replacing(goal) as temporary:
        shutil.copyfile(source, temporary)
        check_copy(temporary, goal, overwrite)
        _note(_at(_digest(temporary), goal))


def write_output(goal: Path, content: str | bytes, overwrite: bool = False) -> None:
    """Write a file, text in UTF-8, as `written` does; raises `InputError` likewise."""
    with written(goal, overwrite) as temporary:
        temporary.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)


def _digest(file: Path) -> str:
    digest = hashlib.sha256()
    with open_regular(file, buffering=0) as opened:
        while chunk := opened.read(CHUNK):
            digest.update(chunk)
    return digest.hexdigest()


def _at(digest: str, file: Path) -> str:
    """Return the note of content that was written in one place alone."""
    return hashlib.sha256(f"{digest} {os.path.realpath(file)}".encode("utf-8", "surrogateescape")).hexdigest()


def _folder() -> Path | None:
    """Return the folder of the notes, which need not exist; None where the state folder is not believed."""
    record = open_record().file
    return None if record is None else record.parent / OUTPUTS


def _is_own(folder: Path) -> bool:
    try:
        return fault_of_owner(folder.lstat()) == ""
    except OSError:
        return False


def _note(digest: str) -> None:
    """Remember that a command has written a file, by its digest or by that of `_at`."""
    _of_this_process.add(digest)
    folder = _folder()
    if folder is None:
        return  # which `open_record` has reported
    try:
        make_private(folder.parent, RECORD)
        folder.mkdir(mode=0o700, exist_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
        os.close(os.open(folder / digest, flags, 0o600))
        os.utime(folder / digest)
        _forget_oldest(folder)
    except OSError as error:
        reason = f"{folder} cannot be written ({error.strerror or error})"
        notice(f"{reason}: the next command takes the files of this one for somebody else's", OUTPUTS)


def _forget_oldest(folder: Path) -> None:
    entries = list(os.scandir(folder))
    if len(entries) > MOST_OUTPUTS:
        with suppress(OSError):
            # half of them, so that most commands have nothing to sort
            for entry in sorted(entries, key=lambda entry: entry.stat().st_mtime_ns)[: -MOST_OUTPUTS // 2]:
                Path(entry).unlink(missing_ok=True)

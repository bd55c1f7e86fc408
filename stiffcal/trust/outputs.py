"""Files that a command writes where its user wants them: what stiffcal has not written is not overwritten.

What decides is the content, and as what it was written: a SHA-256 of both is noted in the user's state folder whenever
a command writes such a file, as the name of an empty file. Not a mark in the file: a table has no place for one, and a
run sheet that was filled in by hand would still carry it. Not the content alone: what stiffcal has written as a log or
a model file is data, and no picture may take its place.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_goal, open_regular, replacing
from stiffcal.trust.notices import notice
from stiffcal.trust.output_kinds import OutputKind
from stiffcal.trust.record import RECORD, open_record
from stiffcal.trust.state import fault_of_owner, make_private

OUTPUTS = "outputs"
MOST_OUTPUTS = 10_000
"""As many as generations of stores; of more the oldest are forgotten, and their files count as not written."""
CHUNK = 1 << 20
_of_this_process: set[str] = set()


def was_written(file: Path, kind: OutputKind) -> bool:
    """Return whether a file holds exactly what a command of this user has written as this kind, here or elsewhere."""
    folder, digest = _folder(), _digest(file)
    believed = folder is not None and _is_own(folder)
    return any(
        key in _of_this_process or (believed and folder is not None and (folder / key).is_file())
        for key in (_noted(kind, digest), _noted(kind, digest, file))
    )


def check_not_foreign(file: Path, kind: OutputKind, overwrite: bool = False) -> None:
    """Refuse to write to a file that holds something stiffcal did not write as this kind.

    Parameters
    ----------
    file : to write to. kind : of what is to be in it. overwrite : the user wants it nevertheless.

    Raises
    ------
    InputError : it holds something else.
    """
    if not overwrite and holds_something(file) and not was_written(file, kind):
        raise not_ours(file)


def holds_something(file: Path) -> bool:
    """Return whether something could be lost with a file: what is none (a pipe, a device) or is empty holds nothing."""
    try:
        status = file.stat()
    except OSError:
        return False
    return stat.S_ISREG(status.st_mode) and status.st_size > 0


def not_ours(file: Path) -> InputError:
    """Return the error of a file that holds something else than what is to be written."""
    mend = "give another name, remove this file, or add --overwrite"
    reason = "the file holds something that stiffcal did not write, or wrote as something else"
    return InputError.at(FaultCode.FILE_EXISTS, str(file), "", reason, mend)


def check_output(goal: Path, kind: OutputKind, overwrite: bool = False) -> None:
    """Refuse what cannot be written, before the work that leads to it begins.

    Parameters
    ----------
    goal : to write. kind : of what is to be in it. overwrite : see `check_not_foreign`.

    Raises
    ------
    InputError : the name ends otherwise, the folder does not exist, the goal is no file, or not ours to overwrite.
    """
    ending, endings = goal.suffix.lower(), kind.endings
    if endings and ending not in endings:
        reason = f"a name that ends in {ending} does not fit" if ending else "the name has no ending"
        mend = f"end the name in {', '.join(endings)}" if len(endings) == 1 else f"use one of {', '.join(endings)}"
        raise InputError.at(FaultCode.FORMAT_UNKNOWN, str(goal), "", reason, mend)
    check_goal(goal)
    check_not_foreign(goal, kind, overwrite)


def chosen_output(named: Path | None, usual: Path, kind: OutputKind, overwrite: bool = False) -> Path:
    """Return where a command writes: the file that the user has named, else the usual one of the campaign folder.

    Parameters
    ----------
    named : relative to the present folder, as the shell has it. usual : in the campaign folder, whose absence other
        checks report. kind, overwrite : as of `check_output`.

    Raises
    ------
    InputError : as `check_output`.
    """
    if named is None:
        check_not_foreign(usual, kind, overwrite)
        return usual
    check_output(named, kind, overwrite)
    return named


@contextmanager
def written(goal: Path, kind: OutputKind, overwrite: bool = False) -> Iterator[Path]:
    """Hand out a name to write to, and put what was written in the goal's place, as `files.replacing` does.

    Parameters
    ----------
    goal : to write. kind : of what is written. overwrite : see `check_not_foreign`.

    Raises
    ------
    InputError : as `check_not_foreign` and `files.replacing`; the goal is then as it was.
    """
    with replacing(goal) as temporary:
        yield temporary
        check_not_foreign(goal, kind, overwrite)
        # Before it is in place: a file whose note is missing could not be written anew.
        note_written(temporary, kind)


def note_written(file: Path, kind: OutputKind) -> None:
    """Remember what a file holds as written by stiffcal: an edit of what it had written, or can write again."""
    _note(_noted(kind, _digest(file)))


def check_copy(source: Path, goal: Path, kind: OutputKind, overwrite: bool = False) -> None:
    """Do as `check_not_foreign` where the file will be a copy: what is a copy already is not lost."""
    if overwrite or not holds_something(goal) or _digest(goal) != _digest(source):
        check_not_foreign(goal, kind, overwrite)


def write_copy(source: Path, goal: Path, kind: OutputKind, overwrite: bool = False) -> None:
    """Copy a file, as `written` does; the same content elsewhere stays the user's."""
    with replacing(goal) as temporary:
        shutil.copyfile(source, temporary)
        check_copy(temporary, goal, kind, overwrite)
        _note(_noted(kind, _digest(temporary), goal))


def write_output(goal: Path, content: str | bytes, kind: OutputKind, overwrite: bool = False) -> None:
    """Write a file, text in UTF-8, as `written` does; raises `InputError` likewise."""
    with written(goal, kind, overwrite) as temporary:
        temporary.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)


def _digest(file: Path) -> str:
    digest = hashlib.sha256()
    with open_regular(file, buffering=0) as opened:
        while chunk := opened.read(CHUNK):
            digest.update(chunk)
    return digest.hexdigest()


def _noted(kind: OutputKind, digest: str, place: Path | None = None) -> str:
    """Return the note of content that was written as one kind; in one place alone, where that is given."""
    text = f"{kind.name} {digest}" if place is None else f"{kind.name} {digest} {os.path.realpath(place)}"
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()


def _folder() -> Path | None:
    """Return the folder of the notes, which need not exist; None where the state folder is not believed."""
    record = open_record().file
    return None if record is None else record.parent / OUTPUTS


def _is_own(folder: Path) -> bool:
    try:
        return fault_of_owner(folder.lstat()) == ""
    except OSError:
        return False


def _note(note: str) -> None:
    """Keep a note of `_noted`."""
    _of_this_process.add(note)
    folder = _folder()
    if folder is None:
        return  # which `open_record` has reported
    try:
        make_private(folder.parent, RECORD)
        folder.mkdir(mode=0o700, exist_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
        os.close(os.open(folder / note, flags, 0o600))
        os.utime(folder / note)
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

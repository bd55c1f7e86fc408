"""What a campaign folder may reach: nothing outside itself, unless the user allows it."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import IO

from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_regular, open_regular
from stiffcal.limits import Limit

ALLOW = "STIFFCAL_ALLOW"


def escapes(file: str) -> bool:
    """Return whether a path leads out of the folder that it is written in.

    Examples
    --------
    >>> escapes("raw/../table.csv"), escapes("../table.csv"), escapes("/tmp/table.csv"), escapes("C:/table.csv")
    (False, True, True, True)
    """
    if PureWindowsPath(file).drive or PureWindowsPath(file).root or PurePosixPath(file).is_absolute():
        return True
    depth = 0
    for name in PurePosixPath(file.replace("\\", "/")).parts:
        depth += -1 if name == ".." else 1
        if depth < 0:
            return True
    return False


def leads_outside(folder: Path, file: str) -> Path | None:
    """Return where a path inside a folder leads by links, if that is outside the folder and what the user allowed.

    Raises
    ------
    InputError
        It leads outside, and ``STIFFCAL_ALLOW`` holds what cannot be allowed.
    """
    try:
        goal, own_folder = (folder / file).resolve(), folder.resolve()
    except (OSError, ValueError, RuntimeError):  # links in a circle, a NUL: no such file, which is reported elsewhere
        return None
    inside = goal.is_relative_to(own_folder) or any(goal.is_relative_to(place) for place in _allowed_places(folder))
    return None if inside else goal


def _allowed_places(folder: Path) -> list[Path]:
    """Return the folders that the user allows links to lead to: ``STIFFCAL_ALLOW``, separated as in ``PATH``.

    A path through the campaign folder itself counts for nothing: where it leads is not the user's choice.
    """
    places = []
    for entry in filter(None, os.environ.get(ALLOW, "").split(os.pathsep)):
        place = Path(entry)
        if not place.is_absolute():
            mend = f"write the whole path, as in {ALLOW}=/data/logs"
            raise InputError.at(
                FaultCode.OPTION_INVALID,
                "",
                ALLOW,
                f"{entry!r} is a relative path, which depends on where stiffcal is started",
                mend,
            )
        plain = Path(os.path.normpath(place))
        if plain.parent == plain:
            raise InputError.at(
                FaultCode.OPTION_INVALID, "", ALLOW, f"{entry!r} would allow every file", "give the folder of the logs"
            )
        if not plain.is_relative_to(os.path.normpath(Path.cwd() / folder)):
            with suppress(OSError, RuntimeError):
                places.append(place.resolve())
    return places


def check_inside(folder: Path, file: str) -> None:
    """Raise an `InputError` where a file that is about to be written would lie outside the folder by a link."""
    goal = leads_outside(folder, file)
    if goal is not None:
        raise InputError(link_fault(str(folder / file), "", file, goal))


def links_outside(folder: Path, file: str) -> list[tuple[str, Path]]:
    """Return the paths that lead out of the folder by a link: of a path and, if that is a folder, of all in it.

    Returns
    -------
    Each with its path from the folder, and where it leads.
    """
    goal = leads_outside(folder, file)
    if goal is not None:
        return [(file, goal)]
    if "\0" in file:  # no file's name; reported where it is opened
        return []
    symlinks: list[str] = []
    waiting = [file]
    while waiting:  # a store of ten thousand runs has as many folders: no path is made of what is no link
        place = waiting.pop()
        with suppress(OSError), os.scandir(folder / place) as entries:
            for entry in entries:
                if entry.is_symlink():
                    symlinks.append((PurePosixPath(place) / entry.name).as_posix())
                elif entry.is_dir():
                    waiting.append(f"{place}/{entry.name}")
    return [(name, goal) for name in sorted(symlinks) if (goal := leads_outside(folder, name)) is not None]


class PlainFiles:
    """The regular files in folders that lie in the campaign folder, reached by no link: nothing is wrong with them.

    Why: of a campaign of thousands of logs each costs one look at the disk.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._inside: dict[str, bool] = {}

    def __contains__(self, file: str) -> bool:
        parent, _, name = file.rpartition("/")
        if "\\" in file or "\0" in file or name in ("", ".", ".."):
            return False
        if parent not in self._inside:
            self._inside[parent] = not escapes(file) and leads_outside(self._folder, parent or ".") is None
        try:
            return self._inside[parent] and stat.S_ISREG(os.lstat(f"{self._folder}/{file}").st_mode)
        except (OSError, ValueError):  # the check that reads it names the fault
            return False


def link_fault(named_in: str, place: str, file: str, goal: Path) -> Fault:
    """Return the fault of a path that leads out of the campaign folder by a link."""
    # No place to allow is named: who made the link would then choose what is opened to it.
    mend = (
        f"replace the link by the file; only if you made this link yourself, allow its target: {ALLOW} "
        "(docs/reference/reach.md)"
    )
    return Fault(
        FaultCode.FILE_OUTSIDE, named_in, place, f'"{file}" is a link to {goal}, outside the campaign folder', mend
    )


def check_own(folder: Path, file: str) -> None:
    """Raise an `InputError` where a file of a campaign is a link that leads outside; nothing of it has been read."""
    goal = leads_outside(folder, file)
    if goal is not None:
        raise InputError(link_fault(file, "", file, goal))


def check_given(path: Path) -> bool:
    """Check a file that the user names on the command line, and return whether it lies inside a campaign folder.

    It may be a pipe or a device, and a link to anywhere. One that lies inside a campaign folder was put there by the
    folder's maker: it has to be a regular file, and no link out of the folder.

    Raises
    ------
    InputError : it lies in a campaign folder and is something else.
    OSError : there is no such file, or no right to reach it.
    """
    plain = Path(os.path.normpath(Path.cwd() / path))
    folder = next((place for place in plain.parents if os.path.lexists(place / MANIFEST_FILE)), None)
    if folder is None:
        return False
    inside = plain.relative_to(folder).as_posix()
    goal = leads_outside(folder, inside)
    if goal is not None:
        raise InputError(link_fault(str(path), "", inside, goal))
    check_regular(path, str(path))
    return True


def open_given(path: Path) -> IO[bytes]:
    """Open a file that the user names on the command line, as `check_given` allows it; raises as that does."""
    return open_regular(path, str(path)) if check_given(path) else path.open("rb")


def read_given(path: Path, limit: Limit) -> bytes:
    """Read a file that the user has named (`open_given`); raises an `InputError` where it holds more than the limit."""
    with open_given(path) as file:
        content = file.read(limit.most + 1)
    limit.check(len(content), str(path))
    return content

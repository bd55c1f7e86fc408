"""The user's state folder: where it is, and whether nobody else can write what is believed there.

Why ancestors are looked through for a `campaign.toml`: a folder from somebody else must not bring a record of trust
with it, wherever `STIFFCAL_STATE` points.
"""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path

MANIFEST = "campaign.toml"
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def state_folder() -> Path | None:
    """Return the user's state folder, which need not exist; None where the user has no home."""
    folder_setting = os.environ.get("STIFFCAL_STATE")
    if folder_setting:
        return Path(os.path.abspath(folder_setting))  # noqa: PTH100 - links stay: resolve() is for the check of the place
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        if local:
            return Path(local) / "stiffcal"
    base = os.environ.get("XDG_STATE_HOME", "")
    if Path(base).is_absolute():  # the XDG specification has relative ones ignored
        return Path(base) / "stiffcal"
    try:
        home = Path.home()
    except RuntimeError:
        return None
    return home.joinpath(*(("AppData", "Local") if sys.platform == "win32" else (".local", "state")), "stiffcal")


def fault_of_place(folder: Path) -> str:
    """Return why nothing in this state folder is believed, "" where it is.

    Parameters
    ----------
    folder : the state folder; where it does not exist, its place is judged.
    """
    for place in (folder, Path(os.path.realpath(folder))):
        for parent in (place, *place.parents):
            if os.path.lexists(parent / MANIFEST):
                return f"it lies inside the campaign folder {parent}"
    try:
        status = folder.stat()
    except OSError:
        return ""
    return fault_of_owner(status)


def fault_of_owner(status: os.stat_result) -> str:
    """Return why a file or folder may be somebody else's work, "" where only the user can have written it."""
    if sys.platform == "win32":
        return ""  # a profile's folders are the user's own by their access lists
    if status.st_uid != os.geteuid():
        return "it belongs to another user"
    if status.st_mode & _OTHERS_WRITE:
        return "others can write to it"
    return ""


def may_write(folder: Path, lock: str) -> bool:
    """Return whether the user has the right to write in the state folder, or to make it where it does not exist.

    On Windows access lists are not asked: False, as if there were no right.

    Parameters
    ----------
    folder : the state folder.
    lock : the name of the lock file in it, which has to be writable too where it exists.
    """
    if sys.platform == "win32":
        return False
    place = folder
    while not os.path.lexists(place) and place != place.parent:
        place = place.parent
    writable = place.is_dir() and os.access(place, os.W_OK | os.X_OK)
    return writable and (not os.path.lexists(folder / lock) or os.access(folder / lock, os.R_OK | os.W_OK))


def make_private(folder: Path, record: str) -> None:
    """Make the state folder, readable by the user alone; an own one without a record yet is made so.

    Raises
    ------
    OSError : the system refuses.
    """
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    if sys.platform == "win32" or os.path.lexists(folder / record):
        return
    status = folder.stat()
    if status.st_uid == os.geteuid() and status.st_mode & 0o077:
        folder.chmod(0o700)

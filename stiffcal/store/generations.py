"""Which generation of a store holds, and the switch from one to the next."""

from __future__ import annotations

import os
import re
import shutil
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import try_lock
from stiffcal.plain_files import is_junction, is_plain_folder, is_refused, is_there, kind_of, open_inside
from stiffcal.store.index import INDEX, error_of_reading

CURRENT = "current"
CURRENT_ID = "current.id"
GENERATIONS = "generations"
LOCK = "lock"
SET_ASIDE = "set-aside"
_MOST_NAME = 100
_FLUSHED_ONE_BY_ONE = 100
_NAME = re.compile(r"\d{8}T\d{6}-[0-9a-f]{6}", re.ASCII)


def new_id() -> str:
    """Return a name for a generation: when it was begun (UTC), and chance against a clock that was set back."""
    import secrets  # brings much along that commands which only read do without

    return time.strftime("%Y%m%dT%H%M%S", time.gmtime()) + "-" + secrets.token_hex(3)


def is_generation_name(name: str) -> bool:
    """Return whether a text is a name that `new_id` gives; what is called otherwise is the user's, and left alone.

    Examples
    --------
    >>> is_generation_name("20261121T113400-3f9a1c"), is_generation_name(".."), is_generation_name("a/b")
    (True, False, False)
    """
    return _NAME.fullmatch(name) is not None


def current_folder(store: Path) -> Path | None:
    """Return the folder of the generation that holds, or None where none is named; it need not be there.

    Raises
    ------
    OSError : the system does not let the name be read.
    """
    named = _generation_in_file(store) or _generation_of_link(store)
    if named is not None:
        return store / GENERATIONS / named
    # A copy of a store that turned the link into what it pointed to.
    exists = is_plain_folder(store / CURRENT) and is_there(store / CURRENT / INDEX)
    return store / CURRENT if exists else None


def _generation_in_file(store: Path) -> str | None:
    """Return the current generation's name as the file states it; None where the file is missing or damaged."""
    try:
        with open_inside(store, CURRENT_ID) as file:
            name = file.read(_MOST_NAME + 2).decode("ascii").strip()  # with line end  # a name, and a line's end
    except UnicodeError:
        return None
    except OSError as error:
        if is_refused(error):
            raise
        return None
    return name if is_generation_name(name) else None


def _generation_of_link(store: Path) -> str | None:
    """Return the current generation's name as the link states it; None where there is no such link."""
    try:
        target = (store / CURRENT).readlink()
    except OSError as error:
        if is_refused(error):
            raise
        return None
    # A junction of Windows holds the whole path.
    return _generation_of_parts(target.parts if os.name != "nt" else target.parts[-2:])


def _generation_of_parts(parts: Sequence[str]) -> str | None:
    return parts[1] if len(parts) == 2 and parts[0] == GENERATIONS and is_generation_name(parts[1]) else None


def place_of(store: Path, folder: Path) -> str:
    """Return the path of a generation inside its store, as `open_inside` takes it."""
    return folder.relative_to(store).as_posix()


def all_generations(store: Path) -> list[Path]:
    """Return the folders of all generations, the newest first."""
    generations = store / GENERATIONS
    if not is_plain_folder(generations):
        return []
    folders = [path for path in generations.iterdir() if is_generation_name(path.name) and is_plain_folder(path)]
    return sorted(folders, key=lambda path: path.name, reverse=True)


def check_plain(store: Path, display_name: str) -> None:
    """Look at what a writer is about to write through: nothing of it may be a link that leads elsewhere.

    Raises
    ------
    InputError
        ``generations`` is no folder.
    """
    try:
        status = (store / GENERATIONS).lstat()
    except FileNotFoundError:
        return
    if not is_plain_folder(store / GENERATIONS):
        mend = f"remove it; stiffcal makes a folder {GENERATIONS} there"
        raise InputError.at(
            FaultCode.STORE_DAMAGED, display_name, GENERATIONS, f"this is {kind_of(status)}, not a plain folder", mend
        )


def switch(store: Path, generation: str) -> None:
    """Make `generation` the one that holds: one atomic step, before which all of it is on the disk."""
    link, by_id = store / CURRENT, store / CURRENT_ID
    is_free = _is_free(store)
    atomic_link = os.name != "nt" and is_free and (link.is_symlink() or not os.path.lexists(link))
    if by_id.exists() or not atomic_link:
        _replace_text(by_id, generation)
    target = Path(GENERATIONS, generation)
    try:
        if atomic_link:
            fresh = store / f".{CURRENT}-{generation}"
            fresh.symlink_to(target, target_is_directory=True)
            fresh.replace(link)
            by_id.unlink(missing_ok=True)
        elif is_free:
            _renew_link(store, target)
    except OSError:
        # No links on this file system: the file with the name is the switch.
        if not by_id.exists() or by_id.read_text("ascii") != generation:
            _replace_text(by_id, generation)
    # The new one holds now; a refusal to flush the link itself must not undo that.
    with suppress(OSError):
        flush_folder(store)


def _is_free(store: Path) -> bool:
    """Return whether the link may take its place: a link is there, a copy of a store, or nothing."""
    link = store / CURRENT
    if is_plain_folder(link):
        return is_there(link / INDEX)
    try:
        with open_inside(store, CURRENT) as file:
            # An archive without links keeps one as a file.
            parts = re.split(r"[/\\]", file.read(_MOST_NAME).decode("latin-1"))
    except OSError as error:
        return not is_refused(error)
    return _generation_of_parts(parts) is not None


def _renew_link(store: Path, target: Path) -> None:
    link = store / CURRENT
    if is_plain_folder(link):
        # A copied store: the generation that it holds has been carried over by now.
        shutil.rmtree(link)
    elif os.path.lexists(link):
        # A junction is removed like an empty folder.
        (link.rmdir if is_junction(link.lstat()) else link.unlink)()
    if sys.platform == "win32":
        import _winapi

        _winapi.CreateJunction(str((store / target).resolve()), str(link))
    else:
        link.symlink_to(target, target_is_directory=True)


def _replace_text(path: Path, text: str) -> None:
    fresh = path.with_name(f".{path.name}-{text}")
    with fresh.open("x", encoding="ascii") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    fresh.replace(path)


@contextmanager
def pinned(store: Path, folder: Path, display_name: str = "store") -> Iterator[bool]:
    """Hold a generation against removal while it is read; yields False where it was removed already.

    Raises
    ------
    UnreadableError : the system does not let its index be read; `display_name` is the store's name in the message.
    """
    try:
        file = open_inside(store, f"{place_of(store, folder)}/{INDEX}")
    except OSError as error:
        if is_refused(error):
            raise error_of_reading(error, display_name, INDEX) from None
        yield False
        return
    with file:
        yield try_lock(file.fileno(), shared=True) and (os.name == "nt" or os.fstat(file.fileno()).st_nlink > 0)


def has_others(store: Path, current: Path | None) -> bool:
    """Return whether something lies next to the current generation; False where none of ``generations`` is named."""
    generations = store / GENERATIONS
    if current is None or current.parent != generations or not is_plain_folder(generations):
        return False
    return any(is_generation_name(path.name) and path.name != current.name for path in generations.iterdir())


def remove_others(store: Path, keep: Path | None) -> None:
    """Remove all generations but one: older ones, and what killed writers left.

    Those that are being read stay for the next time, and what bears another name. Only for the holder of the writer's
    lock.
    """
    for leftover in store.glob(f".{CURRENT}*"):
        with suppress(OSError):
            leftover.unlink()
    generations = store / GENERATIONS
    if not is_plain_folder(generations):
        return
    for folder in sorted(path for path in generations.iterdir() if is_generation_name(path.name)):
        if keep is None or folder.name != keep.name or keep.parent != generations:
            with suppress(OSError):
                _remove(store, folder)


def _remove(store: Path, folder: Path) -> None:
    if not is_plain_folder(folder):
        # A link, or a file: it goes, what it leads to stays.
        folder.unlink()
        return
    try:
        file = open_inside(store, f"{place_of(store, folder)}/{INDEX}")
    except OSError:
        # Never finished, or half removed: nobody reads it.
        shutil.rmtree(folder)
        return
    with file:
        if not try_lock(file.fileno()):
            return
        if os.name != "nt":
            (folder / INDEX).unlink()
    shutil.rmtree(folder)


def flush_folders(top: Path) -> None:
    """Bring the lists of files of a folder and of all folders in it to the disk.

    Of thousands of folders, a few for each run, the whole file system is flushed at once where the system can: one
    after the other each waits for the disk, four milliseconds at a time.
    """
    folders = [top, *(Path(place, name) for place, names, _ in os.walk(top) for name in names)]
    if len(folders) > _FLUSHED_ONE_BY_ONE and _flush_file_system(top):
        return
    for folder in folders:
        flush_folder(folder)


def _flush_file_system(folder: Path) -> bool:
    if sys.platform != "linux":
        return False
    import ctypes

    try:
        flush = ctypes.CDLL(None, use_errno=True).syncfs
    except (OSError, AttributeError):  # another C library
        return False
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        return int(flush(descriptor)) == 0
    finally:
        os.close(descriptor)


def flush_folder(folder: Path) -> None:
    """Bring a folder's list of files to the disk, where the system can do that."""
    if os.name == "nt":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)

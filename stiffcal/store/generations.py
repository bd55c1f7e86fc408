"""Which generation of a store holds, and the switch from one to the next."""

from __future__ import annotations

import json
import os
import secrets
import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.parse import quote

from stiffcal.errors import InputError
from stiffcal.files import try_lock

SCHEMA = "stiffcal/store/1"
INDEX = "generation.json"
CURRENT = "current"
CURRENT_ID = "current.id"
GENERATIONS = "generations"
LOCK = "lock"


def new_id() -> str:
    """Return a name for a generation: when it was begun (UTC), and chance against a clock that was set back."""
    return time.strftime("%Y%m%dT%H%M%S", time.gmtime()) + "-" + secrets.token_hex(3)


def file_of(name: str, ending: str) -> str:
    """Return the path of a table or document inside its generation.

    Slashes make folders; what not every file system can hold is percent-encoded.

    Examples
    --------
    >>> file_of("recordings/pose 1?/ft", ".parquet")
    'recordings/pose 1%3F/ft.parquet'
    """
    parts = [quote(part, safe=" -_+=@#(),") for part in name.split("/")]
    # Names of dots alone would lead out of the folder.
    parts = [part.replace(".", "%2E") if not part.strip(".") else part for part in parts]
    if not all(parts):
        raise ValueError(f"no name for a table or document: {name!r}")
    return "/".join(parts) + ending


def plain_name(text: str) -> str:
    """Return the name of a generation as it was stored; what would lead elsewhere is the name of none."""
    name = text.strip()
    return name if name.strip(".") and not set("/\\:\0") & set(name) else "damaged"


def current_folder(store: Path) -> Path | None:
    """Return the folder of the generation that holds, or None where there is none."""
    with suppress(FileNotFoundError, NotADirectoryError, UnicodeError):
        return store / GENERATIONS / plain_name((store / CURRENT_ID).read_text("ascii"))
    link = store / CURRENT
    with suppress(OSError):
        return store / link.readlink()
    # A copy of a store that turned the link into what it pointed to.
    return link if (link / INDEX).is_file() else None


def switch(store: Path, generation: str) -> None:
    """Make `generation` the one that holds: one atomic step, before which all of it is on the disk."""
    link, by_id = store / CURRENT, store / CURRENT_ID
    atomic_link = os.name != "nt" and (link.is_symlink() or not link.exists())
    if by_id.exists() or not atomic_link:
        _replace_text(by_id, generation)
    target = Path(GENERATIONS, generation)
    try:
        if atomic_link:
            fresh = store / f".{CURRENT}-{generation}"
            fresh.symlink_to(target, target_is_directory=True)
            fresh.replace(link)
            by_id.unlink(missing_ok=True)
        else:
            _renew_link(store, target)
    except OSError:
        # No links on this file system: the file with the name is the switch.
        if not by_id.exists() or by_id.read_text("ascii") != generation:
            _replace_text(by_id, generation)
    # The new one holds now; a refusal to flush the link itself must not undo that.
    with suppress(OSError):
        flush_folder(store)


def _renew_link(store: Path, target: Path) -> None:
    link = store / CURRENT
    if link.is_symlink():
        link.unlink()
    elif link.exists():
        # A junction is removed like an empty folder; a true folder (a copied store) only after all that is in it.
        try:
            link.rmdir()
        except OSError:
            shutil.rmtree(link)
    if sys.platform == "win32":
        import _winapi

        _winapi.CreateJunction(str((store / target).resolve()), str(link))
    else:
        link.symlink_to(target, target_is_directory=True)


def _replace_text(path: Path, text: str) -> None:
    fresh = path.with_name(f".{path.name}-{text}")
    with fresh.open("w", encoding="ascii") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    fresh.replace(path)


@contextmanager
def held(folder: Path) -> Iterator[bool]:
    """Hold a generation against removal while it is read; yields False where it was removed already."""
    try:
        descriptor = os.open(folder / INDEX, os.O_RDONLY)
    except FileNotFoundError:
        yield False
        return
    try:
        yield try_lock(descriptor, shared=True) and (os.name == "nt" or os.fstat(descriptor).st_nlink > 0)
    finally:
        os.close(descriptor)


def remove_others(store: Path, keep: Path | None) -> None:
    """Remove all generations but one: older ones, and what killed writers left.

    Those that are being read stay for the next time. Only for the holder of the writer's lock.
    """
    for leftover in store.glob(f".{CURRENT}*"):
        with suppress(OSError):
            leftover.unlink()
    generations = store / GENERATIONS
    with suppress(FileNotFoundError):
        for folder in sorted(generations.iterdir()):
            if keep is None or folder.name != keep.name or keep.parent != generations:
                with suppress(OSError):
                    _remove(folder)


def _remove(folder: Path) -> None:
    try:
        descriptor = os.open(folder / INDEX, os.O_RDONLY)
    except OSError:
        # Never finished, or half removed: nobody reads it.
        shutil.rmtree(folder)
        return
    try:
        if not try_lock(descriptor):
            return
        if os.name != "nt":
            (folder / INDEX).unlink()
    finally:
        os.close(descriptor)
    shutil.rmtree(folder)


def read_index(folder: Path, shown: str) -> dict[str, dict[str, dict[str, object]]]:
    """Return what a generation holds.

    Raises
    ------
    InputError
        If the index is damaged or of another version of stiffcal.
    """
    try:
        index = json.loads((folder / INDEX).read_text("utf-8"))
        schema = index.get("schema")
    except (ValueError, AttributeError) as error:
        raise InputError.at(
            shown, INDEX, f"damaged ({error})", "delete the store and run ingest again (its history goes too)"
        ) from None
    if schema != SCHEMA:
        reason = f"schema {schema!r}, this version of stiffcal reads {SCHEMA!r}"
        raise InputError.at(shown, INDEX, reason, "delete the store and run ingest again (its history goes too)")
    return {"tables": index["tables"], "documents": index["documents"]}


def flush_folder(folder: Path) -> None:
    """Bring a folder's list of files to the disk, where the system can do that."""
    if os.name == "nt":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)

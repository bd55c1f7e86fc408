"""Which generation of a store is to be read, also where what names it is missing or leads elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.plain_files import is_refused, is_there, open_inside
from stiffcal.store.generations import CURRENT, all_generations, current_folder, place_of
from stiffcal.store.index import INDEX, DamagedStoreError, error_of_reading, file_of, read_index
from stiffcal.store.origin import verify
from stiffcal.trust.notices import notice

# How often a generation may be replaced between finding and opening it before that is taken for an error.
ATTEMPTS = 100


def find_generation(
    store: Path, display_name: str, named: Callable[[Path], Path | None] = current_folder
) -> Path | None:
    """Return the folder of the generation that is to be read, or None where there is none.

    Where none is named, or the named one is not there, the newest complete one, with a warning of one line.

    Raises
    ------
    NewerError : that one was written by a newer stiffcal.
    UnreadableError : the system does not let it be read; what cannot be read may be the current one.
    """
    try:
        folder = _named_generation(store, named)
        if folder is not None:
            return folder
        candidates = [folder for folder in all_generations(store) if is_there(folder / INDEX)]
    except OSError as error:
        raise error_of_reading(error, display_name, CURRENT) from None
    for folder in candidates:
        if is_whole(store, folder, display_name):
            notice(f"{store}: current refers to no existing generation: the newest complete one is used, {folder.name}")
            return folder
    return None


def _named_generation(store: Path, named: Callable[[Path], Path | None]) -> Path | None:
    before: Path | None = None
    for _ in range(ATTEMPTS):
        folder = named(store)
        if folder is not None and is_there(folder / INDEX):
            return folder
        if folder == before:
            break  # not replaced in between: it is not there
        before = folder
    return None


def is_whole(store: Path, folder: Path, display_name: str) -> bool:
    """Return whether all files of a generation are there and are what was written.

    Raises
    ------
    NewerError : it was written by a newer stiffcal.
    UnreadableError : the system does not let it be read.
    """
    place = place_of(store, folder)
    try:
        index = read_index(store, place, display_name)
        for kind, ending in (("tables", ".parquet"), ("documents", ".json")):
            for name, entry in index.of(kind).items():
                inside = file_of(name, ending)
                with open_inside(store, f"{place}/{inside}") as file:
                    verify(file, folder / inside, entry, display_name, name)
    except DamagedStoreError:
        return False
    except OSError as error:
        if is_refused(error):
            raise error_of_reading(error, display_name, place) from None
        return False
    return True


def nothing_stored(display_name: str) -> InputError:
    """Return the error of a store without anything in it."""
    return InputError.at(FaultCode.STORE_MISSING, display_name, "", "nothing is stored here yet", "run ingest first")

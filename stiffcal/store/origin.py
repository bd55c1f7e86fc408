"""From whom a generation comes: this user's own runs, a place that the user trusts, or anybody else.

What decides is the digest of the generation's index in the user's record of trust. Not its path: a store that was
copied, moved or restored is still the user's own. Nothing that lies in the store itself decides.
"""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterable
from pathlib import Path
from typing import IO

from stiffcal.documents import Document
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.store.index import FOREIGN, ORIGINS, OWN, REBUILD, TRUSTED_PLACE, DamagedStoreError, Entry, Index
from stiffcal.trust.record import CommittedGeneration, open_record

ENTRY_LISTS = {"history": "fits", "load_paths": "paths", "diagnoses": "entries"}
"""Documents that grow entry by entry: by name, the list they hold. Each entry keeps its origin."""

CHUNK = 1 << 20
_MOST_VERIFIED = 10_000
_verified: set[tuple[str, str, int, int, int]] = set()
_committed: list[str] = []


def origin_of_generation(index: Index, place: str) -> str:
    """Return the origin of a generation in a place, a folder's path or an address."""
    record = open_record()
    if record.generation(index.digest) is not None:
        return OWN
    return TRUSTED_PLACE if record.place_allowed(place) else FOREIGN


def origin_of_entry(recorded: str, generation: str, place: str) -> str:
    """Return the origin of a part of a generation: what its writer recorded counts only where the writer does."""
    if generation == FOREIGN or recorded == FOREIGN:
        return FOREIGN
    if recorded == TRUSTED_PLACE and generation == OWN:
        # Written over what others had written in a place that was trusted then.
        return TRUSTED_PLACE if open_record().place_allowed(place) else FOREIGN
    return generation


def worst_of(origins: Iterable[str]) -> str:
    """Return the origin of what is made from parts of several; of none, the user's own.

    Examples
    --------
    >>> worst_of(["own", "foreign", "trusted place"]), worst_of([])
    ('foreign', 'own')
    """
    return max(origins, key=ORIGINS.index, default=OWN)


def remember(digest: str, sources_state: str, *, required: bool = False) -> None:
    """Record that a run of this user has written the generation whose index has this digest.

    Parameters
    ----------
    digest : SHA-256 of the index.
    sources_state : of the sources that it was made from, "" where it is not known.
    required : as of `TrustRecord.remember_generation`, whose errors are raised.
    """
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    open_record().remember_generation(CommittedGeneration(digest, sources_state, now), required=required)
    _committed.append(digest)


def committed_by_this_process() -> tuple[str, ...]:
    """Return the digests of all generations that this process has recorded, in order."""
    return tuple(_committed)


def known_sources_state(digest: str) -> str:
    """Return the state that the sources had when they were hashed for an own generation, "" where it is not known."""
    known = open_record().generation(digest)
    return "" if known is None else known.sources_state


def with_origins(name: str, document: Document, entry: Entry, generation: str, place: str) -> Document:
    """Return a document that grows entry by entry, each entry with its origin where that is not the user.

    An entry cannot make itself the user's own: what it states of itself counts only in an own generation.
    """
    key = ENTRY_LISTS.get(name)
    if key is None or key not in document:
        return document
    marked = []
    for row in document[key]:
        if not isinstance(row, dict):
            continue
        listed_origin = row.get("origin", OWN)
        origin = worst_of(
            origin_of_entry(recorded if recorded in ORIGINS else FOREIGN, generation, place)
            for recorded in (listed_origin, entry.origin)
        )
        plain = {column: value for column, value in row.items() if column != "origin"}
        marked.append(plain if origin == OWN else {**plain, "origin": origin})
    return {**document, key: marked}


def check_entries(name: str, document: object) -> None:
    """Check that a document that grows entry by entry holds a list of them, or none yet.

    Raises
    ------
    ValueError : it holds something else.
    """
    key = ENTRY_LISTS.get(name)
    if key is not None and not (isinstance(document, dict) and isinstance(document.get(key, []), list)):
        raise ValueError(f"{key} is not a list")


def verify(file: IO[bytes], path: Path, entry: Entry, display_name: str, name: str) -> None:
    """Compare an open file with its entry in the index, once in a process; leaves it at its beginning.

    Raises
    ------
    DamagedError : it is not what was written.
    """
    status = os.fstat(file.fileno())
    if status.st_size != entry.bytes:
        raise damaged(display_name, name, f"{status.st_size} bytes, not {entry.bytes}")
    key = (str(path), entry.sha256, status.st_ino, status.st_size, status.st_ctime_ns)
    if not entry.sha256 or key in _verified:
        return
    found_hash = hash_of(file)
    file.seek(0)
    if found_hash != entry.sha256:
        raise damaged(display_name, name, "its content has changed since it was written")
    if len(_verified) >= _MOST_VERIFIED:
        _verified.clear()
    _verified.add(key)


def hash_of(file: IO[bytes]) -> str:
    """Return the SHA-256 of the rest of an open file."""
    digest = hashlib.sha256()
    while chunk := file.read(CHUNK):
        digest.update(chunk)
    return digest.hexdigest()


def damaged(display_name: str, name: str, why: str) -> InputError:
    """Return the error of a file that is not what was written."""
    return DamagedStoreError.at(FaultCode.STORE_DAMAGED, display_name, name, f"damaged ({why})", REBUILD)

"""The generation that a writer begins from: what of it is carried over, and from whom that comes."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.documents import Document
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.plain_files import is_plain_folder, is_refused, kind_of, open_inside
from stiffcal.store.generations import GENERATIONS, SET_ASIDE, all_generations, place_of
from stiffcal.store.index import (
    ENDINGS,
    FOREIGN,
    OWN,
    DamagedStoreError,
    Entry,
    Index,
    error_of_reading,
    file_of,
    parse_json,
    read_index,
)
from stiffcal.store.origin import ENTRY_LISTS, check_entries, hash_of, known_sources_state, with_origins
from stiffcal.store.snapshot import Snapshot
from stiffcal.trust.notices import notice

if TYPE_CHECKING:
    from stiffcal.store.store_place import StorePlace

_MOST_BYTES = 1 << 28
# Files up to this size are compared with their hash before they are carried over; larger ones when they are read.
_COMPARED_BYTES = 1 << 22


@dataclass
class PreviousGeneration:
    """The generation that held when a writer began; there may be none."""

    snapshot: Snapshot
    """What is known of it."""
    exists: bool
    """False where there was none."""
    _lost: str = ""

    @property
    def folder(self) -> Path:
        """Where its files lie."""
        return self.snapshot.folder

    @property
    def index(self) -> Index:
        """What it holds."""
        return self.snapshot.index

    @property
    def sources_state(self) -> str:
        """The state of its sources as this user's record holds it."""
        return known_sources_state(self.index.digest) if self.exists else ""

    def document(self, name: str, writing: str) -> Document | None:
        """Return a document, None where there is none that counts for what is written.

        Parameters
        ----------
        writing : the origin of what is written: next to what the user computes, a stranger's results do not count.
        """
        if name not in self.index.documents:
            return None
        if name in ENTRY_LISTS:
            return self._entries(name)
        if self.snapshot.origin_of(name) == FOREIGN != writing:
            return None
        try:
            return self.snapshot.read_document(name)
        except DamagedStoreError:
            return None

    def grown(self, kind: str, name: str) -> Document | None:
        """Return a document that grows entry by entry, to be written anew with origins; None where a copy will do."""
        if kind != "documents" or name not in ENTRY_LISTS:
            return None
        if self.snapshot.origin_of(name) == OWN and not self.snapshot.damaged([name]):
            return None
        return self._entries(name)

    def entry_to_keep(self, kind: str, name: str, writing: str) -> Entry | None:
        """Return the entry of the new index for a file that is carried over; None: it is not carried over.

        Parameters
        ----------
        writing : the origin of what is written.

        Raises
        ------
        UnreadableError : the system does not let the file be read; it may be sound, and is not to be lost.
        """
        entry = self.index.of(kind)[name]
        origin = self.snapshot.origin_of(name)
        if origin == FOREIGN != writing:
            return None
        if self.snapshot.remote is None and not self._is_sound(kind, name, entry):
            return None
        if not entry.sha256:
            entry = replace(entry, sha256=self._hash_of(kind, name))
        return replace(entry, origin=origin)

    def _is_sound(self, kind: str, name: str, entry: Entry) -> bool:
        if entry.bytes <= _COMPARED_BYTES:
            return name not in self.snapshot.damaged([name])
        try:
            with open_inside(self.snapshot.store, self._place(kind, name)) as file:
                return os.fstat(file.fileno()).st_size == entry.bytes
        except OSError as error:
            if is_refused(error):
                raise error_of_reading(error, self.snapshot.display_name, name) from None
            return False

    def _hash_of(self, kind: str, name: str) -> str:
        with open_inside(self.snapshot.store, self._place(kind, name)) as file:
            return hash_of(file)

    def _place(self, kind: str, name: str) -> str:
        return f"{place_of(self.snapshot.store, self.folder)}/{file_of(name, ENDINGS[kind])}"

    def _entries(self, name: str) -> Document | None:
        """Return a document that grows, as far as it can be read; what is not what was written is foreign."""
        with suppress(DamagedStoreError):
            return self.snapshot.read_document(name)
        try:
            with open_inside(self.snapshot.store, self._place("documents", name)) as file:
                document = parse_json(file.read(_MOST_BYTES))
            check_entries(name, document)
        except (OSError, ValueError) as error:
            if isinstance(error, OSError) and is_refused(error):
                raise error_of_reading(error, self.snapshot.display_name, name) from None
            self._lost = name
            self._make_place_aside()
            return None
        return with_origins(name, document, Entry(0), FOREIGN, self.snapshot.address)

    def set_others_aside(self) -> None:
        """Where nothing holds, keep what may hold a history: it is moved, not removed.

        Raises
        ------
        OSError : it cannot be moved. InputError : there is something else where it is to go.
        """
        if not self.exists:
            for folder in all_generations(self.snapshot.store):
                if os.path.lexists(folder / file_of("history", ".json")):
                    self._move(folder)

    def set_aside(self) -> bool:
        """Keep the generation where its history could not be read: it is moved, not removed; False: it could not be."""
        if self.exists and self._lost and self.folder.parent.name == GENERATIONS:
            try:
                self._move(self.folder)
            except (OSError, InputError) as error:
                notice(f"{self.folder}: a damaged part of the store, with its history, cannot be moved aside ({error})")
                return False
        return True

    def _make_place_aside(self) -> Path:
        """Return the folder for damaged generations, made where it is not there; a link would lead out of the store."""
        place, display_name = self.snapshot.store / SET_ASIDE, self.snapshot.display_name
        with suppress(FileExistsError):
            place.mkdir()
        status = place.lstat()
        if not is_plain_folder(place):
            mend = "remove it; stiffcal makes a folder of this name for a history that cannot be read"
            raise InputError.at(
                FaultCode.STORE_DAMAGED, display_name, SET_ASIDE, f"this is {kind_of(status)}, not a plain folder", mend
            )
        return place

    def _move(self, folder: Path) -> None:
        goal = self._make_place_aside() / folder.name
        folder.rename(goal)
        notice(f"{goal}: a damaged part of the store was moved here with its history")


def previous_generation(store: StorePlace, folder: Path | None) -> PreviousGeneration:
    """Return the current generation; of a damaged index, that there may be a history.

    Raises
    ------
    NewerError : it was written by a newer stiffcal.
    UnreadableError : the system does not let its index be read.
    """
    generations = folder or store.folder / GENERATIONS
    index = Index()
    if folder is not None:
        try:
            index = read_index(store.folder, place_of(store.folder, folder), store.display_name)
        except DamagedStoreError:
            documents = {name: Entry(0, origin=FOREIGN) for name in ENTRY_LISTS if _is_there(folder, name)}
            index = Index(documents=documents)
    snapshot = Snapshot(store.folder, generations, index, store.display_name, store.address, store.remote)
    return PreviousGeneration(snapshot, folder is not None)


def _is_there(folder: Path, name: str) -> bool:
    return os.path.lexists(folder / file_of(name, ENDINGS["documents"]))

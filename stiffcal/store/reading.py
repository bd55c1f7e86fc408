"""Reading a store: always one whole generation."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, cast

from stiffcal.documents import Document, Origin
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.plain_files import is_there
from stiffcal.store.finding import ATTEMPTS, find_generation, nothing_stored
from stiffcal.store.generations import LOCK, current_folder, has_others, pinned, place_of, remove_others
from stiffcal.store.index import INDEX, OWN, REBUILD, DamagedStoreError, read_index
from stiffcal.store.locking import writer_lock
from stiffcal.store.snapshot import Snapshot
from stiffcal.store.store_place import Documents, Stored, StorePlace
from stiffcal.store.writing import Writing, begin_writing
from stiffcal.trust.notices import notice

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.measurements.columns import Columns


class Store(StorePlace):
    """A campaign's store; parameters as of `StorePlace`."""

    def _current(self) -> Path | None:
        if self.remote is not None:
            self.remote.pull()
        # The name of the function is looked up here: it is replaced in tests.
        return find_generation(self.folder, self.display_name, current_folder)

    @property
    def exists(self) -> bool:
        """True where there is something to read."""
        return self._current() is not None

    @property
    def generation(self) -> str | None:
        """The name of the generation that holds now, or None."""
        folder = self._current()
        return None if folder is None else folder.name

    @contextmanager
    def snapshot(self) -> Iterator[Snapshot]:
        """Hold the generation that is current now, for several readings that have to agree.

        Raises
        ------
        InputError
            If there is nothing in the store yet, it is damaged, or was written by a newer stiffcal.
        """
        for _ in range(ATTEMPTS):
            folder = self._current()
            if folder is None:
                raise nothing_stored(self.display_name)
            with pinned(self.folder, folder, self.display_name) as still_there:
                if still_there:
                    index = read_index(self.folder, place_of(self.folder, folder), self.display_name)
                    snapshot = Snapshot(
                        self.folder, folder, index, self.display_name, self.address, self.remote, self.declared
                    )
                    if snapshot.origin != OWN and snapshot.tables:
                        from stiffcal.bounded_work.client import CHILDREN

                        CHILDREN.start_early()
                    yield snapshot
                    return
        raise DamagedStoreError.at(
            FaultCode.STORE_DAMAGED,
            self.display_name,
            "current",
            "the generation to which it refers cannot be read",
            REBUILD,
        )

    @property
    def tables(self) -> tuple[str, ...]:
        """The names of all tables; empty where nothing is stored, or what is stored cannot be read."""
        with self._readable() as snapshot:
            return () if snapshot is None else snapshot.tables

    @property
    def documents(self) -> tuple[str, ...]:
        """The names of all documents; empty where nothing is stored, or what is stored cannot be read."""
        with self._readable() as snapshot:
            return () if snapshot is None else snapshot.documents

    def origin_of(self, *names: str) -> Origin:
        """Return from whom tables or documents come, the worst of them: "own", "trusted place" or "foreign"."""
        with self._readable() as snapshot:
            return cast(Origin, OWN if snapshot is None else snapshot.origin_of(*names))

    @contextmanager
    def _readable(self) -> Iterator[Snapshot | None]:
        if not self.exists:
            yield None
            return
        with ExitStack() as stack:
            try:
                snapshot = stack.enter_context(self.snapshot())
            except DamagedStoreError as error:
                notice(f"{error}")
                snapshot = None
            yield snapshot

    def remove_leftovers(self) -> None:
        """Remove what an earlier command has left next to the current generation: it was killed, or had no right to.

        For a command that has read the current generation. Where somebody writes just now, or this command has not the
        right to either, it stays for the next one.
        """
        if self.remote is not None:
            return
        with suppress(OSError, InputError):
            if not has_others(self.folder, current_folder(self.folder)):
                return
            with writer_lock(self.folder / LOCK, "remove leftovers", 0.0, self.display_name):
                # Nobody else switches now; it may have been done since.
                current = current_folder(self.folder)
                if current is not None and is_there(current / INDEX):
                    remove_others(self.folder, current)

    def read_table(self, name: str, columns: Sequence[str] | None = None) -> pa.Table:
        """Return a table of the current generation."""
        with self.snapshot() as snapshot:
            return snapshot.read_table(name, columns)

    def read_document(self, name: str) -> Document:
        """Return a document of the current generation."""
        with self.snapshot() as snapshot:
            return snapshot.read_document(name)

    def begin(self, command: str = "stiffcal", wait_s: float = 20.0) -> AbstractContextManager[Writing]:
        """Begin a new generation; what is written counts only after `Writing.commit`.

        Parameters
        ----------
        command : what is writing, for another writer that has to wait.
        wait_s : how long to wait for another writer before giving up.

        Examples
        --------
        >>> import tempfile, numpy
        >>> store = Store(tempfile.mkdtemp() + "/store")
        >>> with store.begin("ingest") as writing:
        ...     writing.write_table("states", {"run": ["a", "b"], "Fx": numpy.array([0.0, 50.0])})
        ...     writing.write_document("provenance", {"schema": "example"})
        ...     writing.commit()
        >>> store.read_table("states").num_rows
        2
        """
        return begin_writing(self, command, wait_s)

    def commit(
        self,
        tables: Mapping[str, pa.Table | Columns] | None = None,
        documents: Documents | Callable[[Stored], Documents] | None = None,
        keep_rest: bool = True,
        command: str = "stiffcal",
        origin: str = OWN,
    ) -> None:
        """Write tables and documents in one step; with `keep_rest` all else stays as it is, otherwise it goes.

        Parameters
        ----------
        documents : by name; or a function that makes them from those stored now (`stored(name)`, None where there is
            none). It is called when nobody else can write: what is appended to a history that two write is not lost.
        origin : from whom that comes from which these are made.
        """
        with self.begin(command) as writing:
            writing.origin = origin
            writing.write_all(tables, documents)
            if keep_rest:
                writing.keep_rest()
            writing.commit()

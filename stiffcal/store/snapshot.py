"""One generation of a store, held while it is read: each file is compared with its hash when it is first read."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from stiffcal.documents import Document
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import DOCUMENT
from stiffcal.plain_files import is_refused, open_inside
from stiffcal.store.generations import place_of
from stiffcal.store.index import OWN, DamagedStoreError, Entry, Index, error_of_reading, file_of, parse_json
from stiffcal.store.origin import (
    check_entries,
    damaged,
    origin_of_entry,
    origin_of_generation,
    verify,
    with_origins,
    worst_of,
)

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as parquet

    from stiffcal.store.declared_table import Declared
    from stiffcal.store.remote import Remote

BATCH_ROWS = 1 << 16
COMPARED_WHEN_READ = ("recordings/", "read/logs/")
"""Tables of single logs, by the beginnings of their names: there may be many gigabytes of them, and no command but the
one that reads such a table compares it with its hash."""
# A file up to this size is held in memory while it is read; a larger one is read from the disk twice.
_HELD_BYTES = 1 << 24


@dataclass(frozen=True)
class Snapshot:
    """One generation of a store, held while it is read."""

    store: Path
    """The store's folder."""
    folder: Path
    """Where the generation's files lie."""
    index: Index
    """What it holds."""
    display_name: str
    """The store's name in messages."""
    address: str
    """The store's place, as the user allows places: a path, or an address in an object store."""
    remote: Remote | None = None
    """The object store from which files are fetched when they are first read, or None."""
    declared: Declared | None = None
    """Finds what a table of its name is to hold; None: tables are read as they are."""

    @property
    def tables(self) -> tuple[str, ...]:
        """The names of all tables."""
        return tuple(self.index.tables)

    @property
    def documents(self) -> tuple[str, ...]:
        """The names of all documents."""
        return tuple(self.index.documents)

    @cached_property
    def origin(self) -> str:
        """From whom the generation comes: "own", "trusted place" or "foreign"."""
        return origin_of_generation(self.index, self.address)

    def origin_of(self, *names: str) -> str:
        """Return from whom tables or documents come, the worst of them; own where there are none of these names."""
        return worst_of(
            origin_of_entry(entries[name].origin, self.origin, self.address)
            for entries in (self.index.tables, self.index.documents)
            for name in names
            if name in entries
        )

    def read_table(self, name: str, columns: Sequence[str] | None = None) -> pa.Table:
        """Return a table, or some of its columns.

        Raises
        ------
        InputError
            If there is no such table, its file is damaged, or it holds something else than is declared.
        """
        import pyarrow as pa

        if self.origin_of(name) != OWN:
            table = pa.Table.from_batches(list(self._read_elsewhere(name, columns, BATCH_ROWS)))
        else:
            with self._opened(name) as file:
                table = file.read(columns=None if columns is None else list(columns), use_threads=False)
        declared = None if self.declared is None else self.declared(name)
        difference = "" if declared is None else declared.difference(table.schema, columns)
        if difference:
            raise damaged(self.display_name, name, difference)
        return table

    def read_batches(
        self, name: str, columns: Sequence[str] | None = None, rows: int = BATCH_ROWS
    ) -> Iterator[pa.RecordBatch]:
        """Yield a table in pieces of at most `rows` rows."""
        if self.origin_of(name) != OWN:
            yield from self._read_elsewhere(name, columns, rows)
            return
        with self._opened(name) as file:
            chosen = None if columns is None else list(columns)
            yield from file.iter_batches(batch_size=rows, columns=chosen, use_threads=False)

    def read_document(self, name: str) -> Document:
        """Return a document; raises `InputError` where there is none or it is damaged.

        Of one that grows entry by entry each entry has its ``origin``, where that is not the user.
        """
        if name not in self.documents:
            raise InputError.at(
                FaultCode.STORE_MISSING,
                self.display_name,
                name,
                "no such document",
                "run the command that makes it first",
            )
        entry = self.index.documents[name]
        DOCUMENT.check(entry.bytes, self.display_name, name)
        try:
            with self._verified(name, ".json", entry) as file:
                content = file.read()
            # What this user's own runs have written needs no second look.
            document = json.loads(content) if self.origin == OWN else parse_json(content)
            check_entries(name, document)
        except ValueError as error:
            raise damaged(self.display_name, name, str(error)) from None
        return with_origins(name, document, entry, self.origin, self.address)

    def damaged(self, names: Iterable[str] | None = None, thorough: bool = False) -> dict[str, str]:
        """Return the names of tables and documents that are not what was written, each with the reason.

        Parameters
        ----------
        names : which to look at; None: all.
        thorough : False: of tables of single logs (`COMPARED_WHEN_READ`) only the sizes are compared.
        """
        reasons = {}
        for entries, ending in ((self.index.tables, ".parquet"), (self.index.documents, ".json")):
            for name in entries if names is None else [name for name in names if name in entries]:
                if name.startswith(COMPARED_WHEN_READ) and not thorough:
                    if not self.is_there(name):
                        reasons[name] = f"not there, or not of {entries[name].bytes} bytes"
                    continue
                try:
                    with self._verified(name, ending, entries[name]):
                        pass
                except DamagedStoreError as error:
                    reasons[name] = error.faults[0].reason
        return reasons

    def is_there(self, name: str) -> bool:
        """Return whether the file of a table is there in its size; of an object store, whether the index names it."""
        entry = self.index.tables.get(name)
        if entry is None or self.remote is not None:
            return entry is not None
        try:
            status = os.lstat(f"{self.folder}/{file_of(name, '.parquet')}")
        except FileNotFoundError:
            return False
        except OSError as error:
            if is_refused(error):
                raise error_of_reading(error, self.display_name, name) from None
            return False
        return stat.S_ISREG(status.st_mode) and status.st_size == entry.bytes

    @contextmanager
    def _verified(self, name: str, ending: str, entry: Entry) -> Iterator[IO[bytes]]:
        path = self.folder / file_of(name, ending)
        if self.remote is not None:
            with self.remote.faults():
                self.remote.fetch(path, entry.bytes)
        try:
            file = open_inside(self.store, f"{place_of(self.store, self.folder)}/{file_of(name, ending)}")
        except OSError as error:
            raise error_of_reading(error, self.display_name, name) from None
        with file:
            try:
                verify(file, path, entry, self.display_name, name)
            except DamagedStoreError as error:
                if not name.startswith(COMPARED_WHEN_READ):
                    raise
                # No command compares these but the one that reads them: without the file, ingest makes it anew.
                mend = f"remove {path} and run stiffcal ingest again"
                raise DamagedStoreError.at(
                    FaultCode.STORE_DAMAGED, self.display_name, name, error.faults[0].reason, mend
                ) from None
            yield file

    def _entry_of(self, name: str) -> Entry:
        if name not in self.tables:
            raise InputError.at(
                FaultCode.STORE_MISSING, self.display_name, name, "no such table", "run the command that makes it first"
            )
        return self.index.tables[name]

    def _read_elsewhere(self, name: str, columns: Sequence[str] | None, rows: int) -> Iterator[pa.RecordBatch]:
        """Yield a table that this user's runs have not written: the library reads it in a child process."""
        import pyarrow as pa

        from stiffcal.bounded_work.parquet_tables import read_parquet

        entry = self._entry_of(name)
        with self._verified(name, ".parquet", entry):
            pass
        inside = f"{place_of(self.store, self.folder)}/{file_of(name, '.parquet')}"
        try:
            yield from read_parquet(self.store, inside, entry.bytes, columns, rows, self.display_name, name)
        except (InputError, pa.ArrowException) as error:
            if isinstance(error, InputError) and error.code != FaultCode.FILE_DAMAGED:
                raise
            reason = error.faults[0].reason if isinstance(error, InputError) else str(error).splitlines()[0]
            raise damaged(self.display_name, name, reason) from None

    @contextmanager
    def _opened(self, name: str) -> Iterator[parquet.ParquetFile]:
        import pyarrow as pa
        import pyarrow.parquet as parquet

        entry = self._entry_of(name)
        try:
            with (
                self._verified(name, ".parquet", entry) as file,
                _source_of(file, entry.bytes) as source,
                parquet.ParquetFile(source, page_checksum_verification=True) as table,
            ):
                yield table
        except (OSError, pa.ArrowException) as error:
            if isinstance(error, OSError) and is_refused(error):
                raise error_of_reading(error, self.display_name, name) from None
            raise damaged(self.display_name, name, (str(error).splitlines() or [type(error).__name__])[0]) from None


@contextmanager
def _source_of(file: IO[bytes], size: int) -> Iterator[Any]:
    import pyarrow as pa

    yield pa.BufferReader(file.read()) if size <= _HELD_BYTES else pa.PythonFile(file, mode="r")

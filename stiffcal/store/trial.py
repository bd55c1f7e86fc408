"""A store that is read as it stands, and written in memory alone: for models that are tried."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

from stiffcal.documents import Document
from stiffcal.measurements.columns import Columns, table_of
from stiffcal.store.index import OWN
from stiffcal.store.origin import worst_of
from stiffcal.store.reading import Store
from stiffcal.store.snapshot import Snapshot
from stiffcal.store.store_place import Documents, Stored

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True)
class TrialResults:
    """What was computed with a model that is tried."""

    tables: dict[str, pa.Table] = field(default_factory=dict)
    """By name; each stands in place of the store's."""
    documents: dict[str, str] = field(default_factory=dict)
    """JSON by name, as a store would hold it."""
    origins: dict[str, str] = field(default_factory=dict)
    """From whom each of them comes."""

    def document(self, name: str) -> Document | None:
        """Return a document of the trial's own; None where it made none."""
        if name not in self.documents:
            return None
        document: Document = json.loads(self.documents[name])
        return document


@dataclass(frozen=True)
class TrialSnapshot(Snapshot):
    """A generation of a store with the results of a trial in place of its own."""

    results: TrialResults = field(default_factory=TrialResults)
    """Of the trial."""

    @property
    def tables(self) -> tuple[str, ...]:
        """The names of all tables."""
        return tuple(dict.fromkeys((*super().tables, *self.results.tables)))

    @property
    def documents(self) -> tuple[str, ...]:
        """The names of all documents."""
        return tuple(dict.fromkeys((*super().documents, *self.results.documents)))

    def origin_of(self, *names: str) -> str:
        """Return from whom tables or documents come, the worst of them."""
        tried = [self.results.origins[name] for name in names if name in self.results.origins]
        stored = [name for name in names if name not in self.results.origins]
        return worst_of([*tried, *([super().origin_of(*stored)] if stored else [])])

    def read_table(self, name: str, columns: Sequence[str] | None = None) -> pa.Table:
        """Return a table, or some of its columns."""
        if name not in self.results.tables:
            return super().read_table(name, columns)
        table = self.results.tables[name]
        return table if columns is None else table.select(list(columns))

    def read_document(self, name: str) -> Document:
        """Return a document."""
        own = self.results.document(name)
        return super().read_document(name) if own is None else own


class NoRecording:
    """Takes the place of `TableStream`: recordings of logs, which may be large, are those of the store beneath."""

    def append(self, columns: Columns | pa.RecordBatch) -> None:
        """Let rows pass."""

    def close(self) -> None:
        """Do nothing."""


class TrialWriting:
    """Takes the place of `Writing`: what is committed is kept in memory, and nothing on the disk changes."""

    def __init__(self, store: TrialStore) -> None:
        self.origin = OWN
        self.sources_state: str | None = None
        self.needed: Callable[[str], bool] = lambda name: False
        self._store = store
        self._made = TrialResults()

    def write_all(
        self,
        tables: Mapping[str, pa.Table | Columns] | None,
        documents: Documents | Callable[[Stored], Documents] | None,
    ) -> None:
        """Take tables and documents by name; a function makes the documents from those that stand there."""
        new_documents = documents(self._stored) if callable(documents) else documents
        for name, table in (tables or {}).items():
            self.write_table(name, table)
        for name, document in (new_documents or {}).items():
            self.write_document(name, document)

    def write_table(self, name: str, table: pa.Table | Columns) -> None:
        """Take a table, or columns that are to become one."""
        import pyarrow as pa

        self._made.tables[name] = table if isinstance(table, pa.Table) else table_of(table)

    def stream(self, name: str, schema: pa.Schema | Sequence[str]) -> NoRecording:
        """Begin a recording, which is not kept."""
        return NoRecording()

    def write_document(self, name: str, document: Mapping[str, Any]) -> None:
        """Take a document of JSON values."""
        self._made.documents[name] = json.dumps(document)

    def keep(self, *names: str) -> None:
        """Do nothing: all else stands as it is."""

    def keep_rest(self) -> None:
        """Do nothing: all else stands as it is."""

    def commit(self) -> None:
        """Let what was taken count."""
        results = self._store.results
        results.tables.update(self._made.tables)
        results.documents.update(self._made.documents)
        results.origins.update(dict.fromkeys((*self._made.tables, *self._made.documents), self.origin))

    def _stored(self, name: str) -> Document | None:
        return self._store.read_document(name) if name in self._store.documents else None


class TrialStore(Store):
    """A store with the results of a trial over it.

    Parameters
    ----------
    store : what is read; it is never written.
    results : of the trial, which grow.
    """

    def __init__(self, store: Store, results: TrialResults) -> None:
        self.display_name, self.remote, self.folder = store.display_name, store.remote, store.folder
        self.declared = store.declared
        self.results = results

    @contextmanager
    def snapshot(self) -> Iterator[Snapshot]:
        """Hold the store's generation, with the trial's results in place of its own."""
        with super().snapshot() as snapshot:
            entries = {entry.name: getattr(snapshot, entry.name) for entry in fields(snapshot)}
            yield TrialSnapshot(**entries, results=self.results)

    @contextmanager
    def begin(self, command: str = "stiffcal", wait_s: float = 20.0) -> Iterator[Any]:
        """Begin a generation in memory."""
        yield TrialWriting(self)

"""Writing a store: a new generation next to the old one, made the current one by `Writing.commit`."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiffcal.documents import Document
from stiffcal.store.finding import find_generation
from stiffcal.store.generations import (
    GENERATIONS,
    LOCK,
    check_plain,
    current_folder,
    flush_folder,
    flush_folders,
    new_id,
    remove_others,
    switch,
)
from stiffcal.store.index import ENDINGS, INDEX, OWN, SCHEMA, Entry, file_of
from stiffcal.store.locking import writer_lock
from stiffcal.store.origin import damaged, remember
from stiffcal.store.previous import PreviousGeneration, previous_generation
from stiffcal.store.table_stream import ROW_GROUP, TableStream, store_faults

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.measurements.columns import Columns
    from stiffcal.store.remote import Ticket
    from stiffcal.store.store_place import Documents, Stored, StorePlace


class Writing:
    """A generation that is being written. Made by `Store.begin`; counts after `commit`.

    Attributes
    ----------
    folder : where its files lie.
    committed : True after `commit`.
    sources_state : of the sources that it was made from, for the user's record; None: as of the old generation.
    origin : from whom that comes from which the new parts are made; to be set before they are written.
    needed : whether something of a name must not be left out by `keep_rest` where it is damaged.
    """

    def __init__(self, store: StorePlace, command: str, old: PreviousGeneration, ticket: Ticket | None) -> None:
        self.committed = False
        self.sources_state: str | None = None
        self.origin = OWN
        self.needed: Callable[[str], bool] = _nothing
        self._remote, self._ticket = store.remote, ticket
        self._kept: dict[str, tuple[str, int]] = {}
        self._store = store.folder
        self._display_name = store.display_name
        self._command = command
        self._streams: dict[str, TableStream] = {}
        self._index: dict[str, dict[str, Entry]] = {kind: {} for kind in ENDINGS}
        self._declared = store.declared
        self._old = old
        self._id = new_id()
        self.folder = store.folder / GENERATIONS / self._id
        self.folder.mkdir(parents=True)

    def write_table(self, name: str, table: pa.Table | Columns) -> None:
        """Write a table, or columns that are to become one, as it is declared."""
        import pyarrow as pa

        if not isinstance(table, pa.Table):
            from stiffcal.measurements.columns import table_of

            table = table_of(table)
        declared = None if self._declared is None else self._declared(name)
        if declared is not None:
            table = declared.cast(table)
        stream = self.stream(name, table.schema)
        for batch in table.to_batches(max_chunksize=ROW_GROUP):
            stream.append(batch)
        stream.close()

    def stream(self, name: str, schema: pa.Schema | Sequence[str]) -> TableStream:
        """Begin a table that is written in pieces; `schema` may be its columns' names, float64 where not declared."""
        import pyarrow as pa

        self._check_new("tables", name)
        if not isinstance(schema, pa.Schema):
            declared = None if self._declared is None else self._declared(name)
            floats = [(column, pa.float64()) for column in schema]
            schema = pa.schema(floats) if declared is None else declared.schema_of(schema)
        path = self.folder / file_of(name, ENDINGS["tables"])
        self._streams[name] = stream = TableStream(path, schema, self._display_name)
        self._index["tables"][name] = replace(stream.entry, origin=self.origin)
        return stream

    def write_document(self, name: str, document: Mapping[str, Any]) -> None:
        """Write a document of JSON values (finite numbers, None for what is not known)."""
        self._check_new("documents", name)
        text = json.dumps(document, ensure_ascii=False, allow_nan=False, default=_plain)
        with store_faults(self._display_name):
            path = self.folder / file_of(name, ENDINGS["documents"])
            path.parent.mkdir(parents=True, exist_ok=True)
            content = _write_flushed(path, text)
        digest = hashlib.sha256(content).hexdigest()
        self._index["documents"][name] = Entry(len(content), sha256=digest, origin=self.origin)

    def stored(self, name: str) -> Document | None:
        """Return a document of the old generation, None where there is none that counts next to what is written."""
        return self._old.document(name, self.origin)

    def keep(self, *names: str) -> None:
        """Carry tables or documents of these names over from the old generation, unchanged.

        What somebody else has written is not carried into what the user's own run writes, but for documents that grow
        entry by entry: there each entry keeps its origin.

        Raises
        ------
        KeyError
            If the old generation has none of that name.
        """
        for name in names:
            kinds = [kind for kind in ENDINGS if name in self._old.index.of(kind)]
            if not kinds:
                raise KeyError(name)
            for kind in kinds:
                self._carry_over(kind, name)

    def write_all(
        self,
        tables: Mapping[str, pa.Table | Columns] | None,
        documents: Documents | Callable[[Stored], Documents] | None,
    ) -> None:
        """Write tables and documents by name; a function makes the documents from those of the old generation."""
        new_documents = documents(self.stored) if callable(documents) else documents
        for name, table in (tables or {}).items():
            self.write_table(name, table)
        for name, document in (new_documents or {}).items():
            self.write_document(name, document)

    def keep_rest(self) -> None:
        """Carry over all that the old generation holds and that is not written anew (so far).

        What is damaged is left out.

        Raises
        ------
        DamagedError : it is needed, by `needed`.
        UnreadableError : the system does not let something be read.
        """
        for kind in ENDINGS:
            for name in self._old.index.of(kind):
                if name not in self._index[kind]:
                    self._carry_over(kind, name)
                    if name not in self._index[kind] and self.needed(name):
                        raise damaged(self._display_name, name, "it has changed since this command began")

    def _carry_over(self, kind: str, name: str) -> None:
        self._check_new(kind, name)
        grown = self._old.grown(kind, name)
        if grown is not None:
            self.write_document(name, grown)
            return
        entry = self._old.entry_to_keep(kind, name, self.origin)
        if entry is None:
            return
        file = file_of(name, ENDINGS[kind])
        if self._remote is not None:
            self._kept[file] = (self._old.folder.name, entry.bytes)
        else:
            source, target = self._old.folder / file, self.folder / file
            with store_faults(self._display_name):
                target.parent.mkdir(parents=True, exist_ok=True)
                try:
                    os.link(source, target)
                except OSError:
                    # No hard links here.
                    shutil.copyfile(source, target)
                    _flush_file(target)
        self._index[kind][name] = entry

    def _check_new(self, kind: str, name: str) -> None:
        if self.committed:
            raise ValueError("this generation is committed already")
        if name in self._index[kind]:
            raise ValueError(f"{name!r} is written already")

    def commit(self) -> None:
        """Finish all tables, bring everything to the disk and make this generation the current one.

        Raises
        ------
        InputError
            If the disk is full or may not be written to, or the user's record of trust cannot be written any more; the
            old generation then still holds.
        """
        if self.committed:
            raise ValueError("this generation is committed already")
        for name, stream in self._streams.items():
            stream.close()
            self._index["tables"][name] = replace(stream.entry, origin=self.origin)
        content = self._index_text().encode()
        with store_faults(self._display_name):
            _write_flushed(self.folder / INDEX, content.decode())
            flush_folders(self.folder)
            flush_folder(self._store / GENERATIONS)
        # Before the switch: one that holds and is not recorded would be nobody's.
        state = self._old.sources_state if self.sources_state is None else self.sources_state
        remember(hashlib.sha256(content).hexdigest(), state, required=True)
        if self._remote is not None and self._ticket is not None:
            with self._remote.faults():
                began_from = self._old.folder.name if self._old.exists else None
                self._remote.publish(self.folder, self._kept, began_from, self._ticket)
        with store_faults(self._display_name):
            switch(self._store, self._id)
        self.committed = True

    def _index_text(self) -> str:
        created = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        listed = {
            kind: {name: entry.as_document(file_of(name, ENDINGS[kind])) for name, entry in entries.items()}
            for kind, entries in self._index.items()
        }
        index = {"schema": SCHEMA, "id": self._id, "created": created, "command": self._command, **listed}
        return json.dumps(index, ensure_ascii=False)

    def abandon(self) -> None:
        """Remove what was written, unless it holds already (an interruption just after the switch)."""
        for stream in self._streams.values():
            stream.abandon()
        try:
            if current_folder(self._store) == self.folder:
                return
        except OSError:
            return  # it may hold: a later writer removes it where it does not
        if self._remote is not None:
            self._remote.withdraw(self.folder)
        shutil.rmtree(self.folder, ignore_errors=True)


@contextmanager
def begin_writing(store: StorePlace, command: str, wait_s: float) -> Iterator[Writing]:
    """Hold the writer's lock and a new generation; without a commit nothing of it remains."""
    with ExitStack() as stack:
        with store_faults(store.display_name):
            store.folder.mkdir(parents=True, exist_ok=True)
            stack.enter_context(writer_lock(store.folder / LOCK, command, wait_s, store.display_name))
            check_plain(store.folder, store.display_name)
        ticket = None
        if store.remote is not None:
            from stiffcal.store.remote import remote_lock

            ticket = stack.enter_context(remote_lock(store.remote, command, wait_s))
            store.remote.pull()
        old = previous_generation(store, find_generation(store.folder, store.display_name))
        with store_faults(store.display_name):
            old.set_others_aside()
            remove_others(store.folder, old.folder if old.exists else None)
            writing = Writing(store, command, old, ticket)
        try:
            yield writing
        finally:
            if writing.committed:
                if old.set_aside():
                    remove_others(store.folder, writing.folder)
            else:
                writing.abandon()


def _nothing(name: str) -> bool:
    return False


def _write_flushed(path: Path, text: str) -> bytes:
    content = text.encode()
    with path.open("xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    return content


def _flush_file(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def _plain(value: object) -> object:
    """Return numpy's values as JSON's."""
    import numpy as np

    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not a JSON value")

"""Reading a store: always one whole generation."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias
from urllib.parse import unquote, urlsplit

import pyarrow as pa
import pyarrow.parquet as parquet

from stiffcal.errors import InputError
from stiffcal.measurements.columns import Columns
from stiffcal.store.generations import current_folder, file_of, held, read_index
from stiffcal.store.writing import Writing, begin_writing

if TYPE_CHECKING:
    from stiffcal.store.remote import Remote

Documents: TypeAlias = Mapping[str, Mapping[str, Any]]
Stored: TypeAlias = Callable[[str], dict[str, Any] | None]

BATCH_ROWS = 1 << 16
# How often a generation may be replaced between finding and opening it before that is taken for an error.
ATTEMPTS = 100
REBUILD = "delete the store and run ingest again (its history goes too)"


@dataclass(frozen=True)
class Snapshot:
    """One generation of a store, held while it is read.

    Attributes
    ----------
    folder : where its files lie.
    tables, documents : the names of what it holds.
    shown : the store's name in messages.
    remote : the object store from which files are fetched when they are first read, or None.
    """

    folder: Path
    tables: tuple[str, ...]
    documents: tuple[str, ...]
    shown: str
    remote: Remote | None = None

    def read_table(self, name: str, columns: Sequence[str] | None = None) -> pa.Table:
        """Return a table, or some of its columns.

        Raises
        ------
        InputError
            If there is no such table, or its file is damaged.
        """
        with self._opened(name) as file:
            return file.read(columns=None if columns is None else list(columns), use_threads=False)

    def read_batches(
        self, name: str, columns: Sequence[str] | None = None, rows: int = BATCH_ROWS
    ) -> Iterator[pa.RecordBatch]:
        """Yield a table in pieces of at most `rows` rows."""
        with self._opened(name) as file:
            chosen = None if columns is None else list(columns)
            yield from file.iter_batches(batch_size=rows, columns=chosen, use_threads=False)

    def read_document(self, name: str) -> dict[str, Any]:
        """Return a document; raises `InputError` where there is none or it is damaged."""
        if name not in self.documents:
            raise InputError.at(self.shown, name, "no such document", "run the command that makes it first")
        try:
            return dict(json.loads(self._here(file_of(name, ".json")).read_text("utf-8")))
        except (OSError, ValueError) as error:
            raise InputError.at(self.shown, name, f"damaged ({error})", REBUILD) from None

    def path_of_table(self, name: str) -> Path:
        """Return the Parquet file of a table."""
        return self._here(file_of(name, ".parquet"))

    def _here(self, file: str) -> Path:
        path = self.folder / file
        if self.remote is not None:
            with self.remote.faults():
                self.remote.fetch(path)
        return path

    @contextmanager
    def _opened(self, name: str) -> Iterator[parquet.ParquetFile]:
        if name not in self.tables:
            raise InputError.at(self.shown, name, "no such table", "run the command that makes it first")
        try:
            with parquet.ParquetFile(self.path_of_table(name), page_checksum_verification=True) as file:
                yield file
        except (OSError, pa.ArrowException) as error:
            reason = f"damaged ({str(error).splitlines()[0]})"
            raise InputError.at(self.shown, name, reason, REBUILD) from None


class Store:
    """A campaign's store.

    Parameters
    ----------
    location : its folder (or a ``file:`` address), or its place in an object store, ``s3://bucket/prefix``; it need
        not exist.
    shown : its name in messages; default: the location.
    """

    def __init__(self, location: str | Path, shown: str = "") -> None:
        self.shown = shown or str(location)
        self.remote = _remote_of(location, self.shown)
        self.folder = self.remote.mirror if self.remote is not None else _folder_of(location, self.shown)

    def _current(self) -> Path | None:
        if self.remote is not None:
            self.remote.pull()
        return current_folder(self.folder)

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
            If there is nothing in the store yet, or it is damaged.
        """
        for _ in range(ATTEMPTS):
            folder = self._current()
            if folder is None:
                raise InputError.at(self.shown, "", "nothing is stored here yet", "run ingest first")
            with held(folder) as still_there:
                if still_there:
                    index = read_index(folder, self.shown)
                    yield Snapshot(folder, tuple(index["tables"]), tuple(index["documents"]), self.shown, self.remote)
                    return
        raise InputError.at(self.shown, "current", "the generation it names is not there", REBUILD)

    @property
    def tables(self) -> tuple[str, ...]:
        """The names of all tables; empty where nothing is stored."""
        if not self.exists:
            return ()
        with self.snapshot() as snapshot:
            return snapshot.tables

    @property
    def documents(self) -> tuple[str, ...]:
        """The names of all documents; empty where nothing is stored."""
        if not self.exists:
            return ()
        with self.snapshot() as snapshot:
            return snapshot.documents

    def read_table(self, name: str, columns: Sequence[str] | None = None) -> pa.Table:
        """Return a table of the current generation."""
        with self.snapshot() as snapshot:
            return snapshot.read_table(name, columns)

    def read_document(self, name: str) -> dict[str, Any]:
        """Return a document of the current generation."""
        with self.snapshot() as snapshot:
            return snapshot.read_document(name)

    def begin(self, command: str = "stiffcal", wait_s: float = 20.0) -> AbstractContextManager[Writing]:
        """Begin a new generation; what is written counts only after `Writing.commit`.

        Parameters
        ----------
        command : what is writing, for another writer that has to wait.
        wait_s : how long to wait for another writer before saying so.

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
        return begin_writing(self.folder, self.shown, command, wait_s, self.remote)

    def commit(
        self,
        tables: Mapping[str, pa.Table | Columns] | None = None,
        documents: Documents | Callable[[Stored], Documents] | None = None,
        keep_rest: bool = True,
        command: str = "stiffcal",
    ) -> None:
        """Write tables and documents in one step; with `keep_rest` all else stays as it is, otherwise it goes.

        Parameters
        ----------
        documents : by name; or a function that makes them from those stored now (`stored(name)`, None where there is
            none). It is called when nobody else can write: what is appended to a history that two write is not lost.
        """
        with self.begin(command) as writing:
            made = documents(self._stored) if callable(documents) else documents
            for name, table in (tables or {}).items():
                writing.write_table(name, table)
            for name, document in (made or {}).items():
                writing.write_document(name, document)
            if keep_rest:
                writing.keep_rest()
            writing.commit()

    def _stored(self, name: str) -> dict[str, Any] | None:
        return self.read_document(name) if name in self.documents else None


def _folder_of(location: str | Path, shown: str) -> Path:
    if isinstance(location, Path) or "://" not in location:
        return Path(location)
    address = urlsplit(location)
    if address.scheme == "file" and address.netloc in ("", "localhost"):
        return Path(unquote(address.path))
    reason = f"{address.scheme}: addresses are not known"
    raise InputError.at(shown, "--store", reason, "give a folder, or s3://BUCKET/PREFIX")


def _remote_of(location: str | Path, shown: str) -> Remote | None:
    if isinstance(location, Path) or not location.startswith("s3://"):
        return None
    from stiffcal.store.remote import Remote

    return Remote(location, shown)

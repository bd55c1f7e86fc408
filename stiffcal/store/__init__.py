"""The store: what was read and what was found, as Parquet tables and JSON documents, switched over at one instant.

Layout of a store folder::

    store/
      current -> generations/20261121T113400-3f9a1c    the generation that holds now
      generations/20261121T113400-3f9a1c/
        generation.json      what lies here: tables and documents with bytes, SHA-256 and origin; who wrote it and when
        states.parquet       a table; a name with slashes is a path below: recordings/pose01/ft.parquet
        provenance.json      a document
      lock                   held by the one process that writes
      set-aside/             damaged generations whose history could not be read; there only where that happened

Outside readers need one line: ``pandas.read_parquet("store/current/states.parquet")``, the same path in polars, in
DuckDB ``select * from 'store/current/states.parquet'``.

Why generations: a reader must see the old store or the new one, whenever the writer is killed. A writer fills a new
folder, flushes it to the disk, and then replaces the link `current`, which is one atomic step of the file system; only
then is the old folder removed. What a killed writer left behind, or could not remove, the next command removes. A
reader inside stiffcal holds a shared lock on its generation, so that it is not removed beneath it.

A store may come from anybody. Files are found by the names of tables and documents alone (never by the index),
opened without following links, and compared with their SHA-256; the user's record of trust holds the digests of the
indexes that their own runs have written (`stiffcal.store.origin`).

Where links cannot be replaced atomically (Windows, some network folders) a file ``current.id`` with the generation's
name is the switch; ``current`` is then a directory junction, renewed right after it.
"""

from stiffcal.store.provenance import (
    Provenance,
    SourceChanges,
    changed_settings,
    changed_sources,
    versions,
)
from stiffcal.store.reading import Store
from stiffcal.store.snapshot import Snapshot
from stiffcal.store.source_files import SourceFile, hash_sources
from stiffcal.store.table_stream import TableStream
from stiffcal.store.writing import Writing

__all__ = [
    "Provenance",
    "Snapshot",
    "SourceChanges",
    "SourceFile",
    "Store",
    "TableStream",
    "Writing",
    "changed_settings",
    "changed_sources",
    "hash_sources",
    "versions",
]

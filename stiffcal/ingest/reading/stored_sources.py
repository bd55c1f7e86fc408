"""The table of the store that holds the logs as they were when they were read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from stiffcal.ingest.parts import READ_SOURCES
from stiffcal.store.index import OWN, DamagedStoreError
from stiffcal.store.source_files import SourceFile

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.store import Snapshot


def sources_table(sources: Sequence[SourceFile], states: Mapping[str, str]) -> pa.Table:
    """Return the logs as they were when they were read, with the state that shows whether one is still the same."""
    import numpy as np

    from stiffcal.measurements.columns import table_of

    return table_of(
        {
            "file": [source.file for source in sources],
            "bytes": np.array([source.bytes for source in sources], dtype=np.int64),
            "modified_ns": np.array([source.modified_ns for source in sources], dtype=np.int64),
            "sha256": [source.sha256 for source in sources],
            "state": [states.get(source.file, "") for source in sources],
        }
    )


def sources_from_table(table: pa.Table) -> tuple[dict[str, SourceFile], dict[str, str]]:
    """Return the logs of a table that `sources_table` made, by file, and their states."""
    files, sizes, times, digests, states = (table.column(name).to_pylist() for name in table.column_names)
    sources = {row[0]: SourceFile(*row) for row in zip(files, sizes, times, digests, strict=True)}
    return sources, dict(zip(files, states, strict=True))


def stored_states(snapshot: Snapshot) -> Mapping[str, str]:
    """Return of each log what shows that it is as it was read, `FileStatus.state`; none where that is not own work."""
    if READ_SOURCES not in snapshot.tables or snapshot.origin_of(READ_SOURCES) != OWN:
        return {}
    try:
        return sources_from_table(snapshot.read_table(READ_SOURCES))[1]
    except DamagedStoreError:
        return {}

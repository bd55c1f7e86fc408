"""The tables and documents of a store that are made from the logs alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.kinds import tables_of_logs

if TYPE_CHECKING:
    from stiffcal.store import Snapshot

STATES, INGEST, PROVENANCE = "states", "ingest", "provenance"
READ_RUNS, READ_STATES, READ_SOURCES, READ_NAMES = "read/runs", "read/states", "read/sources", "read/names"
"""What reading each run gave, before anything of other runs counts: `stiffcal.ingest.reading.run_readings`."""
READ_LOGS = "read/logs/"
_OF_EVERY_CAMPAIGN = (STATES, INGEST, PROVENANCE)


def needed_parts() -> tuple[str, ...]:
    """Return the names of what nothing can be shown without: it is made from the logs, and all else from it.

    Examples
    --------
    >>> needed_parts()[:3], "friction" in needed_parts()
    (('states', 'ingest', 'provenance'), True)
    """
    return (*_OF_EVERY_CAMPAIGN, *tables_of_logs())


def is_needed(name: str) -> bool:
    """Return whether a table or document is made from the logs alone: without it, they have to be read again.

    Examples
    --------
    >>> is_needed("states"), is_needed("recordings/a/ft"), is_needed("validate")
    (True, True, False)
    """
    return name in needed_parts() or "/" in name


def missing_parts(snapshot: Snapshot) -> list[str]:
    """Return the tables that a store holds once its logs are read, and this one lacks."""
    return [name for name in _OF_EVERY_CAMPAIGN if name not in (*snapshot.tables, *snapshot.documents)]

"""The tables and documents of a store that are made from the logs alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stiffcal.store import Snapshot

STATES, CLAMPED, FRICTION, FREE_MOTION = "states", "clamped", "friction", "free_motion"
INGEST, PROVENANCE = "ingest", "provenance"
RECORDINGS = "recordings/"
NEEDED = (STATES, INGEST, PROVENANCE, CLAMPED, FRICTION, FREE_MOTION)
"""Without these nothing can be shown: they are made from the logs, and all else from them."""
_OF_EVERY_CAMPAIGN = (STATES, INGEST, PROVENANCE)


def is_needed(name: str) -> bool:
    """Return whether a table or document is made from the logs alone: without it, they have to be read again.

    Examples
    --------
    >>> is_needed("states"), is_needed("recordings/a/ft"), is_needed("validate")
    (True, True, False)
    """
    return name in NEEDED or "/" in name


def missing_parts(snapshot: Snapshot) -> list[str]:
    """Return what every campaign's store holds once its logs are read, and this one does not."""
    return [name for name in _OF_EVERY_CAMPAIGN if name not in (*snapshot.tables, *snapshot.documents)]

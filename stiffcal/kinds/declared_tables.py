"""The declarations of all tables of a campaign's store, and the store that is held to them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.store import Store

if TYPE_CHECKING:
    from stiffcal.store.declared_table import DeclaredTable


def campaign_store(location: str | Path, display_name: str = "") -> Store:
    """Return a campaign's store, whose tables are held to what is declared; parameters as of `Store`."""
    return Store(location, display_name, declared_table)


@cache
def declared_tables() -> tuple[DeclaredTable, ...]:
    """Return the tables of every campaign, then those of the kinds of experiment.

    Examples
    --------
    >>> [table.name for table in declared_tables()][:3]
    ['states', 'recording', 'fit']
    """
    from stiffcal.kinds import all_kinds
    from stiffcal.store.tables import TABLES

    return (*TABLES, *(table for kind in all_kinds() for table in kind.declared_tables()))


def declared_table(name: str) -> DeclaredTable | None:
    """Return the declaration of a table by its name in the store; None of a kind that declares none.

    Examples
    --------
    >>> [declared_table(name).name for name in ("recordings/a/ft", "fit-0123", "read/logs/a/ft")]
    ['recording', 'fit', 'read/log']
    """
    return next((table for table in declared_tables() if table.is_called(name)), None)

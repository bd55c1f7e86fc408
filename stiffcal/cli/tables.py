"""Tables as a terminal shows them."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table


def plain_table(*columns: str, secondary: Collection[int] = ()) -> Table:
    """Return an empty table without frame that splits no word; titles that end in `>` mark numbers, aligned right.

    Parameters
    ----------
    columns : titles. secondary : those that are left out where there is no room, by number.
    """
    from rich import box

    from stiffcal.cli.narrow_table import NarrowTable

    table = NarrowTable(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    table.secondary = frozenset(secondary)
    for column in columns:
        table.add_column(column.removesuffix(">"), justify="right" if column.endswith(">") else "left", overflow="fold")
    return table

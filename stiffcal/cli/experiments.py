"""Kinds of experiment as people read them in the terminal: tables and sentences, whatever the kind."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.tables import plain_table

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.kinds.presentation import Column, Overview, Table
    from stiffcal.results.identify_result import IdentifyResult


def overviews(result: IdentifyResult) -> list[Overview]:
    """Return the overviews that the kinds of experiment make of a fit."""
    from stiffcal.kinds import all_kinds

    overviews_of_kinds = [kind.overview(result) for kind in all_kinds()]
    return [overview for overview in overviews_of_kinds if overview is not None]


def show_overviews(console: Console, chosen: list[Overview], details: bool) -> None:
    """Draw the tables and sentences of kinds of experiment; those of single runs as details."""
    from stiffcal.kinds.presentation import Sentence
    from stiffcal.kinds.texts import text_of

    for overview in chosen:
        for block in (*overview.blocks, *(overview.details if details else ())):
            if isinstance(block, Sentence):
                console.print(text_of(block.words), soft_wrap=True)
            else:
                _show_table(console, block)
    if not details and any(overview.details for overview in chosen):
        console.print("--details shows each run, and how these values are defined")


def _show_table(console: Console, table: Table) -> None:
    from stiffcal.kinds.texts import printed_columns, printed_rows

    drawn = plain_table(*(_heading(column, unit) for column, unit in printed_columns(table)))
    for row in printed_rows(table):
        drawn.add_row(*row)
    console.print(drawn)


def _heading(column: Column, unit: str) -> str:
    return f"{column.title}{f' [{unit}]' if unit else ''}{'>' if column.numbers else ''}"

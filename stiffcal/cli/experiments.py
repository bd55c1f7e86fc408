"""Kinds of experiment as people read them in the terminal: tables and sentences, whatever the kind."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import interval, places, significant
from stiffcal.printed_units import printed_unit

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.kinds.presentation import Column, Overview, Table, Words
    from stiffcal.results.identify_result import IdentifyResult


def overviews(result: IdentifyResult) -> list[Overview]:
    """Return the overviews that the kinds of experiment make of a fit."""
    from stiffcal.kinds import all_kinds

    overviews_of_kinds = [kind.overview(result) for kind in all_kinds()]
    return [overview for overview in overviews_of_kinds if overview is not None]


def show_overviews(console: Console, chosen: list[Overview]) -> None:
    """Draw the tables and sentences of kinds of experiment."""
    from stiffcal.kinds.presentation import Sentence

    for overview in chosen:
        for block in overview.blocks:
            if isinstance(block, Sentence):
                console.print(text_of(block.words), soft_wrap=True)
            else:
                _show_table(console, block)


def _show_table(console: Console, table: Table) -> None:
    units = [printed_unit(column.unit) for column in table.columns]
    drawn = plain_table(*(_heading(column, unit) for column, (unit, _) in zip(table.columns, units, strict=True)))
    for row in table.rows:
        drawn.add_row(*(text_of(cell, factor) for cell, (_, factor) in zip(row, units, strict=True)))
    console.print(drawn)


def _heading(column: Column, unit: str) -> str:
    return f"{column.title}{f' [{unit}]' if unit else ''}{'>' if column.numbers else ''}"


def text_of(words: Words, factor: float = 1.0) -> str:
    """Return a text with its numbers, times `factor`, as the terminal writes them.

    Examples
    --------
    >>> from stiffcal.kinds.presentation import Digits, Interval, Joints
    >>> text_of((Joints((1, 2, 3)), ": ", Digits(0.12345), " N·m, ", Interval(2.0, 1.0, 3.0)))
    'joints 1–3: 0.123 N·m, 2.0 ± 1.0'
    """
    from stiffcal.kinds.presentation import Digits, Interval, Joints, Names

    text = ""
    for piece in words:
        match piece:
            case Digits(value, digits):
                text += significant(None if value is None else factor * value, digits)
            case Interval(value, low, high):
                text += interval(*(None if number is None else factor * number for number in (value, low, high)))
            case Names(names):
                text += ", ".join(names)
            case Joints(joints):
                text += places({"joints": joints})
            case _:
                text += piece
    return text

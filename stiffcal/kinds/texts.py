"""Sentences and tables of kinds of experiment as texts, the same in terminal, report and page."""

from __future__ import annotations

from stiffcal.kinds.presentation import Column, Digits, Interval, Joints, Names, Table, Words
from stiffcal.quantity import ShownUnit, quantity_of
from stiffcal.wording import estimate, listing, place, significant


def text_of(words: Words, factor: float = 1.0) -> str:
    """Return a text with its numbers, times `factor`.

    Examples
    --------
    >>> text_of((Names(("A1", "A2")), ": ", Digits(-0.12345), " N·m, ", Interval(2.0, 1.0, 3.5)))
    'A1 and A2: −0.123 N·m, 2.0 (1.0 … 3.5)'
    >>> text_of((Joints((1, 2, 3)), " in mrad: ", Digits(None), ", ", Interval(0.002, 0.001, 0.003)), 1e3)
    'joints 1–3 in mrad: –, 2.0 ± 1.0'
    """
    text = ""
    for piece in words:
        match piece:
            case Digits(value, digits):
                text += significant(None if value is None else factor * value, digits)
            case Interval(value, low, high):
                text += estimate(value, (low, high), factor)
            case Names(names):
                text += listing(names)
            case Joints(joints):
                text += place({"joints": joints})
            case _:
                text += piece
    return text


def printed_columns(table: Table) -> tuple[tuple[Column, str], ...]:
    """Return a table's columns, each with the unit in which its numbers are printed."""
    return tuple((column, unit.name) for column, unit in zip(table.columns, _units(table), strict=True))


def printed_rows(table: Table) -> tuple[tuple[str, ...], ...]:
    """Return the texts of a table's rows, in the units of `printed_columns`."""
    factors = [unit.factor for unit in _units(table)]
    return tuple(tuple(text_of(cell, factor) for cell, factor in zip(row, factors, strict=True)) for row in table.rows)


def _units(table: Table) -> list[ShownUnit]:
    """Return the unit of each column, by its largest number."""
    return [
        quantity_of(column.unit).unit_for(
            piece.value for row in table.rows for piece in row[k] if isinstance(piece, Digits | Interval)
        )
        for k, column in enumerate(table.columns)
    ]

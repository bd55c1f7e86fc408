"""Sentences and tables as texts, the same in terminal, report, page and notebook."""

from __future__ import annotations

from stiffcal.estimate import Estimate
from stiffcal.presentation.values import Column, Table
from stiffcal.presentation.words import Digits, Joints, Names, Words
from stiffcal.quantity import ShownUnit, Units, quantity_of
from stiffcal.wording import estimate, listing, place, significant


def text_of(words: Words, unit: ShownUnit | None = None) -> str:
    """Return a text with its numbers.

    Parameters
    ----------
    words : piece by piece. unit : of the column that it stands in; None of a sentence, whose estimates have their own.

    Examples
    --------
    >>> text_of((Names(("A1", "A2")), ": ", Digits(-0.12345), " N·m, ", Estimate(value=2.0, interval=[1.0, 3.5])))
    'A1 and A2: −0.123 N·m, 2.0 (1.0 … 3.5)'
    >>> from stiffcal.quantity import ANGLE
    >>> text_of((Joints((1, 2, 3)), ": ", Digits(None), ", ", Estimate.of(0.002, 5.1e-4, ANGLE)))
    'joints 1–3: –, 2.0 ± 1.0 mrad'
    """
    text, factor = "", 1.0 if unit is None else unit.factor
    for piece in words:
        match piece:
            case Digits(value, digits):
                text += significant(None if value is None else factor * value, digits)
            case Estimate():
                own = None if unit is not None or piece.quantity is None else piece.quantity.unit_for([piece.value])
                text += estimate(piece.value, piece.interval, factor if own is None else own.factor)
                text += "" if own is None else own.mark
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
    units = _units(table)
    return tuple(tuple(text_of(cell, unit) for cell, unit in zip(row, units, strict=True)) for row in table.rows)


def _units(table: Table) -> list[ShownUnit]:
    """Return the unit of each column, one for all columns of a quantity, by the largest number there."""
    quantities = [quantity_of(column.unit) for column in table.columns]
    units = Units(
        (quantity, [piece.value for row in table.rows for piece in row[k] if isinstance(piece, Digits | Estimate)])
        for k, quantity in enumerate(quantities)
    )
    return [units.of(quantity) for quantity in quantities]

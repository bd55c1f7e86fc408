"""Identified values before and after a change: the table that improve, diagnose and compare share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import short_places
from stiffcal.results.value_words import value_in_model, value_with_unit
from stiffcal.wording import change_words

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.identification.answers.before_after import BeforeAfter


def show_moved(console: Console, values: Sequence[BeforeAfter], title: str) -> None:
    """Draw the values that moved by more than their 95 % interval, and how many did not.

    Parameters
    ----------
    console : where to.
    values : of two fits; where there are none, nothing is drawn.
    title : what changed them.
    """
    from stiffcal.identification.answers.before_after import units_of_values

    compared = [value for value in values if value.before is not None and value.after is not None]
    if not compared:
        return
    moved = sorted(
        (value for value in compared if value.outside_interval), key=lambda value: -abs(value.relative or 0.0)
    )
    n_within = len(compared) - len(moved)
    if not moved:
        console.print(
            f"\n{title}: no value changes by more than its 95 % interval ({n_within} compared)", soft_wrap=True
        )
        return
    units = units_of_values(moved)
    read = [(value, units.of(value.quantity)) for value in moved]
    # a unit that all have stands above them: the columns are narrower by it
    common = read[0][1].name if len({unit.name for _, unit in read}) == 1 else ""
    console.print(f"\n{title}{f', in {common}' if common else ''}:", soft_wrap=True)
    table = plain_table("value", "before, ± 95 %>", "after, ± 95 %>", "change>")
    for value, unit in read:
        symbol = value.name.rpartition(".")[2]
        place = value.setup_part or short_places(value.where)
        name = f"{value.effect} {place}" + ("" if symbol == "c" else f" {symbol}")
        after = value_in_model(value.after, unit) if common else value_with_unit(value.after, unit)
        table.add_row(name, value_in_model(value.before, unit), after, change_words(value.relative))
    console.print(table)
    if n_within:
        console.print(
            f"  {n_within} other value{'s' * (n_within > 1)} stay{'s' * (n_within == 1)} within the 95 % interval "
            "(all in --json)"
        )

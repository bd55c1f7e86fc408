"""Identified values before and after a change: the table that improve, diagnose and compare share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import NOT_KNOWN, interval, share, short_places, significant
from stiffcal.printed_units import printed_unit

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.identification.before_after import BeforeAfter, EstimatedValue


def show_moved(console: Console, values: Sequence[BeforeAfter], title: str) -> None:
    """Draw the values that moved by more than their 95 % interval, and how many did not.

    Parameters
    ----------
    console : where to.
    values : of two fits; where there are none, nothing is drawn.
    title : what changed them.
    """
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
    read = [(value, *printed_unit(value.unit, value.drift_follows)) for value in moved]
    # a unit that all have stands above them: the columns are narrower by it
    common = read[0][1] if len({unit for _, unit, _ in read}) == 1 else ""
    console.print(f"\n{title}{f', in {common}' if common else ''}:", soft_wrap=True)
    table = plain_table("value", "before, ± 95 %>", "after, ± 95 %>", "change>")
    for value, unit, factor in read:
        symbol = value.name.rpartition(".")[2]
        place = value.setup_part or short_places(value.where)
        name = f"{value.effect} {place}" + ("" if symbol == "c" else f" {symbol}")
        before, after = estimate_words(value.before, factor), estimate_words(value.after, factor)
        table.add_row(name, before, f"{after} {'' if common else unit}".rstrip(), change_words(value.relative))
    console.print(table)
    if n_within:
        console.print(
            f"  {n_within} other value{'s' * (n_within > 1)} stay{'s' * (n_within == 1)} within the 95 % interval "
            "(all in --json)"
        )


def estimate_words(estimate: EstimatedValue | None, factor: float = 1.0) -> str:
    """Return a value with its 95 % interval, all times `factor`.

    Examples
    --------
    >>> from stiffcal.identification.before_after import EstimatedValue
    >>> estimate_words(EstimatedValue(value=5.0e4, interval=[4.9e4, 5.1e4]))
    '(5.00 ± 0.10)·10⁴'
    >>> estimate_words(EstimatedValue(value=None, interval=[4.9e4, None])), estimate_words(None)
    ('above 4.90·10⁴', 'not in the model')
    >>> estimate_words(EstimatedValue(value=0.1, interval=[0.09, None], at_bound=True), 1e3)
    '100 (above 90), at its limit'
    """
    if estimate is None:
        return "not in the model"
    low, high = (None if end is None else end * factor for end in estimate.interval or (None, None))
    if estimate.value is None:
        return f"above {significant(low)}" if low is not None else NOT_KNOWN
    limit = ", at its limit" if estimate.at_bound else ""
    if estimate.interval is None:
        return significant(estimate.value * factor) + limit
    return interval(estimate.value * factor, low, high) + limit


def change_words(relative: float | None) -> str:
    """Return a relative change with its sign.

    Examples
    --------
    >>> change_words(1.19), change_words(-0.02), change_words(None)
    ('+119 %', '-2.00 %', '–')
    """
    return f"+{share(relative)}" if relative is not None and relative > 0 else share(relative)

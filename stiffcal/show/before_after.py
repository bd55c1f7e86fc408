"""Identified values before and after a change, as improve and diagnose show them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.results.value_words import value_in_model, value_with_unit
from stiffcal.show.builder import PageBuilder, number
from stiffcal.show.parameters import names_and_units
from stiffcal.wording import change_words

if TYPE_CHECKING:
    from stiffcal.identification.answers.before_after import BeforeAfter


def add_moved(made: PageBuilder, values: Sequence[BeforeAfter], title: str) -> None:
    """Add the values that moved by more than their 95 % interval, and how many did not.

    Parameters
    ----------
    made : takes them; where there are none, nothing is added.
    values : of two fits. title : what changed them.
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
        made.head(f"{title}: no value changes by more than its 95 % interval ({n_within} compared)")
        return
    units = units_of_values(moved)
    read = [(value, units.of(value.quantity)) for value in moved]
    named = names_and_units([(value.effect, value.where, value.name, value.unit, unit) for value, unit in read])
    # what all are, and a unit that all have, stand above them: the columns are narrower by it
    common = named.unit
    effects = list(dict.fromkeys(value.effect for value in moved))
    of_one = effects[0] if len(effects) == 1 else ""
    parts = (" of ".join(text for text in (named.shared, of_one) if text), f"in {common}" if common else "")
    what = " ".join(text for text in parts if text)
    made.head(f"{title}{f', {what}' if what else ''}:")
    rows = []
    for (value, unit), name in zip(read, named.names, strict=True):
        after = value_in_model(value.after, unit) if common else value_with_unit(value.after, unit)
        rows.append((name, value_in_model(value.before, unit), after, change_words(value.relative)))
    made.table(
        (
            "place" if of_one and named.shared else "value",
            number("before, ± 95 %"),
            number("after, ± 95 %"),
            number("change"),
        ),
        rows,
    )
    if n_within:
        many = f"value{'s' * (n_within > 1)} stay{'s' * (n_within == 1)}"
        made.list([f"{n_within} other {many} within the 95 % interval (all in --json)"], "stays")

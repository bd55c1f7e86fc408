"""What `compare` shows: whether anything has changed, and both values of each parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.identification.answers.before_after import units_of_values
from stiffcal.results.value_words import value_in_model
from stiffcal.show.builder import PageBuilder, number
from stiffcal.validation.change import CHANCE
from stiffcal.wording import change_words, listing, place, significant

if TYPE_CHECKING:
    from stiffcal.presentation.values import Level, Page
    from stiffcal.show.options import ShowOptions
    from stiffcal.validation.compare_result import CompareResult


def page(result: CompareResult, options: ShowOptions) -> Page:
    """Return the verdict, then both values of each parameter, the change and its probability."""
    made = PageBuilder("Comparison of two campaigns")
    level, text = _verdict(result)
    made.say(text, "verdict", level)
    units = units_of_values(result.before_after)
    chances = {change.name: change.p_value for change in result.parameters}
    rows = []
    for row in result.before_after:
        symbol, unit = row.name.rsplit(".", 1)[1], units.of(row.quantity)
        rows.append(
            (
                row.effect,
                place(row.where),
                "stiffness" if symbol == "c" and row.unit == "N·m/rad" else symbol,
                value_in_model(row.before, unit),
                value_in_model(row.after, unit),
                unit.name,
                change_words(row.relative),
                significant(chances.get(row.name), 2),
                "changed" if row.name in result.changed else "",
            )
        )
    titles = (
        "effect",
        "place",
        "parameter",
        number("before, ± 95 %"),
        number("after, ± 95 %"),
        "",
        number("change"),
        number("p"),
        "",
    )
    made.table(titles, rows)
    return made.page()


def _verdict(result: CompareResult) -> tuple[Level, str]:
    """Return whether the robot has changed by more than chance makes."""
    together = f"all parameters together: p = {significant(result.p_value_all, 2)} of a change this large by chance"
    judged = "" if result.p_value_all is None else f"; {together}"
    n_known = sum(change.p_value is not None for change in result.parameters)
    if not n_known:
        return "warn", "no parameter is identified in both campaigns: changes cannot be judged"
    if result.changed:
        moved = [f"{row.effect} ({place(row.where)})" for row in result.before_after if row.name in result.changed]
        return "warn", f"significant change: {listing(dict.fromkeys(moved))}{judged}"
    if result.p_value_all is not None and result.p_value_all < CHANCE:
        return "warn", f"no single parameter has changed significantly, but all of them together have{judged}"
    return "pass", f"no significant change of any parameter{judged}"

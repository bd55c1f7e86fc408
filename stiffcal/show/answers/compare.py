"""What `compare` shows: whether anything has changed, and both values of each parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.identification.answers.before_after import units_of_values
from stiffcal.results.value_words import value_and_remark
from stiffcal.show.builder import PageBuilder, number
from stiffcal.show.parameters import add_values, joined_remarks, names_and_units
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
    named = names_and_units(
        [(row.effect, row.where, row.name, row.unit, units.of(row.quantity)) for row in result.before_after]
    )
    rows = []
    for row, name in zip(result.before_after, named.names, strict=True):
        unit = units.of(row.quantity)
        (before, of_before), (after, of_after) = (value_and_remark(one, unit) for one in (row.before, row.after))
        remarks = ("changed" if row.name in result.changed else "", of_before, of_after)
        rows.append(
            (
                name, before, after, *named.unit_of(unit), change_words(row.relative),
                significant(chances.get(row.name), 2), joined_remarks(remarks),
            )
        )  # fmt: skip
    titles = ("parameter", number(named.title("before"), named.several), number(named.title("after")))
    add_values(
        made,
        (*titles, *named.unit_title, number("change"), number("p", True), "remark"),
        rows,
        options.details,
        "compare",
    )
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

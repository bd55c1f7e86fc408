"""`stiffcal compare`: two campaigns of one robot, before and after."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import NextLine, answering
from stiffcal.cli.before_after import change_words
from stiffcal.cli.endings import OK
from stiffcal.cli.options import AsJson, NoUpdate
from stiffcal.cli.tables import plain_table
from stiffcal.cli.verdict import Level, show_verdict
from stiffcal.cli.wording import places, significant
from stiffcal.escapes.shell import command_line
from stiffcal.results.value_words import value_in_model
from stiffcal.validation.change import CHANCE
from stiffcal.wording import listing

if TYPE_CHECKING:
    from stiffcal.cli.console import AnswerConsole
    from stiffcal.validation.compare_result import CompareResult


def compare(
    before: Annotated[Path, typer.Argument(metavar="DIR1", help="The earlier campaign.")],
    after: Annotated[Path, typer.Argument(metavar="DIR2", help="The later campaign.")],
    as_json: AsJson = False,
    no_update: NoUpdate = False,
) -> int:
    """Compare two campaigns of one robot.

    Each parameter, with the significance of its change.

    Example: stiffcal compare before-service after-service
    """
    with answering(as_json) as answer:
        from stiffcal.commands.compare import compare_campaigns
        from stiffcal.stages.steps import RunContext

        context = RunContext(update=not no_update, progress=answer.progress, notify=answer.notify)
        result = compare_campaigns(before, after, context)
        answer.give(result, show_comparison, NextLine(command_line("report", after)))
    return OK


def show_comparison(console: AnswerConsole, result: CompareResult) -> None:
    """Draw whether anything has changed, then both values of each parameter, the change and its probability."""
    show_verdict(console, *_verdict(result))
    console.show_warnings(result.warnings)
    table = plain_table("effect", "place", "parameter", "before, ± 95 %>", "after, ± 95 %>", "", "change>", "p>", "")
    from stiffcal.identification.answers.before_after import units_of_values

    units = units_of_values(result.before_after)
    chances = {change.name: change.p_value for change in result.parameters}
    for row in result.before_after:
        symbol = row.name.rsplit(".", 1)[1]
        unit = units.of(row.quantity)
        table.add_row(
            row.effect,
            places(row.where),
            "stiffness" if symbol == "c" and row.unit == "N·m/rad" else symbol,
            value_in_model(row.before, unit),
            value_in_model(row.after, unit),
            unit.name,
            change_words(row.relative),
            significant(chances.get(row.name), 2),
            "changed" if row.name in result.changed else "",
        )
    console.print(table)


def _verdict(result: CompareResult) -> tuple[Level, str]:
    """Return whether the robot has changed by more than chance makes."""
    together = f"all parameters together: p = {significant(result.p_value_all, 2)} of a change this large by chance"
    judged = "" if result.p_value_all is None else f"; {together}"
    n_known = sum(change.p_value is not None for change in result.parameters)
    if not n_known:
        return "warn", "no parameter is identified in both campaigns: changes cannot be judged"
    if result.changed:
        moved = [f"{row.effect} ({places(row.where)})" for row in result.before_after if row.name in result.changed]
        return "warn", f"significant change: {listing(dict.fromkeys(moved))}{judged}"
    if result.p_value_all is not None and result.p_value_all < CHANCE:
        return "warn", f"no single parameter has changed significantly, but all of them together have{judged}"
    return "pass", f"no significant change of any parameter{judged}"

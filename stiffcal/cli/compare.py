"""`stiffcal compare`: two campaigns of one robot, before and after."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering, command_line
from stiffcal.cli.before_after import change_words, estimate_words
from stiffcal.cli.endings import OK
from stiffcal.cli.options import AsJson, NoUpdate
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import places, significant

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.validation.compare_result import CompareResult


def compare(
    before: Annotated[Path, typer.Argument(metavar="DIR1", help="The campaign before.")],
    after: Annotated[Path, typer.Argument(metavar="DIR2", help="The campaign after.")],
    as_json: AsJson = False,
    no_update: NoUpdate = False,
) -> int:
    """Compare two campaigns of one robot.

    Each parameter, and how surely it has changed.

    Example: stiffcal compare before-service after-service
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.compare import compare_campaigns
        from stiffcal.workflow.steps import RunContext

        context = RunContext(update=not no_update, progress=answer.progress, notify=answer.notify)
        result = compare_campaigns(before, after, context)
        answer.give(result, show_comparison, command_line("report", after))
    return OK


def show_comparison(console: Console, result: CompareResult) -> None:
    """Draw both values of each parameter, the change and its probability."""
    table = plain_table("effect", "place", "parameter", "before, ± 95 %>", "after, ± 95 %>", "", "change>", "p>", "")
    chances = {change.name: change.p_value for change in result.parameters}
    for row in result.before_after:
        symbol = row.name.rsplit(".", 1)[1]
        table.add_row(
            row.effect,
            places(row.where),
            "stiffness" if symbol == "c" and row.unit == "N·m/rad" else symbol,
            estimate_words(row.before),
            estimate_words(row.after),
            row.unit,
            change_words(row.relative),
            significant(chances.get(row.name), 2),
            "changed" if row.name in result.changed else "",
        )
    console.print(table)
    if result.p_value_all is not None:
        console.print(f"all together: p = {significant(result.p_value_all, 2)} for so much change by chance")
    if not result.changed:
        console.print("no parameter has changed beyond what chance makes")

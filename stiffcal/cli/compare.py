"""`stiffcal compare`: two campaigns of one robot, before and after."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering, command_line
from stiffcal.cli.endings import OK
from stiffcal.cli.options import AsJson, NoUpdate
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import places, share, significant

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
    table = plain_table("effect", "place", "parameter", "before>", "after>", "change>", "p>", "")
    for row in result.parameters:
        symbol, unit = row.name.rsplit(".", 1)[1], row.unit
        before, after = row.before.value, row.after.value
        stiffness = row.before.known_stiffness, row.after.known_stiffness
        if unit == "rad/(N·m)" and None not in stiffness:
            symbol, unit, (before, after) = "stiffness", "N·m/rad", stiffness
        table.add_row(
            row.effect,
            places(row.where),
            symbol,
            significant(before),
            f"{significant(after)} {unit}",
            share((after - before) / before if before and after is not None else None),
            significant(row.p_value, 2),
            "changed" if row.name in result.changed else "",
        )
    console.print(table)
    if result.p_value_all is not None:
        console.print(f"all together: p = {significant(result.p_value_all, 2)} for so much change by chance")
    if not result.changed:
        console.print("no parameter has changed beyond what chance makes")

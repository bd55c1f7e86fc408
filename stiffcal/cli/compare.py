"""`stiffcal compare`: two campaigns of one robot, before and after."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Document, answering, command_line
from stiffcal.cli.endings import OK
from stiffcal.cli.options import AsJson, NoUpdate
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import places, share, significant

if TYPE_CHECKING:
    from rich.console import Console


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

        context = RunContext(update=not no_update, progress=answer.progress, say=answer.say)
        document = compare_campaigns(before, after, context)
        answer.give(document, show_comparison, command_line("report", after))
    return OK


def show_comparison(console: Console, document: Document) -> None:
    """Draw both values of each parameter, the change and its probability."""
    table = plain_table("effect", "place", "parameter", "before>", "after>", "change>", "p>", "")
    for row in document["parameters"]:
        stiff = row["before"].get("stiffness") is not None and row["after"].get("stiffness") is not None
        key, unit = ("stiffness", "N·m/rad") if stiff and row["unit"] == "rad/(N·m)" else ("value", row["unit"])
        one, other = row["before"][key], row["after"][key]
        change = (other - one) / one if one and other is not None else None
        table.add_row(
            row["effect"],
            places(row["where"]),
            "stiffness" if key == "stiffness" else row["name"].rsplit(".", 1)[1],
            significant(one),
            f"{significant(other)} {unit}",
            share(change),
            significant(row["p_value"], 2),
            "changed" if row["name"] in document["changed"] else "",
        )
    console.print(table)
    together = document["p_value_all"]
    if together is not None:
        console.print(f"all together: p = {significant(together, 2)} for so much change by chance")
    if not document["changed"]:
        console.print("no parameter has changed beyond what chance makes")

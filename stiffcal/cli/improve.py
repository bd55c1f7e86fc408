"""`stiffcal improve`: diagnose, add, identify, until nothing is missing."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import Answer, Document, answering, command_line
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, StoreAt
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import NOT_KNOWN, deviation, places

if TYPE_CHECKING:
    from rich.console import Console


def improve(
    folder: Folder = HERE,
    yes: Annotated[bool, typer.Option("--yes", help="Add without asking.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say what would be added.")] = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Add what is missing, step by step.

    Asks before each step where a person sits at the terminal and --yes is not given.

    Example: stiffcal improve demo --yes
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.improve import always, improve_campaign
        from stiffcal.workflow.steps import RunContext

        context = RunContext(store=store, update=not no_update, progress=answer.progress, notify=answer.notify)
        asks = sys.stdin.isatty() and not yes and not as_json

        def ask(proposal: Document) -> bool:
            answer.progress.stop()
            return typer.confirm(f"add {proposal['effect']} ({places(proposal['where'])})?", default=True, err=True)

        document = improve_campaign(
            folder, context, ask if asks else always, dry_run, None if as_json else lambda step: tell(answer, step)
        )
        answer.give(document, show_ladder, command_line("report", folder, store=store))
    return OK


def tell(answer: Answer, step: Document) -> None:
    """Say a rung of the ladder as it is reached."""
    what = (
        "present model" if step["action"] == "start" else f"{step['action']} {step['effect']} ({places(step['where'])})"
    )
    answer.notify(f"{what}: {deviation(step['heldout_rms'])} in unseen poses")


def show_ladder(console: Console, document: Document) -> None:
    """Draw the ladder of errors, from no model down to the noise."""
    table = plain_table("step", "unseen poses, rms>")
    first = document["steps"][0]
    table.add_row("no model", deviation(first.get("zero_model")))
    for step in document["steps"]:
        words = (
            "present model"
            if step["action"] == "start"
            else f"{step['action']} {step['effect']} ({places(step['where'])})"
        )
        table.add_row(words, deviation(step["heldout_rms"]) if step["heldout_rms"] else "not done")
    table.add_row("noise", deviation(document["noise"]) if document["noise"] else NOT_KNOWN)
    console.print(table)
    console.print(document["summary"], soft_wrap=True)
    for one in document["structure"]:
        console.print(f"  what is left follows the {one['follows']}: {one['seen']}", soft_wrap=True)

"""`stiffcal check`: what was understood of the campaign, and what is still missing."""

from __future__ import annotations

from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import HERE, AsJson, Details, Folder, StoreAt
from stiffcal.commands.next_step import after_check
from stiffcal.show.options import ShowOptions


def check(
    folder: Folder = HERE,
    quick: Annotated[bool, typer.Option("--quick", help="Read only the first lines of each file.")] = False,
    run: Annotated[str | None, typer.Option(metavar="ID", help="Only this run.", show_default=False)] = None,
    details: Details = False,
    as_json: AsJson = False,
    store: StoreAt = None,
) -> int:
    """Check the folder: what was read, what is missing.

    Reads all logs and lists every fault with its place; useful already during the measurement. Exit code 1 if the
    campaign is not ready.

    Example: stiffcal check demo --quick
    """
    with answering(as_json) as answer:
        from stiffcal.ingest.checks.loaded import check_campaign

        result = check_campaign(folder, quick=quick, run=run, progress=answer.progress)
        answer.show(result, after_check(folder, result, store), ShowOptions(details, folder, store))
    return OK if result.ready else NOT_HELD

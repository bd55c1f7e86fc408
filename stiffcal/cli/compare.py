"""`stiffcal compare`: two campaigns of one robot, before and after."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import AsJson, Details, NoUpdate
from stiffcal.escapes.shell import command_line
from stiffcal.presentation.values import NextStep
from stiffcal.show.options import ShowOptions


def compare(
    before: Annotated[Path, typer.Argument(metavar="DIR1", help="The earlier campaign.")],
    after: Annotated[Path, typer.Argument(metavar="DIR2", help="The later campaign.")],
    details: Details = False,
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
        answer.show(result, NextStep(command_line("report", after)), ShowOptions(details, after))
    return OK

"""`stiffcal trend`: one robot over many campaigns."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import AsJson, Details, NoUpdate, Output, Overwrite
from stiffcal.escapes.shell import command_line
from stiffcal.presentation.values import NextStep
from stiffcal.show.options import ShowOptions

if TYPE_CHECKING:
    from stiffcal.validation.trend_result import TrendResult


def trend(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR...", help="Campaigns of one robot, oldest first.")],
    max_change: Annotated[
        float | None,
        typer.Option(
            "--max-change",
            metavar="SHARE",
            help="Exit code 1 if a parameter has changed by more than this share with 95 % confidence, e.g. 0.1.",
            show_default=False,
        ),
    ] = None,
    output: Output = None,
    details: Details = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    overwrite: Overwrite = False,
) -> int:
    """Track one robot over many campaigns.

    Each parameter over time, an alarm if one has changed by more than the scatter between campaigns, and whether
    wear of a joint or a change of the set-up explains it. Exit code 1 if there is an alarm.

    Example: stiffcal trend robot-7/2026-* -o trend.svg --max-change 0.1
    """
    with answering(as_json) as answer:
        from stiffcal.commands.trend import trend_campaigns
        from stiffcal.stages.steps import RunContext

        context = RunContext(update=not no_update, progress=answer.progress, notify=answer.notify, overwrite=overwrite)
        result = trend_campaigns(folders, context, output, max_change)
        answer.show(result, _next(result), ShowOptions(details))
    return OK if result.passed else NOT_HELD


def _next(result: TrendResult) -> NextStep:
    command = "report" if result.cause is None else "diagnose"
    return NextStep(command_line(command, Path(result.campaigns[-1].folder)))

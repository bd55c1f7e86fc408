"""`stiffcal trend`: one robot over many campaigns."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import NextLine, answering
from stiffcal.cli.before_after import change_words
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import AsJson, NoUpdate, Output, Overwrite
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import places, share, significant
from stiffcal.escapes.shell import command_line
from stiffcal.quantity import Units, quantity_of
from stiffcal.results.value_words import value_in_model

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.validation.trend_result import ChangeCause, PossibleCause, TrendParameter, TrendResult

VERDICTS = {
    "wear": "wear: the changes are those of a joint that becomes softer, and no change of the set-up explains them",
    "stiffened": "a joint has become stiffer: no wear, but possibly a repair or replacement",
    "set-up": "a change of the set-up: it explains the changes of all parameters, and no joint alone does",
    "undecided": "undecided: several causes would explain these changes",
    "unexplained": "unexplained: neither a joint nor a change of the set-up explains these changes",
}


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
        answer.give(result, show_trend, _next(result))
    return OK if result.passed else NOT_HELD


def _next(result: TrendResult) -> NextLine:
    command = "report" if result.cause is None else "diagnose"
    return NextLine(command_line(command, Path(result.campaigns[-1].folder)))


def show_trend(console: Console, result: TrendResult) -> None:
    """Draw each parameter's first and last value, its change, and the chart's verdict."""
    dates = [campaign.date or "" for campaign in result.campaigns]
    span = f", {dates[0]} to {dates[-1]}" if dates[0] else ""
    console.print(f"{len(result.campaigns)} campaigns{span}", soft_wrap=True)
    table = plain_table(
        "effect", "place", "parameter", "first, ± 95 %>", "last, ± 95 %>", "", "change>", "varies by>", ""
    )
    units = Units((row.unit, [one.value for one in row.values if one is not None]) for row in result.parameters)
    for row in result.parameters:
        symbol = row.name.rsplit(".", 1)[1]
        unit = units.of(quantity_of(row.unit))
        table.add_row(
            row.effect,
            places(row.where),
            "stiffness" if symbol == "c" and row.unit == "N·m/rad" else symbol,
            value_in_model(row.values[0], unit),
            value_in_model(row.values[-1], unit),
            unit.name,
            change_words(row.change),
            _deviation(row),
            _remark(row, result),
        )
    console.print(table)
    if result.figure is not None:
        console.print(f"parameters over the campaigns: {result.figure}", soft_wrap=True)
    if result.cause is not None:
        _show_cause(console, result, result.cause)
    elif result.threshold is not None and not result.alarms:
        console.print("no alarm: no parameter has changed by more than the scatter between campaigns", soft_wrap=True)
    for name in result.exceeded:
        console.print(f"more than {share(result.max_change)} change: {name}", soft_wrap=True)


def _deviation(row: TrendParameter) -> str:
    if row.deviation is None:
        return "not known"
    return share(row.deviation) if row.relative else significant(row.deviation, 2)


def _remark(row: TrendParameter, result: TrendResult) -> str:
    if row.alarm is None or row.changed_from is None:
        return "" if row.variance_from != "unknown" else "not judged"
    return f"alarm in {_campaign(result, row.alarm)}, changed from {_campaign(result, row.changed_from)}"


def _campaign(result: TrendResult, number: int) -> str:
    campaign = result.campaigns[number]
    return campaign.date or campaign.folder


def _show_cause(console: Console, result: TrendResult, cause: ChangeCause) -> None:
    console.print(f"since {_campaign(result, cause.since)}: {VERDICTS[cause.verdict]}", soft_wrap=True)
    if cause.misfit_grew:
        console.print("  the residuals have grown since then: the model lacks an effect (stiffcal diagnose)")
    if cause.explains_residuals:
        console.print(f"  any one of these would explain them: {', '.join(cause.explains_residuals)}", soft_wrap=True)
    for one in cause.causes:
        console.print(
            f"  {_cause(one)}: probability {share(one.probability)} among the compared causes, "
            f"p = {significant(one.p_value, 2)}",
            soft_wrap=True,
        )


def _cause(one: PossibleCause) -> str:
    if one.kind == "set-up":
        return one.effect
    joints = ", ".join(str(joint) for joint in one.joints)
    return f"joint{'s' * (len(one.joints) > 1)} {joints} {'softer' if one.softer else 'stiffer'}"

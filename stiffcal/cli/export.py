"""`stiffcal export`: the numbers for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering, command_line
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, StoreAt

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.workflow.command_results import ExportResult


def export(
    folder: Folder = HERE,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", metavar="FILE", help="*.csv, *.parquet: states; *.json, *.urdf: the model."),
    ] = Path("states.csv"),
    raw_text: Annotated[
        bool, typer.Option("--raw-text", help="CSV: no ' before texts that a spreadsheet takes for formulas.")
    ] = False,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
) -> int:
    """Write the states or the model for other programs.

    States with measured, predicted and residual as CSV or Parquet; the model as JSON or URDF. In CSV a text that a
    spreadsheet would take for a formula (= + - @ first) gets a ' before it, which stiffcal takes off again.

    Example: stiffcal export demo -o states.parquet
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.export import export_campaign
        from stiffcal.workflow.steps import RunContext

        context = RunContext(store=store, update=not no_update, progress=answer.progress, notify=answer.notify)
        result = export_campaign(folder, context, output, raw_text=raw_text)
        answer.give(result, show_export, command_line("plot", folder, store=store))
    return OK


def show_export(console: Console, result: ExportResult) -> None:
    """Name the file and what is in it."""
    console.print(f"wrote {result.file}: {result.holds}", soft_wrap=True)

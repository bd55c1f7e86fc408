"""`stiffcal export`: the numbers for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, NoUpdate, Overwrite, StoreAt
from stiffcal.commands.next_step import after_export


def export(
    folder: Folder = HERE,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="Output file (default: DIR/states.csv; a relative name is one of the current folder). *.csv, *.xlsx, "
            "*.parquet: states; *.json: the model; *.urdf, *.toml: the calibrated robot; *.xml: the robot for MuJoCo; "
            "*.c, *.st: code for a controller.",
            show_default=False,
        ),
    ] = None,
    raw_text: Annotated[
        bool, typer.Option("--raw-text", help="CSV: no ' before texts that a spreadsheet would read as formulas.")
    ] = False,
    convention: Annotated[
        str | None,
        typer.Option(
            metavar="dh|modified-dh",
            help="Robot file: convention of its rows (default: that of the campaign's robot).",
            show_default=False,
        ),
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Robot file: no β for nearly parallel axes (strict DH).")
    ] = False,
    cycle_ms: Annotated[float, typer.Option("--cycle-ms", metavar="MS", help="Code: cycle time, ms.")] = 4.0,
    filter_hz: Annotated[
        float | None,
        typer.Option(
            "--filter",
            metavar="HZ",
            help="Code: cut-off of the low-pass filter of the sensor reading, Hz.",
            show_default=False,
        ),
    ] = None,
    tool: Annotated[
        str | None,
        typer.Option(
            metavar="KG,X,Y,Z",
            help="Code: take the weight of the tool beyond the sensor out: mass, centre in the flange frame (m).",
            show_default=False,
        ),
    ] = None,
    zeroed_at: Annotated[
        str | None,
        typer.Option(
            "--zeroed-at",
            metavar="A1,A2,…",
            help="Code: joint angles in degrees at which the sensor was zeroed with the tool attached (default: not "
            "zeroed).",
            show_default=False,
        ),
    ] = None,
    sensor: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Code: frame of the sensor reading, axes and origin (default: that of the campaign).",
            show_default=False,
        ),
    ] = None,
    target: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Code: frame that is held in place (default: the measured frame).", show_default=False
        ),
    ] = None,
    leave_out: Annotated[
        list[str] | None,
        typer.Option("--leave-out", metavar="EFFECT", help="Code: omit an effect.", show_default=False),
    ] = None,
    as_json: AsJson = False,
    no_update: NoUpdate = False,
    store: StoreAt = None,
    overwrite: Overwrite = False,
) -> int:
    """Write the states or the model for other programs, or as code for a controller.

    The file is DIR/states.csv, or that of -o.

    States with measured, predicted and residual as CSV, workbook or Parquet; the model as JSON; the robot with the
    geometry that absolute places gave as URDF or robot file, with its springs as XML for MuJoCo; its compensation,
    from a sensor sample to joint offsets, as C99 with a header or as Structured Text. In CSV, text that a spreadsheet
    would read as a formula (first character = + - @) gets a leading ', which stiffcal removes when it reads the
    file.

    Example: stiffcal export demo -o states.parquet

    Example: stiffcal export my-robot -o calibrated.toml --convention dh
    """
    with answering(as_json) as answer:
        from stiffcal.commands.export import export_campaign
        from stiffcal.compensation.exports.controller import ControllerOptions
        from stiffcal.compensation.exports.row_options import row_options
        from stiffcal.stages.steps import RunContext

        context = RunContext(
            store=store, update=not no_update, progress=answer.progress, notify=answer.notify, overwrite=overwrite
        )
        options = ControllerOptions(cycle_ms, filter_hz, tool, zeroed_at, sensor, target, tuple(leave_out or ()))
        rows = row_options(convention, strict=strict)
        result = export_campaign(folder, context, output, raw_text=raw_text, loop=options, rows=rows)
        answer.show(result, after_export(folder, store))
    return OK

"""`stiffcal init`: a commented campaign folder to fill in, or one proposed from a table."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import AsJson, Overwrite
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.presentation.values import NextStep
from stiffcal.propose.templates import template_kinds

if TYPE_CHECKING:
    from stiffcal.propose.lines import Question


def init(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder to create.")],
    kind: Annotated[
        str | None,
        typer.Option(
            metavar=f"<{'|'.join(template_kinds())}>",
            help="Kind of campaign.",
        ),
    ] = None,
    table: Annotated[
        list[Path] | None,
        typer.Option(
            "--from",
            metavar="TABLE.csv",
            help="Propose the campaign from header and values of a table; repeat the option for each table of a set, "
            "or for each log of clamped and friction runs. Or from a folder of logs, some for each run.",
        ),
    ] = None,
    urdf: Annotated[Path | None, typer.Option(metavar="F", help="The robot as a URDF, or its package.")] = None,
    robot: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="A bundled robot (irb4400, …), a robot.toml, or a URDF."),
    ] = None,
    tool: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z",
            help="Where the load acts and the displacement is measured: m, in the flange frame (with --from).",
        ),
    ] = None,
    as_json: AsJson = False,
    overwrite: Overwrite = False,
) -> int:
    """Create a commented campaign folder, or propose one from a table or a folder of logs.

    What was guessed is marked with `# ?` in campaign.toml.

    Example: stiffcal init my-robot --kind load

    Example: stiffcal init my-robot --from table.csv --robot irb4400 --tool 0,0,0.2

    Example: stiffcal init my-robot --from my-robot/raw --robot irb4400

    Example: stiffcal init my-bench --kind clamped --from position1.csv --from position2.csv
    """
    with answering(as_json) as answer:
        from stiffcal.commands.init import init_campaign
        from stiffcal.compensation.option_words import tool_point

        at_terminal = sys.stdin.isatty() and not as_json
        if at_terminal and table:
            answer.progress.stop()
        point = None if tool is None else tool_point(tool)
        result = init_campaign(
            folder,
            kind=kind,
            tables=table or (),
            urdf=urdf,
            robot=robot,
            tool=point,
            ask=_ask if at_terminal else None,
            overwrite=overwrite,
        )
        once = "they are written" if result.to_write else ""
        answer.show(result, NextStep(command_line("check", folder), once))
    return OK


def _ask(question: Question) -> str:
    from stiffcal.propose.answers import numbers_of

    text = f"{question.table}.{question.key}: {question.text} (Enter: write it into campaign.toml later)"
    while answer := str(typer.prompt(text, default="", show_default=False, err=True)):
        try:
            numbers_of(answer, len(question.numbers))
            break
        except InputError as error:
            typer.echo(f"{error.faults[0].reason}; {error.faults[0].mend}", err=True)
    return answer

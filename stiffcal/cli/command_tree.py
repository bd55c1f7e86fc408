"""The tree of commands: which there are, and what reads their arguments.

Why a command is imported by its name, and the others are not: `stiffcal check` need not load their files, and a usage
error answers at once. Why a command that stands first is no part of a group: a group reads its own options first, for
which typer loads pydantic, and that alone takes as long as the rest of the start-up.
"""

from __future__ import annotations

import difflib
import importlib
import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

import typer
import typer.core

from stiffcal import __version__
from stiffcal.cli.common_options import CommonOptions, Debug, LogFile, Verbose, with_common_options
from stiffcal.cli.options import AsJson, Overwrite, StoreAt
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from typer._click.core import Command, Context

COMMANDS = {
    "init": "Create a commented campaign folder, or propose one from a table or a folder of logs.",
    "check": "Check the folder: what was read, what is missing.",
    "ingest": "Turn raw logs into load states in the Parquet store.",
    "identify": "Fit the model: each stiffness with its uncertainty.",
    "validate": "Validate the model in held-out poses, runs or regions.",
    "diagnose": "Find which physical effect the model lacks.",
    "improve": "Add what is missing, step by step, then remove what was added and is not needed.",
    "compare": "Compare two campaigns of one robot.",
    "trend": "Track one robot over many campaigns.",
    "history": "List every fit: model, error in held-out data, noise.",
    "plot": "Draw load against deformation, the residual, or what a fit's statistics hang on.",
    "report": "Write the report as a PDF (DIR/report.pdf).",
    "view": "Write one HTML file for a browser (DIR/view.html).",
    "run": "Check, ingest, identify, validate, diagnose, report and view in one go.",
    "batch": "Run many campaigns in parallel and check them against thresholds.",
    "export": "Write the states or the model for other programs, or as code for a controller.",
    "predict": "Predict deflection and stiffness under given loads.",
    "map": "Map deflection or stiffness over the workspace.",
    "compensate": "Correct the joint targets of a path with known forces.",
    "plan": "Plan which poses and loads to measure.",
    "simulate": "Simulate a campaign: raw logs of a known robot.",
    "effects": "List the physical effects, or explain one.",
    "add": "Add a physical effect to model.toml.",
    "remove": "Remove a physical effect from model.toml.",
    "trust": "List the code that a campaign folder would run, and allow it.",
    "demo": "Find a hidden effect in a bundled example.",
    "doctor": "List what is installed and what is missing.",
}
"""Every command, with the first line of its help: what the list of commands is made of without importing them all."""


Begin = Callable[[CommonOptions], None]
_HELP = {"help_option_names": ["-h", "--help"]}


def application(given: list[str], begin: Begin) -> Callable[[], object]:
    """Return the function that runs the arguments.

    Parameters
    ----------
    given : the arguments: a command with its own, or options that every command takes and then the command.
    begin : called once they are read, before the command runs.

    Raises
    ------
    typer.TyperException : they name a command that does not exist.
    """
    if given and not given[0].startswith("-"):
        command = command_named(given[0], begin)
        return lambda: command.main(args=given[1:], prog_name=f"stiffcal {given[0]}", standalone_mode=False)
    group = _group(begin)
    return lambda: group.main(args=given or ["--help"], prog_name="stiffcal", standalone_mode=False)


def command_named(name: str, begin: Begin = lambda options: None) -> typer.core.TyperCommand:
    """Return a command with all its options.

    Parameters
    ----------
    name : of the command. begin : as of `application`.

    Raises
    ------
    typer.TyperException : there is none of this name.
    """
    if name not in COMMANDS:
        suggestions = difflib.get_close_matches(name, COMMANDS, n=1)
        raise typer.TyperException(
            f"no such command: {name}" + (f", did you mean {suggestions[0]}?" if suggestions else "")
        )
    function = getattr(importlib.import_module(f"stiffcal.cli.{name}"), name)
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
    app.command(name, help=_help_of(function), context_settings=_HELP)(with_common_options(function, begin))
    command = typer.main.get_command(app)
    assert isinstance(command, typer.core.TyperCommand)
    return command


class _Commands(typer.core.TyperGroup):
    """All commands; options that stand before a command hold as if they stood after it."""

    begin: Begin

    def list_commands(self, ctx: Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: Context, cmd_name: str) -> typer.core.TyperCommand:
        return typer.core.TyperCommand(cmd_name, help=COMMANDS[cmd_name], rich_markup_mode=None)

    def resolve_command(self, ctx: Context, args: list[str]) -> tuple[str | None, Command | None, list[str]]:
        name, *rest = args
        command = command_named(name, self.begin)
        ctx.default_map = {name: {}}
        for parameter in self.params:
            if ctx.params.get(parameter.name or ""):
                same = [one.name for one in command.params if one.opts[:1] == parameter.opts[:1]]
                if not same:
                    ctx.fail(f"{name} has no option {parameter.opts[0]}")
                ctx.default_map[name][same[0]] = ctx.params[parameter.name or ""]
        return name, command, rest


def _group(begin: Begin) -> typer.core.TyperGroup:
    app = typer.Typer(
        cls=_Commands,
        help="Identify the stiffness of an industrial robot from load tests, and find the physical effect that its "
        "model lacks.",
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings=_HELP,
        epilog="DIR is a campaign folder (default: the current folder). Start with: stiffcal demo. The options above "
        "that are no answer of their own belong to the command, and may stand after its name too.",
    )
    app.callback()(_before_the_command)
    group = typer.main.get_command(app)
    assert isinstance(group, _Commands)
    group.begin = begin
    return group


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"stiffcal {__version__}")
        raise typer.Exit


def _print_completion(shell: str | None) -> None:
    from stiffcal.cli.completion import SHELLS, completion_script

    if shell is None:
        return
    if shell not in SHELLS:
        reason, mend = f"{shell} is no shell that is known", f"one of {', '.join(SHELLS)}"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--show-completion", reason, mend)
    typer.echo(completion_script(shell, COMMANDS), nl=False)
    raise typer.Exit


def _before_the_command(
    as_json: AsJson = False,
    store: StoreAt = None,
    overwrite: Overwrite = False,
    verbose: Verbose = False,
    log_file: LogFile = None,
    debug: Debug = False,
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_print_version, help="Print the version.")
    ] = False,
    show_completion: Annotated[
        str | None,
        typer.Option(
            "--show-completion",
            is_eager=True,
            callback=_print_completion,
            metavar="SHELL",
            help="Print the script that completes commands and options: bash, zsh or fish.",
        ),
    ] = None,
) -> None:
    """Read the options before the command; `_Commands` hands them on."""


def _help_of(function: Callable[..., Any]) -> str:
    """Return the docstring with its examples kept on lines of their own, to be copied whole."""
    text = inspect.cleandoc(function.__doc__ or "")
    return text.replace("\n\nExample: ", "\n\n\b\nExample: ")

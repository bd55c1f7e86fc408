"""The `stiffcal` command: finds the command's file, runs it, and turns every ending into an exit code.

Why the commands are imported by name: `stiffcal check` need not load the other files, and a usage error answers at
once.
"""

from __future__ import annotations

import difflib
import importlib
import inspect
import os
import sys
from collections.abc import Callable, Sequence

import typer

from stiffcal import __version__
from stiffcal.cli.endings import (
    INTERRUPTED,
    OK,
    WRONG_INPUT,
    report_fault,
    report_input_error,
    report_traceback,
    report_usage,
)
from stiffcal.cli.log import logging_to, taken_out
from stiffcal.cli.streams import guarded_streams
from stiffcal.cli.supervision import Supervision, supervised
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import refusal
from stiffcal.module_path import leave_out_current_folder, quiet_libraries
from stiffcal.trust.foreign_content import fault_of_foreign_content, use_own_results

COMMANDS = {
    "init": "Create a commented campaign folder, or propose one from a table.",
    "check": "Check the folder: what was read, what is missing.",
    "ingest": "Turn raw logs into load states in the Parquet store.",
    "identify": "Fit the model: each stiffness with its uncertainty.",
    "validate": "Validate the model in held-out poses, runs or regions.",
    "diagnose": "Find which physical effect the model lacks.",
    "improve": "Add what is missing, step by step, then remove what is not needed.",
    "compare": "Compare two campaigns of one robot.",
    "trend": "Track one robot over many campaigns.",
    "history": "List every fit: model, error in held-out data, noise.",
    "plot": "Draw load against deformation, or the residual.",
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

_WITH_EVERY_COMMAND = "All commands: --verbose logs each step to standard error, --log FILE to a file."


def main(arguments: Sequence[str] | None = None) -> None:
    """Run `stiffcal` with `arguments` (the process's own where None) and leave with its exit code."""
    leave_out_current_folder()
    use_own_results()
    given = list(sys.argv[1:] if arguments is None else arguments)
    if arguments is None and "--debug" not in given:
        quiet_libraries()
    with guarded_streams(), supervised(arguments is None, "--json" in given) as supervision:
        code = _run(given, supervision)
        if code != WRONG_INPUT:
            try:
                sys.stdout.flush()
            except InputError as error:
                report_input_error(error, as_json=False)
                code = WRONG_INPUT
        supervision.end(code)
    sys.exit(code)


def _run(given: list[str], supervision: Supervision) -> int:
    as_json = "--json" in given
    debug = "--debug" in given or bool(os.environ.get("STIFFCAL_DEBUG"))
    given = [word for word in given if word != "--debug"]
    try:
        # Not an option of the application: typer loads pydantic for the first option it reads, which doubles the
        # start-up.
        if "--version" in given[:1]:
            sys.stdout.write(f"stiffcal {__version__}\n")
            return OK
        if "--show-completion" in given[:1]:
            return _show_completion(given[1:])
        given, verbose, log = taken_out(given)
        with logging_to(verbose, log, given):
            code = supervision.run(_application(given))
    except InputError as error:
        report_input_error(error, as_json)
        return WRONG_INPUT
    except typer.TyperException as error:
        report_usage(error, given[0] if given and given[0] in COMMANDS else "", as_json)
        return WRONG_INPUT
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    except Exception as error:
        if debug:
            return report_traceback(error)
        refused = _refused(error) or fault_of_foreign_content(error)
        if refused is None:
            return report_fault(error, given, as_json)
        report_input_error(refused, as_json)
        return WRONG_INPUT
    # typer turns an interruption inside a command into this exit code, without a message
    if code == INTERRUPTED:
        sys.stderr.write(
            "interrupted; the store is intact: finished steps are kept, the interrupted one is discarded\n"
        )
    return code if isinstance(code, int) else OK


def _show_completion(shells: list[str]) -> int:
    from stiffcal.cli.completion import SHELLS, completion_script

    if len(shells) != 1 or shells[0] not in SHELLS:
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            "command line",
            "--show-completion",
            "it takes the name of one shell",
            f"one of {', '.join(SHELLS)}",
        )
    sys.stdout.write(completion_script(shells[0], COMMANDS))
    return OK


def _refused(error: Exception) -> InputError | None:
    """Return the machine's refusal as an error of the user's, None where it is a fault of ours."""
    if isinstance(error, MemoryError):
        reason = "not enough memory" + (f" ({error})" if str(error) else "")
        return InputError.at(
            FaultCode.SYSTEM_REFUSAL, "", "", reason, "use fewer rows or runs, or a machine with more memory"
        )
    return refusal(error) if isinstance(error, OSError) else None


def _application(given: list[str]) -> Callable[[], object]:
    """Return the function that runs the arguments.

    Why a named command stands alone, not in a group of all: a group reads its own options first, for which typer loads
    pydantic, and that alone takes as long as the rest of the start-up.

    Raises
    ------
    typer.TyperException : they name a command that does not exist.
    """
    named = given[0] if given and not given[0].startswith("-") else ""
    app = typer.Typer(
        help="Identify the stiffness of an industrial robot from load tests, and find the physical effect that its "
        "model lacks.",
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
        epilog="DIR is a campaign folder (default: the current folder). Start with: stiffcal demo. Completion of "
        "commands and "
        f"options with the tab key: stiffcal --show-completion bash|zsh|fish. {_WITH_EVERY_COMMAND}",
    )
    if not named:
        app.callback(invoke_without_command=True)(_without_command)
        for name, summary in COMMANDS.items():
            app.command(name, help=summary)(_only_listed)
        listing = typer.main.get_command(app)
        return lambda: listing.main(args=given, prog_name="stiffcal", standalone_mode=False)
    if named not in COMMANDS:
        suggestions = difflib.get_close_matches(named, COMMANDS, n=1)
        raise typer.TyperException(
            f"no such command: {named}" + (f", did you mean {suggestions[0]}?" if suggestions else "")
        )
    function = getattr(importlib.import_module(f"stiffcal.cli.{named}"), named)
    app.command(help=_help_of(function), epilog=_WITH_EVERY_COMMAND)(function)
    command = typer.main.get_command(app)
    return lambda: command.main(args=given[1:], prog_name=f"stiffcal {named}", standalone_mode=False)


def _only_listed() -> None:
    """Stand for a command in the list of commands."""


def _help_of(function: Callable[..., int]) -> str:
    """Return the docstring with its examples kept on lines of their own, to be copied whole."""
    text = inspect.cleandoc(function.__doc__ or "")
    return text.replace("\n\nExample: ", "\n\n\b\nExample: ")


def _without_command(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())

"""`stiffcal doctor`: what is installed, what is missing, how to get it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.cli.answers import NextLine, answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import AsJson
from stiffcal.cli.tables import plain_table
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from stiffcal.cli.console import AnswerConsole
    from stiffcal.commands.doctor import DoctorResult


def doctor(as_json: AsJson = False) -> int:
    """List what is installed and what is missing.

    With the command that installs missing libraries. Exit code 1: a required library is missing.

    Example: stiffcal doctor
    """
    with answering(as_json) as answer:
        try:
            from stiffcal.commands.doctor import examine_installation
        except ModuleNotFoundError as error:
            name = error.name or "a library"
            reason = "not installed, but required"
            mend = f"python -m pip install {name}"
            raise InputError.at(FaultCode.LIBRARY_MISSING, name, "", reason, mend) from error
        result = examine_installation()
        then = NextLine("stiffcal demo") if result.complete and not Path("demo").exists() else None
        answer.give(result, show_doctor, then)
    return OK if result.complete else NOT_HELD


def show_doctor(console: AnswerConsole, result: DoctorResult) -> None:
    """Write the table of libraries, then what is missing, each with the command that installs it."""
    console.print(f"stiffcal {result.version}, Python {result.python}, {result.platform}")
    table = plain_table("library", "version", "works with", "for")
    for library in result.libraries:
        table.add_row(library.name, library.version or "missing", library.required, library.purpose or "everything")
    console.print(table)
    console.print(
        f"reads logs of the formats {', '.join(result.formats)}", soft_wrap=True, markup=False, highlight=False
    )
    console.show_warnings(result.warnings)
    missing = [library for library in result.libraries if library.version is None]
    for command in dict.fromkeys(library.install for library in missing):
        names = ", ".join(library.name for library in missing if library.install == command)
        console.print(f"{names}: {command}", soft_wrap=True, markup=False, highlight=False)
    for plugin in result.plugins:
        console.print(f"installed {plugin}", soft_wrap=True, markup=False, highlight=False)
    if result.state_fault:
        text = f"{result.state_folder}: {result.state_fault}; nothing can be recorded as trusted"
        console.print(text, soft_wrap=True, markup=False, highlight=False)

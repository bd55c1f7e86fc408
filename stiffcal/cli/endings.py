"""How a command ends: the exit codes, and the messages when it did not go well."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Mapping
from typing import TYPE_CHECKING

from stiffcal import __version__
from stiffcal.cli.standard_error import for_terminal
from stiffcal.cli.streams import StandardStream
from stiffcal.errors import Fault, InputError, one_line
from stiffcal.escapes import shell
from stiffcal.escapes.json_text import document_text
from stiffcal.escapes.terminal import escaped_lines
from stiffcal.fault_codes import FaultCode
from stiffcal.fault_log import write_fault_log
from stiffcal.masking import mask

if TYPE_CHECKING:
    import typer

OK = 0
NOT_HELD = 1
"""Done, and a threshold or check did not hold."""
WRONG_INPUT = 2
INTERNAL_FAULT = 3
INTERRUPTED = 130
"""128 + SIGINT, as shells have it."""


def report_input_error(error: InputError, as_json: bool) -> None:
    """Print each fault on one line of standard error; with `as_json` the one document on standard output.

    Notes of the error, such as the next step, stand below them.
    """
    if as_json:
        first, *further = (fault.as_document() for fault in error.faults)
        document: dict[str, object] = {"error": first}
        if further:
            document["others"] = further
        if _print_document(document):
            return
    for fault in error.faults:
        sys.stderr.write(for_terminal(str(fault)) + "\n")
    for note in getattr(error, "__notes__", ()):
        sys.stderr.write("\n" + for_terminal(mask(note)) + "\n")


def report_usage(error: typer.TyperException, command: str, as_json: bool) -> None:
    """Report what is wrong with the command line itself, and where the help is of `command` (of all where "")."""
    mend = f"see stiffcal {command} --help" if command else "see stiffcal --help"
    reason = mask(one_line(" ".join(error.format_message().split())).rstrip("."))
    fault = Fault(FaultCode.COMMAND_LINE, "", "command line", reason, mend)
    if not (as_json and _print_document({"error": fault.as_document()})):
        sys.stderr.write(for_terminal(str(fault)) + "\n")


def report_fault(error: Exception, arguments: list[str], as_json: bool) -> int:
    """Write the traceback of an internal fault to a log file, print in one line where it is; return the exit code."""
    text = one_line(" ".join(str(error).split()))
    log = write_fault_log(error, __version__, f"stiffcal {' '.join(map(shell.escaped, arguments))}")
    reason = mask(f"internal fault, not your input: {type(error).__name__}: {text}")
    mend = f"please report it with the log file {log}" if log else "please report it; no log file could be written"
    fault = Fault(FaultCode.INTERNAL_FAULT, log or "", "stiffcal", reason, mend)
    if not (as_json and _print_document({"error": fault.as_document()})):
        sys.stderr.write(for_terminal(f"{reason}; {mend} (--debug shows the traceback) [{fault.code}]") + "\n")
    return INTERNAL_FAULT


def report_traceback(error: Exception) -> int:
    """Print the traceback of an internal fault, for who asked with --debug; return the exit code."""
    sys.stderr.write(escaped_lines(mask("".join(traceback.format_exception(error)))))
    return INTERNAL_FAULT


def _print_document(document: Mapping[str, object]) -> bool:
    """Print a document; return False where standard output does not take it."""
    try:
        sys.stdout.write(document_text(document) + "\n")
        sys.stdout.flush()
    except InputError:
        return False
    return not (isinstance(sys.stdout, StandardStream) and sys.stdout.lost)

"""The `stiffcal` command: runs what the arguments name, and turns every ending into an exit code."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence
from contextlib import ExitStack

import typer

from stiffcal.cli.command_tree import COMMANDS, application
from stiffcal.cli.common_options import CommonOptions
from stiffcal.cli.endings import (
    INTERRUPTED,
    OK,
    WRONG_INPUT,
    report_fault,
    report_input_error,
    report_traceback,
    report_usage,
)
from stiffcal.cli.log import logging_to
from stiffcal.cli.streams import guarded_streams
from stiffcal.cli.supervision import Supervision, supervised
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import refusal
from stiffcal.module_path import leave_out_current_folder, quiet_libraries
from stiffcal.trust.foreign_content import fault_of_foreign_content, use_own_results

__all__ = ["COMMANDS", "main"]

# The libraries and ourselves are some 200 000 objects that stay to the end. At Python's 700 they are searched for
# unused ones a tenth of a short command's time; so many unused ones take some megabytes.
OBJECTS_BETWEEN_COLLECTIONS = 20_000


def main(arguments: Sequence[str] | None = None) -> None:
    """Run `stiffcal` with `arguments` (the process's own where None) and leave with its exit code."""
    leave_out_current_folder()
    use_own_results()
    if arguments is None:
        gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS)
        # pyarrow's own allocator keeps what the tables of a store took, of three thousand runs 50 MB
        os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")
        # pydantic looks through all installed packages for plugins: of no use here, a twentieth of a short command
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    given = list(sys.argv[1:] if arguments is None else arguments)
    if arguments is None and not _has(given, "--debug"):
        quiet_libraries()
    with guarded_streams(), supervised(arguments is None, _has(given, "--json")) as supervision:
        code = _run(given, supervision)
        if code != WRONG_INPUT:
            try:
                sys.stdout.flush()
            except InputError as error:
                report_input_error(error, as_json=False)
                code = WRONG_INPUT
        supervision.end(code)
    sys.exit(code)


def _has(given: Sequence[str], option: str) -> bool:
    """Return whether an option is given: how a mistake in the arguments themselves is reported depends on it."""
    return option in (given[: given.index("--")] if "--" in given else given)


def _run(given: list[str], supervision: Supervision) -> int:
    as_json = _has(given, "--json")
    debug = bool(os.environ.get("STIFFCAL_DEBUG"))
    try:
        with ExitStack() as log:

            def begin(options: CommonOptions) -> None:
                nonlocal debug
                debug = debug or options.debug
                log.enter_context(logging_to(options, given))

            code = supervision.run(application(given, begin))
    except InputError as error:
        report_input_error(error, as_json)
        return WRONG_INPUT
    except typer.TyperException as error:
        report_usage(error, next((word for word in given if word in COMMANDS), ""), as_json)
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


def _refused(error: Exception) -> InputError | None:
    """Return the machine's refusal as an error of the user's, None where it is a fault of ours."""
    if isinstance(error, MemoryError):
        reason = "not enough memory" + (f" ({error})" if str(error) else "")
        return InputError.at(
            FaultCode.SYSTEM_REFUSAL, "", "", reason, "use fewer rows or runs, or a machine with more memory"
        )
    return refusal(error) if isinstance(error, OSError) else None

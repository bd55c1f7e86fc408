"""`stiffcal doctor`: what is installed, what is missing, how to get it."""

from __future__ import annotations

from pathlib import Path

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import AsJson
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.presentation.values import NextStep


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
        then = NextStep("stiffcal demo") if result.complete and not Path("demo").exists() else None
        answer.show(result, then)
    return OK if result.complete else NOT_HELD

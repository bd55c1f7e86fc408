"""The next command of the loop: identify, validate, diagnose, add what is missing, report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.answers import command_line

if TYPE_CHECKING:
    from pathlib import Path

    from stiffcal.diagnosis.results import DiagnoseResult
    from stiffcal.results.validate_result import ValidateResult


def after_validation(folder: Path, result: ValidateResult, store: str | None) -> str:
    """Return `diagnose` where the error in held-out poses exceeds the noise, or no noise is known; else `report`."""
    from stiffcal.diagnosis.thresholds import ADEQUATE_RATIO

    noise = {} if result.noise is None else dict(result.noise.items())
    errors = {name: value for name, value in result.rms.items() if value is not None}
    adequate = [value <= ADEQUATE_RATIO * (noise.get(name) or 0.0) for name, value in errors.items()]
    return command_line("report" if adequate and all(adequate) else "diagnose", folder, store=store)


def after_diagnosis(folder: Path, result: DiagnoseResult, store: str | None, finished: str = "report") -> str:
    """Return what the answer of `diagnose` calls for.

    Parameters
    ----------
    folder : the campaign folder. result : of its present model. store : where results are kept; None: in the folder.
    finished : the command where the model needs no change.
    """
    # What is missing comes first: with it, other effects may turn out to be needed, or not.
    if result.missing or result.superfluous:
        return command_line("improve", folder, store=store)
    if result.pattern is not None:
        from stiffcal.diagnosis.words import suggested_name
        from stiffcal.escapes import shell

        return f"stiffcal effects new {suggested_name(result.pattern)} --from {shell.escaped_path(str(folder))}"
    return command_line(finished, folder, store=store)

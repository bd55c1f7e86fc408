"""The next command of the loop: identify, validate, diagnose, add what is missing, report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.answers import command_line

if TYPE_CHECKING:
    from pathlib import Path

    from stiffcal.diagnosis.results import DiagnoseResult
    from stiffcal.measurements.rms import Rms
    from stiffcal.results.history_results import HistoryResult
    from stiffcal.results.validate_result import ValidateResult
    from stiffcal.workflow.check_results import CheckResult
    from stiffcal.workflow.improve_results import ImproveResult
    from stiffcal.workflow.steps import RunContext


def after_validation(folder: Path, result: ValidateResult, store: str | None) -> str:
    """Return `diagnose` where the error in held-out poses exceeds the noise, or no noise is known; else `report`."""
    return _after_error(folder, result.rms, result.noise, store, ("report",))


def _after_error(folder: Path, rms: Rms, known_noise: Rms | None, store: str | None, finished: tuple[str, ...]) -> str:
    words = finished if is_within_noise(rms, known_noise) else ("diagnose",)
    return command_line(words[0], folder, *words[1:], store=store)


def is_within_noise(rms: Rms, known_noise: Rms | None) -> bool:
    """Return whether every measure of an error is known to be no larger than the noise allows."""
    from stiffcal.diagnosis.thresholds import ADEQUATE_RATIO

    noise = {} if known_noise is None else dict(known_noise.items())
    errors = {name: value for name, value in rms.items() if value is not None}
    adequate = [value <= ADEQUATE_RATIO * (noise.get(name) or 0.0) for name, value in errors.items()]
    return bool(adequate) and all(adequate)


def after_pictures(folder: Path, context: RunContext, store: str | None, finished: tuple[str, ...]) -> str:
    """Return the step that the present model calls for, as the store knows it.

    Parameters
    ----------
    folder : the campaign folder. context : with its store. store : where results are kept; None: in the folder.
    finished : the command, and its options, where the model needs no change.

    Raises
    ------
    InputError : the folder holds no campaign.
    """
    from stiffcal.workflow.history import read_history

    return _after_fits(folder, context, read_history(folder, context), store, finished)


def after_export(folder: Path, context: RunContext, store: str | None) -> str:
    """Return the step that the present model calls for; of a finished one the comparison with a later campaign.

    Parameters
    ----------
    folder : the campaign folder. context : with its store. store : where results are kept; None: in the folder.

    Raises
    ------
    InputError : the folder holds no campaign.
    """
    from stiffcal.workflow.history import read_history

    result = read_history(folder, context)
    if not result.fits:  # the values are those of model.toml
        return command_line("predict", folder, "--poses", "poses.csv", store=store)
    return _after_fits(folder, context, result, store, ("compare", "LATER_DIR"))


def after_check(folder: Path, result: CheckResult, store: str | None) -> str:
    """Return `run` of a campaign that is ready, `plan` where joints lack load, else `check` again.

    Parameters
    ----------
    folder : the campaign folder. result : of `check`. store : where results are kept; None: in the folder.
    """
    if result.ready:
        return command_line("run", folder, store=store)
    if lacks_load(result):
        force = max((run.largest_force_N or 0.0 for run in result.runs), default=0.0)
        return command_line("plan", folder, *(("--force", f"{force:.0f}") if force >= 1.0 else ()), store=store)
    return command_line("check", folder, store=store)


def lacks_load(result: CheckResult) -> bool:
    """Return whether nothing is missing but loads that identify some joints."""
    from stiffcal.reduction.excitation import NOT_KNOWN

    spreads = [joint.expected_relative_std for joint in result.joints or []]
    lacking = [spread for spread in spreads if spread is None or spread > NOT_KNOWN]
    return bool(lacking) and len(result.missing) == len(lacking)


def _after_fits(
    folder: Path, context: RunContext, result: HistoryResult, store: str | None, finished: tuple[str, ...]
) -> str:
    from stiffcal.workflow.history import diagnosis_of_fit

    is_fitted = bool(result.fits) and result.not_fitted_yet is None
    diagnosis = diagnosis_of_fit(folder, context, result.fits[-1].id) if is_fitted else None
    return after_history(folder, result, diagnosis, store, finished)


def after_improvement(folder: Path, result: ImproveResult, is_dry_run: bool, store: str | None) -> str:
    """Return `improve` where an effect was not added, `diagnose` where adding left something, else `report`.

    Parameters
    ----------
    folder : the campaign folder. result : of `improve`. is_dry_run : whether nothing was to be added.
    store : where results are kept; None: in the folder.
    """
    has_changed = any(step.action in ("add", "remove") for step in result.steps)
    if result.missing and (is_dry_run or not has_changed):
        return command_line("improve", folder, store=store)
    return command_line("diagnose" if result.missing or result.unexplained else "report", folder, store=store)


def after_history(
    folder: Path,
    result: HistoryResult,
    diagnosis: DiagnoseResult | None,
    store: str | None,
    finished: tuple[str, ...] = ("report",),
) -> str:
    """Return the step that follows the last fit.

    Parameters
    ----------
    folder : the campaign folder. result : its fits. diagnosis : of the last fit; None where there is none.
    store : where results are kept; None: in the folder.
    finished : the command, and its options, where the model needs no change.
    """
    if not result.fits or result.not_fitted_yet is not None:
        return command_line("identify", folder, store=store)
    last = result.fits[-1]
    if last.heldout_rms is None:
        return command_line("validate", folder, store=store)
    if diagnosis is not None:
        return after_diagnosis(folder, diagnosis, store, finished)
    return _after_error(folder, last.heldout_rms, last.noise, store, finished)


def after_diagnosis(
    folder: Path, result: DiagnoseResult, store: str | None, finished: tuple[str, ...] = ("report",)
) -> str:
    """Return what the answer of `diagnose` calls for.

    Parameters
    ----------
    folder : the campaign folder. result : of its present model. store : where results are kept; None: in the folder.
    finished : the command, and its options, where the model needs no change.
    """
    if result.missing or result.everywhere is not None:
        return command_line("improve", folder, store=store)
    if result.pattern is not None:
        from stiffcal.diagnosis.words import suggested_name
        from stiffcal.escapes import shell

        return f"stiffcal effects new {suggested_name(result.pattern)} --from {shell.escaped_path(str(folder))}"
    return command_line(finished[0], folder, *finished[1:], store=store)

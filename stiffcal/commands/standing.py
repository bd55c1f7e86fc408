"""What is known of a campaign and its present model: the next step is decided from it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.model.model_file import MODEL_FILE, load_model
from stiffcal.commands.history import read_history
from stiffcal.diagnosis.answers.outcome import DiagnosisOutcome
from stiffcal.results.next_step import Standing
from stiffcal.stages.steps import DIAGNOSE, RunContext, open_store, stored_result

if TYPE_CHECKING:
    from stiffcal.results.history_results import HistoryResult


def standing_of(folder: Path, context: RunContext, history: HistoryResult | None = None) -> Standing:
    """Return what is known of a campaign; nothing is computed.

    Parameters
    ----------
    folder : the campaign folder; its logs may be missing. context : with its store.
    history : of the campaign, where it is read already.

    Raises
    ------
    InputError : the folder holds no campaign.
    """
    history = history or read_history(folder, context)
    logs_missing = not history.fits and not logs_complete(folder)
    if not history.fits or history.not_fitted_yet is not None:
        return Standing(
            logs_missing=logs_missing,
            is_fitted=False,
            is_ingested=bool(history.fits) or is_read(folder, context),
            has_effects=has_effects(folder),
        )
    last = history.fits[-1]
    diagnosis = _outcome_of_fit(folder, context, last.id)
    return Standing(
        logs_missing=logs_missing,
        is_fitted=True,
        heldout_rms=last.heldout_rms,
        noise=last.noise,
        diagnosis=diagnosis,
        untested=_untested_effect(folder, context, diagnosis),
    )


def is_read(folder: Path, context: RunContext) -> bool:
    """Return whether logs have been read and accepted into the store before."""
    from stiffcal.ingest.parts import INGEST

    return INGEST in open_store(Path(folder), context).documents


def has_effects(folder: Path) -> bool:
    """Return whether the model has any effect; True where there is no model.toml.

    Raises
    ------
    InputError : the model file is faulty.
    """
    path = Path(folder)
    # of how many joints they are does not matter: the logs are not looked for once more
    return not (path / MODEL_FILE).exists() or bool(load_model(path, n_joints=0).effects)


def logs_complete(folder: Path) -> bool:
    """Return whether every log that campaign.toml names is there.

    Raises
    ------
    InputError : the folder holds no campaign.
    """
    from stiffcal.ingest.sources import manifest_data_files

    campaign = load_campaign(folder, check_files=False)
    return all((campaign.folder / file).exists() for file in manifest_data_files(campaign))


def _outcome_of_fit(folder: Path, context: RunContext, fit_id: str) -> DiagnosisOutcome | None:
    """Return what a stored diagnosis leads to where it is of that fit, else None."""
    outcome = stored_result(open_store(Path(folder), context), DIAGNOSE, DiagnosisOutcome)
    return outcome if outcome is not None and outcome.fit_id == fit_id else None


def _untested_effect(folder: Path, context: RunContext, outcome: DiagnosisOutcome | None) -> str | None:
    """Return the name of the effect that would test the pattern which a diagnosis found.

    None where it found none, or the effect's file is written already.
    """
    if outcome is None or outcome.pattern is None:
        return None
    from stiffcal.commands.new_effect import file_of_effect
    from stiffcal.diagnosis.answers.results import DiagnoseResult
    from stiffcal.diagnosis.words import suggested_name

    whole = stored_result(open_store(Path(folder), context), DIAGNOSE, DiagnoseResult)
    if whole is None or whole.pattern is None:
        return None
    name = suggested_name(whole.pattern)
    return None if (Path(folder) / file_of_effect(name)).exists() else name

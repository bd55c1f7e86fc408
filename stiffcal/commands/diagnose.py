"""Diagnose the model: what it lacks, and what looks alike."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.stages.diagnoses.current import current_diagnosis
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import DIAGNOSE, RunContext, up_to_date_states

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.results import DiagnoseResult


def diagnose_campaign(folder: Path, context: RunContext | None = None) -> DiagnoseResult:
    """Diagnose the present model.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.

    Returns
    -------
    DiagnoseResult
        Where nothing has changed since the last diagnosis, that one's.

    Raises
    ------
    InputError : the input is wrong.
    """
    context = context or RunContext()
    data = up_to_date_states(folder, context)
    identified = up_to_date_fit(data, context)
    stored, _ = current_diagnosis(data, identified)
    if stored is not None:
        return replace(stored, origin=data.store.origin_of(DIAGNOSE))
    from stiffcal.stages.diagnoses.anew import diagnose_anew

    return diagnose_anew(data, identified, context)

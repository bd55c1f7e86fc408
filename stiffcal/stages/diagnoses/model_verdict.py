"""What the last diagnosis says of the model, for files that others rely on."""

from __future__ import annotations

from pathlib import Path

from stiffcal.compensation.exports.controller import ModelVerdict
from stiffcal.compensation.fitted_robot import FittedRobot
from stiffcal.stages.diagnoses.current import current_diagnosis
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.wording import place


def model_verdict(folder: Path, context: RunContext, fitted: FittedRobot) -> ModelVerdict:
    """Return whether the present fit is complete by its last diagnosis."""
    from stiffcal.ingest.sources import manifest_data_files

    if not all((folder / file).exists() for file in manifest_data_files(fitted.campaign)):
        return ModelVerdict(False, "NOT VERIFIED: the values are those of model.toml, without measurements")
    data = up_to_date_states(folder, context)
    diagnosis, reason = current_diagnosis(data, up_to_date_fit(data, context))
    if diagnosis is None:
        return ModelVerdict(False, f"NOT VERIFIED: {reason}")
    missing = ", ".join(f"{proposed.effect} {place(proposed.where)}".strip() for proposed in diagnosis.missing)
    if missing:
        return ModelVerdict(False, f"INCOMPLETE: by “stiffcal diagnose” the model lacks {missing}")
    if diagnosis.adequate:
        return ModelVerdict(True, "by “stiffcal diagnose” the model is complete: the remaining error is noise")
    if diagnosis.adequate is None:
        return ModelVerdict(False, "NOT VERIFIED: the noise is unknown, so “stiffcal diagnose” cannot judge the model")
    return ModelVerdict(False, "INCOMPLETE: by “stiffcal diagnose” part of the error is not explained by any effect")

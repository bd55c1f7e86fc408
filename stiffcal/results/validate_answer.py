"""From a validation of load states to what ``validate`` answers."""

from __future__ import annotations

from stiffcal.measurements.load_states import LoadStates
from stiffcal.reduction.loads.cycles import BRANCH_NAMES, find_load_cycles
from stiffcal.results.validate_result import ValidateResult
from stiffcal.validation.results import WorstState
from stiffcal.validation.validate import Validation


def validate_result(states: LoadStates, validation: Validation) -> ValidateResult:
    """Return the result of ``validate`` for load states alone, but for the verdict on thresholds.

    Parameters
    ----------
    states : the campaign's load states.
    validation : of them.
    """
    cycles, heldout = find_load_cycles(states), validation.heldout
    warnings = []
    if heldout.scheme == "none":
        warnings.append("a single pose: the error in held-out poses cannot be estimated, this is the error of the fit")
    noise_known = any(value is not None for _, value in validation.noise.items())
    if not noise_known:
        warnings.append("the noise is unknown: whether the model is good enough cannot be judged")
    return ValidateResult(
        warnings=warnings,
        scheme=heldout.scheme,
        n_states=heldout.data.n_measured,
        n_poses=int(heldout.fold.max(initial=-1)) + 1,
        rms=validation.rms,
        max=validation.max,
        noise=validation.noise if noise_known else None,
        relative=validation.relative,
        zero_model=validation.zero_model,
        by_run=validation.by["run"],
        by_direction=validation.by["direction"],
        by_load=validation.by["load"],
        by_branch=validation.by["branch"],
        by_joint_angle=validation.by["joint_angle"],
        by_body=validation.by.get("body"),
        by_experiment=validation.by.get("experiment"),
        worst=[
            WorstState(
                run=states.runs[states.run[i]].name,
                row=int(states.row[i]),
                residual_m=residual.translation,
                residual_rad=residual.motor_angle,
                load=float(cycles.magnitude[i]),
                branch=BRANCH_NAMES[cycles.branch[i]],
            )
            for i, residual in validation.worst
        ],
    )

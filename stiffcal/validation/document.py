"""A validation as the JSON interface writes it."""

from __future__ import annotations

from typing import Any

from stiffcal.identification.document import finite
from stiffcal.measurements.load_states import LoadStates
from stiffcal.reduction.load_cycles import BRANCH_NAMES, find_load_cycles
from stiffcal.validation.validate import Slice, Validation

SCHEMA = "stiffcal/validate/1"


def _slice_document(error_slice: Slice) -> dict[str, Any]:
    document = {
        "label": error_slice.label,
        "low": finite(error_slice.low),
        "high": finite(error_slice.high),
        "n": error_slice.n,
        "rms": error_slice.rms,
        "max": error_slice.largest,
    }
    return document if error_slice.zero_model is None else document | {"zero_model": error_slice.zero_model}


def validation_document(states: LoadStates, validation: Validation) -> dict[str, Any]:
    """Return the document of ``validate`` but for the verdict on its thresholds (`stiffcal.validation.thresholds`).

    Parameters
    ----------
    states : the campaign's load states.
    validation : what was found.
    """
    cycles = find_load_cycles(states)
    warnings = []
    if validation.heldout.scheme == "none":
        warnings.append("a single pose: the error in unseen poses cannot be estimated, this is the error of the fit")
    if validation.noise["translation"] is None:
        warnings.append("the noise is not known: whether the model is good enough cannot be judged")
    return {
        "schema": SCHEMA,
        "warnings": warnings,
        "scheme": validation.heldout.scheme,
        "n_states": validation.heldout.data.n_measured,
        "n_poses": int(validation.heldout.fold.max(initial=-1)) + 1,
        "rms": validation.rms,
        "max": validation.largest,
        "noise": validation.noise if validation.noise["translation"] is not None else None,
        "relative": validation.relative,
        "zero_model": validation.zero_model,
        **{
            f"by_{name}": [_slice_document(error_slice) for error_slice in parts]
            for name, parts in validation.by.items()
        },
        "worst": [
            {
                "run": states.runs[states.run[i]].name,
                "row": int(states.row[i]),
                "residual_m": length,
                "load": float(cycles.magnitude[i]),
                "branch": BRANCH_NAMES[cycles.branch[i]],
            }
            for i, length in validation.worst
        ],
    }

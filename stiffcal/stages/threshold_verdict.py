"""Thresholds of a campaign: from the manifest or a file, with the baseline they name, and the verdict."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.campaign.manifest.thresholds import ThresholdsFile, strange_joints
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.reach import escapes, leads_outside
from stiffcal.documents import Document
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import read_regular
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.model.summary import Where
from stiffcal.revision import REVISION
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import Ingested, RunContext, up_to_date_states

if TYPE_CHECKING:
    from stiffcal.campaign.manifest.thresholds import Thresholds
    from stiffcal.validation.results import Verdict
    from stiffcal.validation.thresholds import Baseline, HeldoutErrors

_LARGEST = 1e150
"""Of a baseline's numbers: those whose squares are numbers too."""
MODEL_SCHEMAS = ("stiffcal/model-export/1", "stiffcal/identify/1")


def check_thresholds(
    data: Ingested,
    parameters: Sequence[IdentifiedParameter],
    validation: HeldoutErrors,
    context: RunContext,
    file: ThresholdsFile | None = None,
) -> Verdict:
    """Hold a validated fit to the campaign's thresholds.

    Parameters
    ----------
    parameters : of the fit. validation : its errors in held-out poses.
    file : thresholds that the manifest may only tighten.

    Returns
    -------
    Verdict
        One check for each threshold and joint.

    Raises
    ------
    InputError : the thresholds name a joint or a baseline that does not exist, or one the user has not named.
    """
    from stiffcal.validation.results import Verdict
    from stiffcal.validation.thresholds import judge, not_counted

    campaign = data.campaign
    limits, requested = campaign.manifest.thresholds, None
    if file is not None:
        requested = file.own_limits(campaign.name, campaign.folder.resolve().name)
        limits = file.limits_for(campaign.name, campaign.folder.resolve().name, limits)
        for key, name in strange_joints(limits, data.joint_names):
            mend = "use " + ", ".join(data.joint_names)
            raise InputError.at(
                FaultCode.JOINT_UNKNOWN, "thresholds", f"{key}.{name}", f"{campaign.name} has no such joint", mend
            )
    if limits.max_drift and limits.baseline is None:
        mend = "state the campaign or model to compare with: baseline = …"
        raise InputError.at(FaultCode.KEY_MISSING, MANIFEST_FILE, "thresholds.max_drift", "no baseline is stated", mend)
    if data.uncounted:
        # Not even looked at: a baseline would be computed for nothing.
        checks = judge(limits, parameters, validation, data.joint_names, None)
        return Verdict(not_counted(checks, data.uncounted), limits.written())
    checks = judge(limits, parameters, validation, data.joint_names, _baseline(data, limits, context), requested)
    return Verdict(checks, limits.written())


def _baseline(data: Ingested, limits: Thresholds, context: RunContext) -> Baseline | None:
    if limits.baseline is None:
        return None
    from stiffcal.validation.thresholds import Baseline

    name = limits.baseline
    path = (data.campaign.folder / name).resolve()
    place = "thresholds.baseline"
    outside = escapes(name) or leads_outside(data.campaign.folder, name) is not None
    if outside and not any(path.is_relative_to(folder.resolve()) for folder in context.reach):
        reason = f'"{name}" lies outside the campaign folder'
        mend = "name it in a file of thresholds of your own (--thresholds FILE), or name one inside the campaign folder"
        raise InputError.at(FaultCode.FILE_OUTSIDE, MANIFEST_FILE, place, reason, mend)
    if not path.exists():
        mend = "name a campaign folder, or a model written by stiffcal export DIR -o baseline.json"
        raise InputError.at(FaultCode.FILE_MISSING, MANIFEST_FILE, place, f"no such file or folder: {name}", mend)
    if path.is_dir():
        return Baseline(path.name, {parameter.name: parameter for parameter in _fit_of(path, name, context)})
    parameters, revision = _read_model(path, name)
    return Baseline(name, {parameter.name: parameter for parameter in parameters}, revision != REVISION)


def _fit_of(path: Path, label: str, context: RunContext) -> list[IdentifiedParameter]:
    """Return the parameters of a baseline's campaign; a fit that does not count is no baseline."""
    data = up_to_date_states(path, replace(context, store=None))
    if data.uncounted:
        mend = "add its logs, or use a baseline of your own"
        raise InputError.at(
            FaultCode.CONTENT_UNTRUSTED, MANIFEST_FILE, "thresholds.baseline", f"{label}: {data.uncounted}", mend
        )
    return up_to_date_fit(data, context).parameters


def _read_model(path: Path, label: str) -> tuple[list[IdentifiedParameter], object]:
    """Return the parameters of an exported model and the revision that computed it, None where that is not stated."""
    mend = "write it with stiffcal export DIR -o baseline.json"
    try:
        document = json.loads(read_regular(path, label))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError.at(FaultCode.SYNTAX_INVALID, label, "", f"cannot be read as a model ({error})", mend) from None
    if not isinstance(document, dict) or document.get("schema") not in MODEL_SCHEMAS:
        raise InputError.at(FaultCode.FORMAT_UNKNOWN, label, "schema", "not a fitted model", mend)
    parameters = document.get("parameters")
    if not isinstance(parameters, list) or not all(map(_is_parameter, parameters)):
        raise InputError.at(FaultCode.KEY_MISSING, label, "parameters", "a parameter is incomplete", mend)
    return [_parameter(entry) for entry in parameters], document.get("revision")


def _parameter(entry: Document) -> IdentifiedParameter:
    """Return a parameter of an exported model, of which no more than `_is_parameter` asks for need be there."""
    stiffness, std = (
        None if "stiffness" not in entry else math.nan if entry.get(key) is None else entry[key]
        for key in ("stiffness", "stiffness_std")
    )
    return IdentifiedParameter(
        name=entry["name"],
        effect=entry["effect"],
        where=Where(**{kind: entry["where"][kind] for kind in ("joints", "links", "pairs") if kind in entry["where"]}),
        value=entry["value"],
        std=entry["std"],
        interval=None,
        unit=entry["unit"],
        fixed=entry.get("fixed") is True,
        identifiable=entry["value"] is not None,
        stiffness=stiffness,
        stiffness_std=std,
    )


def _is_parameter(entry: object) -> bool:
    """Return whether this is a parameter of a fit. NaN is none: no comparison with it would fail."""
    if not isinstance(entry, dict) or not {"name", "effect", "where", "unit", "value", "std"} <= set(entry):
        return False
    where = entry["where"]
    joints = where.get("joints", []) if isinstance(where, dict) else None
    return (
        all(isinstance(entry[key], str) for key in ("name", "effect", "unit"))
        and isinstance(joints, list)
        and all(isinstance(joint, int) for joint in joints)
        and all(_is_number_or_none(entry.get(key)) for key in ("value", "std", "stiffness", "stiffness_std"))
    )


def _is_number_or_none(value: object) -> bool:
    if value is None:
        return True
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _LARGEST

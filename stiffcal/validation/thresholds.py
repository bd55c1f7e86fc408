"""Holding a validated fit to thresholds: each one judged by itself, with its number, its limit, and a sentence.

Works on the results of `identify` and `validate`, so that a verdict can be had again without computing anything.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from stiffcal.campaign.manifest.thresholds import ALL_JOINTS, Thresholds
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.measurements.rms import Rms
from stiffcal.quantity import ANGLE, LENGTH, ShownUnit
from stiffcal.uncertainty import NORMAL_95
from stiffcal.validation.change import CHANCE, change_of
from stiffcal.validation.compare_result import Change
from stiffcal.validation.results import ThresholdCheck
from stiffcal.validation.schemes import held_out
from stiffcal.wording import in_unit, share, significant

JOINT_STIFFNESS_UNIT = "N·m/rad"
_COMPLIANCE_UNIT = "rad/(N·m)"


class HeldoutErrors(Protocol):
    """Errors in held-out data, as the result of `validate` has them."""

    @property
    def scheme(self) -> str:
        """How data were left out."""

    @property
    def rms(self) -> Rms:
        """Of the residual."""

    @property
    def noise(self) -> Rms | None:
        """What the instruments scatter; None where it is not known."""

    @property
    def relative(self) -> Rms:
        """Residual over displacement, a share in each measure."""


@dataclass(frozen=True)
class Baseline:
    """An earlier fit of the same robot."""

    name: str
    """How the user calls it."""
    parameters: dict[str, IdentifiedParameter]
    """Of its fit, by name."""
    other_revision: bool = False
    """Whether another revision of stiffcal computed it: what that changed is no wear."""


def judge(
    limits: Thresholds,
    parameters: Sequence[IdentifiedParameter],
    validation: HeldoutErrors,
    joint_names: Sequence[str],
    baseline: Baseline | None,
    asked: Thresholds | None = None,
) -> list[ThresholdCheck]:
    """Judge every threshold.

    A model that fixes a joint's stiffness, or has none of a joint, leaves nothing measured to judge. The model is its
    author's: where somebody else asks for the threshold, it is then not held.

    Parameters
    ----------
    limits : what is asked.
    parameters : of the fit. validation : its errors in held-out poses.
    joint_names : of the robot, J of them.
    baseline : the earlier fit, where `limits` name one.
    asked : those of `limits` that somebody else than the campaign's author asks for, None where there are none.
    """
    checks = [*_errors(limits, validation), *_stiffnesses(limits, parameters, joint_names, asked)]
    if baseline is not None:
        checks += _drifts(limits, parameters, joint_names, baseline, asked)
    return checks


def not_counted(checks: Sequence[ThresholdCheck], why: str) -> list[ThresholdCheck]:
    """Return the checks of results that do not count: none is judged, and a failed one gives the reason."""
    text = f"{why}: no threshold can be judged"
    rms_left = [
        replace(check, held=None, says=f"{check.threshold} {check.where}".strip() + " is not judged")
        for check in checks
    ]
    return [ThresholdCheck("origin", "", 0.0, None, "", False, text), *rms_left]


def _errors(limits: Thresholds, validation: HeldoutErrors) -> list[ThresholdCheck]:
    rms, error = validation.rms, validation.rms.translation
    scatter = None if validation.noise is None else validation.noise.translation
    left_out = held_out(validation.scheme)
    over = error / scatter if scatter and error is not None else None
    asked = (
        ("max_rms_m", limits.max_rms_m, error, "m", f"rms in {left_out}", LENGTH.usual),
        ("max_rms_rad", limits.max_rms_rad, rms.rotation, "rad", f"rms rotation in {left_out}", ANGLE.usual),
        ("max_relative", limits.max_relative, validation.relative.translation, "", "relative error", ShownUnit("")),
        ("max_over_noise", limits.max_over_noise, over, "", "error over noise", ShownUnit("")),
    )
    checks = []
    for name, limit, value, unit, quantity, shown in asked:
        if limit is None:
            continue
        bound = f"{name} = {in_unit(limit, shown)}"
        if value is None:
            checks.append(
                ThresholdCheck(name, "", limit, None, unit, None, f"{quantity} is not known: {bound} cannot be judged")
            )
            continue
        satisfied = value <= limit
        text = f"{quantity} {in_unit(value, shown)} is {'within' if satisfied else 'above'} {bound}"
        checks.append(ThresholdCheck(name, "", limit, value, unit, satisfied, text))
    return checks


def _joint_stiffnesses(
    parameters: Sequence[IdentifiedParameter], joint_names: Sequence[str]
) -> list[tuple[IdentifiedParameter, str, str]]:
    """Return the parameters that are a stiffness of one joint, with its name, and how a sentence is to call them."""
    stiffnesses = [
        (parameter, joint_names[joints[0] - 1])
        for parameter in parameters
        if len(joints := parameter.where.joints or []) == 1
        and parameter.is_compliance
        and parameter.unit == _COMPLIANCE_UNIT
    ]
    count_of_joint = Counter(joint for _, joint in stiffnesses)
    return [
        (parameter, joint, f"{joint} ({parameter.name})" if count_of_joint[joint] > 1 else joint)
        for parameter, joint in stiffnesses
    ]


def _limit_of(limits: Thresholds, joint: str) -> float | None:
    return limits.min_stiffness.get(joint, limits.min_stiffness.get(ALL_JOINTS))


def _stiffnesses(
    limits: Thresholds, parameters: Sequence[IdentifiedParameter], joint_names: Sequence[str], asked: Thresholds | None
) -> list[ThresholdCheck]:
    """Hold each joint's stiffness against its limit; joints of which the model has none too, where it is asked for."""
    stiffnesses = _joint_stiffnesses(parameters, joint_names)
    present = {joint for _, joint, _ in stiffnesses}
    absent = [joint for joint in joint_names if joint not in present and asked is not None and _limit_of(asked, joint)]
    checks = []
    for parameter, joint, label in [*stiffnesses, *((None, joint, joint) for joint in absent)]:
        limit = _limit_of(limits, joint)
        if limit is None:
            continue
        if parameter is not None and not parameter.fixed:
            checks.append(_stiffness(parameter, label, limit))
            continue
        subject = (
            f"the model has no stiffness of {label}"
            if parameter is None
            else f"the model fixes the stiffness of {label}"
        )
        satisfied = False if asked is not None and _limit_of(asked, joint) is not None else None
        text = f"{subject}, no measurement: min_stiffness {significant(limit)} {JOINT_STIFFNESS_UNIT} cannot be judged"
        checks.append(ThresholdCheck("min_stiffness", joint, limit, None, JOINT_STIFFNESS_UNIT, satisfied, text))
    return checks


def _stiffness(parameter: IdentifiedParameter, joint: str, limit: float) -> ThresholdCheck:
    unit, value = JOINT_STIFFNESS_UNIT, parameter.known_stiffness
    bound = f"min_stiffness {significant(limit)} {unit}"
    if parameter.value is None:
        text = f"stiffness of {joint} cannot be identified from these data: {bound} cannot be judged"
        return ThresholdCheck("min_stiffness", joint, limit, None, unit, None, text)
    if value is None:
        return ThresholdCheck(
            "min_stiffness", joint, limit, None, unit, True, f"no compliance was measured at {joint}: above {bound}"
        )
    satisfied = value >= limit
    text = f"stiffness of {joint} {significant(value)} {unit} is {'above' if satisfied else 'below'} {bound}"
    return ThresholdCheck("min_stiffness", joint, limit, value, unit, satisfied, text)


def _drifts(
    limits: Thresholds,
    parameters: Sequence[IdentifiedParameter],
    joint_names: Sequence[str],
    baseline: Baseline,
    asked: Thresholds | None,
) -> list[ThresholdCheck]:
    """Hold each joint's stiffness against the baseline's.

    Why two conditions: a change that chance makes is no drift, however large; a sure one below `max_drift` is allowed.
    """
    stiffnesses = _joint_stiffnesses(parameters, joint_names)
    shared = [
        (joint, label, change_of(baseline.parameters[parameter.name], parameter))
        for parameter, joint, label in stiffnesses
        if parameter.name in baseline.parameters and not parameter.fixed
    ]
    judged = sum(change.p_value is not None for _, _, change in shared)
    checks = []
    for joint, label, change in shared:
        limit = limits.max_drift.get(joint, limits.max_drift.get(ALL_JOINTS, 0.0))
        check = _drift(label, change, limit, judged, baseline.name)
        if check.held is False and baseline.other_revision:
            reason = f"another revision of stiffcal computed {baseline.name}: export it again to judge its drift"
            check = replace(check, held=None, says=f"{check.says}, but {reason}")
        checks.append(check)
    compared_joints = {joint for joint, _, _ in shared}
    for joint in [
        name
        for name in joint_names
        if name not in compared_joints and (name in limits.max_drift or not compared_joints)
    ]:
        text = f"{baseline.name} and this fit share no stiffness of {joint}: its drift cannot be judged"
        checks.append(ThresholdCheck("max_drift", joint, limits.max_drift.get(joint, 0.0), None, "", None, text))
    measured = {parameter.name for parameter, _, _ in stiffnesses if not parameter.fixed}
    satisfied = False if asked is not None and asked.baseline is not None else None
    for name, earlier in baseline.parameters.items():
        of_a_joint = len(earlier.where.joints or []) == 1 and earlier.unit == _COMPLIANCE_UNIT
        if of_a_joint and earlier.known_stiffness and name not in measured:
            text = f"{baseline.name} has {name}, which this model does not measure: its drift cannot be judged"
            checks.append(
                ThresholdCheck("max_drift", "", limits.max_drift.get(ALL_JOINTS, 0.0), None, "", satisfied, text)
            )
    return checks


def _drift(joint: str, change: Change, limit: float, judged: int, name: str) -> ThresholdCheck:
    before, after = change.before.known_stiffness, change.after.known_stiffness
    bound = f"max_drift {share(limit)}" if limit else "no significant drift"
    value, p_value, std = change.before.value, change.p_value, change.std
    if not before or not after or not value or p_value is None or std is None:
        text = f"stiffness of {joint} is not known here or in {name}: {bound} cannot be judged"
        return ThresholdCheck("max_drift", joint, limit, None, "", None, text)
    drift, chance = after / before - 1.0, min(p_value * judged, 1.0)
    stiffnesses = f"{significant(after)} and {significant(before)} N·m/rad"
    words = f"stiffness of {joint} is {'+' * (drift > 0.0)}{share(drift)} against {name} ({stiffnesses})"
    # 1.96 standard uncertainties of the relative change: smaller drifts these two fits cannot detect.
    blur = NORMAL_95 * std / abs(value)
    if abs(drift) > limit and chance < CHANCE:
        return ThresholdCheck(
            "max_drift", joint, limit, drift, "", False, f"{words}, p = {significant(chance, 1)}: above {bound}"
        )
    if limit and blur > limit:
        text = f"{words}, uncertainty ± {share(blur, 2)}: {bound} cannot be judged"
        return ThresholdCheck("max_drift", joint, limit, drift, "", None, text)
    return ThresholdCheck("max_drift", joint, limit, drift, "", True, f"{words}: within {bound}")

"""What is missing from a model of load states, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.diagnosis.answers.heldout_results import ErrorAsValidated
from stiffcal.diagnosis.answers.pattern_results import CompliancePattern
from stiffcal.diagnosis.answers.results import ResidualDependence
from stiffcal.diagnosis.answers.setting_results import SettingKind
from stiffcal.diagnosis.thresholds import LEAST_EXPLAINED, REPORTED_LINGERING
from stiffcal.diagnosis.words import error_in_words, leading_measure, pattern_in_words
from stiffcal.identification.answers.document import noise_not_known, overstated_noise_in_words, wrong_geometry_in_words
from stiffcal.judgement.diagnosed import DiagnosedStates
from stiffcal.judgement.numbers import FEW_POSES
from stiffcal.judgement.sentences import answer_of
from stiffcal.measurements.rms import Rms
from stiffcal.validation.schemes import held_out
from stiffcal.wording import percent, probability_in_words, significant


def summary_of(
    found: DiagnosedStates,
    before: Rms,
    noise: Rms | None,
    validated: ErrorAsValidated | None,
    structure: Sequence[ResidualDependence],
    pattern: CompliancePattern | None,
) -> str:
    """Return the answer in a few sentences.

    Parameters
    ----------
    found : what is missing. before : rms in held-out poses. noise : in the same measure.
    validated : the error by the scheme of ``validate``, where that is another.
    structure, pattern : what the remaining error follows.
    """
    against = _against(before, noise, validated)
    texts = [_contradicted(found)] if found.reading.settings else []
    geometry = found.wrong_geometry
    if geometry is not None and geometry.explains >= LEAST_EXPLAINED and not found.adequate:
        texts.append(
            f"Errors of the robot's geometry explain {percent(geometry.explains)} of the avoidable error, of the "
            "size that absolute positions show: correct robot.toml before adding any effect."
        )
    texts += answer_of(found, against, structure, noise)
    if found.unexplained and pattern is not None:
        texts.append(f"Probable location: {pattern_in_words(pattern)}.")
    return " ".join(texts)


def _contradicted(found: DiagnosedStates) -> str:
    """Return the settings that the data contradict, with what to write in their place."""
    free = {parameter.name: parameter for parameter in found.last.fit.parameters}
    held = {parameter.name: parameter for parameter in found.first.fit.parameters}
    words = []
    for one in found.reading.settings:
        setting, p = one.setting, probability_in_words(one.probability)
        if setting.kind is SettingKind.BALANCE:
            words.append(f'balance = "first-order" of model.toml ({p}; use "deformed")')
        elif setting.kind is SettingKind.TOOL:
            words.append(f"a tool that campaign.toml does not state ({p}; give its mass)")
        elif setting.kind is SettingKind.FRAME:
            words.append(f"{setting.name.replace('.', ' ')} as campaign.toml gives it ({p}; write estimate = true)")
        else:
            own, fixed = free[setting.name], held[setting.name].value or 0.0
            value = f"{significant(own.value or 0.0)} ± {significant(own.std or 0.0, 2)}"
            words.append(f"{setting.name} fixed at {significant(fixed)} in model.toml ({p}; free, it is {value})")
    return f"The data contradict settings: {', '.join(words)}. Without that:"


def _against(before: Rms, noise: Rms | None, validated: ErrorAsValidated | None) -> str:
    """Return the present model's errors next to the noise."""
    measure = leading_measure(before)
    error = dict(before.items()).get(measure) or 0.0
    floor = dict(noise.items()).get(measure) if noise is not None else None
    text = f"{error_in_words(error, measure)} in held-out poses"
    reached = None if validated is None else dict(validated.rms.items()).get(measure)
    if validated is not None and reached is not None:
        text += f", {error_in_words(reached, measure)} in {held_out(validated.scheme)}"
    return text + (f", noise {error_in_words(floor, measure)}" if floor else "")


def warnings_on(found: DiagnosedStates) -> list[str]:
    """Return what limits the answer, as sentences."""
    texts = []
    if not found.noise_known and (found.found or found.unexplained):
        texts.append(noise_not_known("the share of noise in the error is unknown", found.first.fit))
    elif not found.noise_known:
        texts.append(noise_not_known("whether the model is good enough cannot be judged", found.first.fit))
    n_folds = len(found.first.folds)
    if n_folds < FEW_POSES:
        texts.append(f"only {n_folds} poses: the error in held-out poses is poorly determined")
    if found.wrong_geometry is not None:
        texts.append(wrong_geometry_in_words(found.wrong_geometry.misfit, found.first.fit.robot))
    now, noise = found.after, found.first.fit.noise
    if now is not None and noise is not None:
        texts += overstated_noise_in_words(noise, now.statistic, now.dof[0])
    if now is None or found.unexplained:
        return texts
    if now.lag_one_correlation > REPORTED_LINGERING and not now.drifts:
        texts.append(
            f"successive readings have correlated errors (correlation {significant(now.lag_one_correlation, 2)}): "
            "slowly varying noise (air, temperature, a filter), so the uncertainties are larger than stated; wait "
            "longer between readings"
        )
    if not now.adequate:
        texts.append(
            f"the remaining error is {significant(now.ratio, 2)} times the noise that is known, and "
            f"no effect, mistake or law "
            "is probable: check sigma in campaign.toml, or repeat loads to measure the noise"
        )
    return texts

"""What is missing from a model of load states, as `diagnose` answers it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.diagnosis.answers.results import (
    DiagnoseResult,
    Finding,
    LawCurveAt,
)
from stiffcal.diagnosis.answers.setting_results import ContradictedSetting
from stiffcal.diagnosis.refits.heldout_error import (
    as_validated,
    errors_by_experiment,
    left_out_rms,
    rms_after_choosing,
    size_at_tool,
)
from stiffcal.diagnosis.remainder.patterns import find_pattern
from stiffcal.diagnosis.remainder.structure import what_it_follows
from stiffcal.diagnosis.scans.lack_of_fit import against_noise
from stiffcal.diagnosis.scans.ranking import effect_at
from stiffcal.diagnosis.scans.scan import Trial
from stiffcal.diagnosis.words import explain
from stiffcal.identification.answers.before_after import BeforeAfter, estimated_parameters, values_before_and_after
from stiffcal.identification.answers.document import identified_parameter
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.geometry import with_geometry
from stiffcal.judgement.answers import (
    candidates_of,
    excluded_sizes_of,
    pace_of,
    proposed,
    ranked_findings,
    superfluous_of,
    undecided_effects,
    unknown_laws,
)
from stiffcal.judgement.curves import curve_of
from stiffcal.judgement.diagnosed import DiagnosedStates
from stiffcal.judgement.excluded import ExcludedSize
from stiffcal.judgement.reading import UnlistedFound
from stiffcal.judgement.sentences_of_states import summary_of, warnings_on
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import EffectAt


def diagnosis_result(found: DiagnosedStates) -> DiagnoseResult:
    """Return the result document of ``diagnose``.

    Returns
    -------
    DiagnoseResult
        ``next_measurement`` is left for who can plan measurements, ``suspects``, ``evidence``, ``fit_id`` and ``key``
        for readers who know the campaign.
    """
    states, first, last, reading = found.kept_states, found.first, found.last, found.reading
    before = left_out_rms(first, None)
    changed = bool(found.found or reading.settings)
    with_missing = left_out_rms(last, None) if changed else before
    validated = as_validated(states, first.fit, last.fit if changed else None)
    unexplained = found.unexplained
    pattern = find_pattern(last.fit, states) if unexplained else None
    structure = what_it_follows(last, states) if unexplained is not False else []
    parameters = _identified(states, last.fit) if found.found else []
    explained = found.explained
    n_effects, n_shapes = found.n_members
    noise = Rms.of(last.fit.noise_length) if found.noise_known else None
    return DiagnoseResult(
        warnings=warnings_on(found),
        adequate=found.adequate,
        noise=noise,
        rms=before,
        as_validated=validated,
        lack_of_fit=against_noise(found.before),
        missing=proposed(found.found),
        in_model=proposed(found.held),
        p_nothing=reading.p_nothing,
        p_unknown=reading.p_unknown,
        unknown=unknown_laws(found, lambda law: _curve(found, law)),
        not_weighed=reading.not_weighed,
        excluded_sizes=excluded_sizes_of(found, "m", lambda one: _deciding_force(found, one)),
        contradicted=list(_contradicted(found, before, with_missing)),
        undecided=undecided_effects(found),
        could_be=[],
        findings=_findings(found, before),
        next_measurement=None,
        not_tried=list(found.not_tried),
        unexplained=unexplained,
        pattern=pattern,
        structure=structure,
        wrong_geometry=found.wrong_geometry,
        explained_by_missing=None if explained is None else explained.share,
        explained_interval=None if explained is None else [explained.low, explained.high],
        heldout_rms_with_missing=with_missing,
        heldout_rms_after_choosing=rms_after_choosing(first),
        parameters_with_missing=parameters,
        before_after=_before_after(found, parameters),
        n_candidates=n_effects,
        n_signatures=n_shapes,
        pace=pace_of(found),
        summary=summary_of(found, before, noise, validated, structure, pattern),
        superfluous=superfluous_of(found),
        evidence=[],
        fit_id="",
        key="",
    )


def _curve(found: DiagnosedStates, law: UnlistedFound) -> LawCurveAt | None:
    curve = curve_of(found.judged, f"{law.place}: {law.follows}")
    if curve is None:
        return None
    chain = found.first.fit.robot.chain
    moved, over = (
        int(name.rpartition(":")[2].split()[-1]) in chain.prismatic_joints for name in (law.place, curve.over)
    )
    length, load = ("m", "N") if moved else ("rad", "N*m")
    angle, torque = ("m", "N") if over else ("rad", "N*m")
    return LawCurveAt(
        over=curve.over,
        unit=torque if curve.over.startswith("torque") else angle,
        value_unit=f"{length}/({load})" if curve.per_load else length,
        at=curve.at.tolist(),
        value=curve.value.tolist(),
    )


def _deciding_force(found: DiagnosedStates, one: ExcludedSize) -> float | None:
    """Return the force, N, that would show it where it is as large as the noise.

    None where these loads do, none would, or the robot cannot bear it.
    """
    force = float(np.linalg.norm(found.kept_states.wrench[:, :3], axis=1).max(initial=0.0))
    noise = found.first.fit.noise_length.get("translation") if found.noise_known else None
    if noise and force > 0.0 and one.grows_with_load and noise < one.size < np.inf:
        chain, deciding = found.first.fit.robot.chain, force * one.size / noise
        return deciding if deciding <= chain.largest_payload * float(np.linalg.norm(chain.gravity)) else None
    return None


def _contradicted(found: DiagnosedStates, before: Rms, after: Rms) -> Iterator[ContradictedSetting]:
    """Give the settings that the data contradict."""
    values = {parameter.name: parameter for parameter in found.last.fit.parameters}
    held = {parameter.name: parameter.value for parameter in found.first.fit.parameters}
    candidates = candidates_of(found)
    for one in found.reading.settings:
        setting = one.setting
        free = values.get(setting.name)
        yield ContradictedSetting(
            setting=setting.kind,
            parameter=setting.name or None,
            fixed_at=held.get(setting.name),
            free_value=None if free is None else free.value,
            free_std=None if free is None else free.std,
            probability=one.probability,
            heldout_rms_before=before,
            heldout_rms_after=after,
            alternatives=[effect_at(candidates[name]) for name in one.alike],
        )


def _alike_to(found: DiagnosedStates, name: str) -> list[EffectAt]:
    """Return the effects that stand in one group with a member that is none."""
    candidates = candidates_of(found)
    return [
        effect_at(candidates[other])
        for group in found.reading.groups
        if any(member == name for member, _ in group.members)
        for other, _ in group.members
        if other in candidates
    ]


def _identified(states: LoadStates, fit: Fit) -> list[IdentifiedParameter]:
    """Return the parameters as ``identify`` answers them, the geometry's tolerance in their uncertainties."""
    by_temperature = fit.data.order.logs_temperature
    parameters = with_geometry(fit, states).parameters
    return [identified_parameter(parameter, by_temperature=by_temperature) for parameter in parameters]


def _before_after(found: DiagnosedStates, parameters: list[IdentifiedParameter]) -> list[BeforeAfter]:
    """Return what adding all that is missing does to the identified values."""
    if not found.found:
        return []
    present = estimated_parameters(_identified(found.kept_states, found.first.fit))
    return values_before_and_after(present, estimated_parameters(parameters))


def _findings(found: DiagnosedStates, before: Rms) -> list[Finding]:
    """Return every effect as the next single step."""
    scan = found.first
    ranking = ranked_findings(
        found,
        before,
        rms_after_choosing(scan),
        lambda trial: left_out_rms(scan, trial),
        lambda trial, after, alike: explain(scan, trial, before, after, alike),
    )
    return [
        replace(
            finding,
            size_m=size_at_tool(scan, trial),
            places=trial.places,
            by_experiment=errors_by_experiment(scan, trial) or None,
        )
        for trial, finding in ranking
    ]


def look_alike_pairs(found: DiagnosedStates, most: int) -> list[tuple[Trial, Trial]]:
    """Return the first missing effect with each of its foremost look-alikes, where the present model shows both."""
    if not found.found:
        return []
    leader = found.trial_of(found.found[0].candidate)
    others = [found.trial_of(candidate) for candidate, _ in found.found[0].alternatives[:most]]
    return [] if leader is None else [(leader, other) for other in others if other is not None]


def explaining_run(found: DiagnosedStates, run: int) -> list[EffectAt]:
    """Return effects that explain a run nearly as well as that it is off."""
    candidates, judged = candidates_of(found), found.judged
    names = {one.name for one in judged.members if any(off.run == run for off in one.off)}
    grouped = [effect for name in sorted(names) for effect in _alike_to(found, name)]
    aside = [name for off, effects in judged.explained.items() if off.run == run for name in effects]
    return [*grouped, *(effect_at(candidates[name]) for name in aside if name in candidates)]

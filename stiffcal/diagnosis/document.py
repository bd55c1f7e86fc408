"""What a search found, as `diagnose` answers it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.heldout_error import (
    as_validated,
    errors_by_experiment,
    left_out_rms,
    rms_after_choosing,
    size_at_tool,
)
from stiffcal.diagnosis.heldout_results import ErrorAsValidated
from stiffcal.diagnosis.judge import LackOfFit
from stiffcal.diagnosis.naming import near_best
from stiffcal.diagnosis.pattern_results import CompliancePattern
from stiffcal.diagnosis.patterns import find_pattern
from stiffcal.diagnosis.ranking import effect_at, ranked_findings
from stiffcal.diagnosis.results import (
    DiagnoseResult,
    Finding,
    LookAlike,
    ProposedEffect,
    SearchPace,
    UndecidedEffect,
)
from stiffcal.diagnosis.scan import Trial
from stiffcal.diagnosis.search_results import MissingEffect, Search
from stiffcal.diagnosis.search_warnings import search_warnings
from stiffcal.diagnosis.setting_results import SettingKind
from stiffcal.diagnosis.structure import what_it_follows
from stiffcal.diagnosis.thresholds import LEAST_EXPLAINED, MOST_UNDERSTATED, PAIRS_PLANNED
from stiffcal.diagnosis.words import (
    candidate_in_words,
    effect_in_words,
    error_in_words,
    explain,
    leading_measure,
    pattern_in_words,
)
from stiffcal.identification.before_after import BeforeAfter, estimated_parameters, values_before_and_after
from stiffcal.identification.document import finite, identified_parameter
from stiffcal.identification.fit import Fit
from stiffcal.identification.fit_results import IdentifiedParameter
from stiffcal.identification.geometry import with_geometry
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.measurements.rms import Rms, VarianceRatio
from stiffcal.model.summary import EffectAt, Where
from stiffcal.validation.schemes import held_out
from stiffcal.wording import variable


def against_noise(lack: LackOfFit | None) -> VarianceRatio | None:
    """Return residuals against noise; None where that is not known."""
    if lack is None:
        return None
    return VarianceRatio(statistic=lack.statistic, dof=[lack.dof[0], finite(lack.dof[1])], p_value=lack.p_value)


def proposed(missing_effect: MissingEffect) -> ProposedEffect:
    """Return an effect to add."""
    at = effect_at(missing_effect.candidate)
    alternatives = [
        LookAlike(effect=candidate.effect.name, where=Where.of(candidate.place), cosine=cosine)
        for candidate, cosine in zip(missing_effect.alternatives, missing_effect.cosines, strict=True)
    ]
    return ProposedEffect(
        effect=at.effect, where=at.where, alternatives=alternatives, form=dict(missing_effect.form) or None
    )


def _by_effect(candidates: tuple[Candidate, ...]) -> list[EffectAt]:
    """Return effects, each with all its places."""
    places: dict[str, dict[str, list[Any]]] = {}
    for candidate in candidates:
        where = places.setdefault(candidate.effect.name, {})
        for kind, items in Where.of(candidate.place).items():
            where.setdefault(kind, []).extend(items)
    return [
        EffectAt(effect=name, where=Where(**{kind: sorted(items) for kind, items in where.items()}))
        for name, where in places.items()
    ]


def diagnosis_result(states: LoadStates, search: Search) -> DiagnoseResult:
    """Return the result document of ``diagnose``.

    Parameters
    ----------
    states : the campaign's load states.
    search : what was found.

    Returns
    -------
    DiagnoseResult
        ``next_measurement`` is left for who can plan measurements (`look_alike_pairs`), ``superfluous``,
        ``evidence``, ``fit_id`` and ``key`` for readers who know the campaign.
    """
    scan = search.first
    noise = Rms.of(search.final.noise_length) if search.final.noise is not None else None
    before = left_out_rms(scan, None)
    adequate = None if search.before is None else not search.tried and search.before.adequate
    if search.contradicted:
        adequate = False
    if _too_few_to_judge(search):
        adequate = None
    pattern = find_pattern(search.final if search.found else scan.fit, states) if search.unexplained else None
    remainder = what_it_follows(search.final_scan if search.found else scan, states)
    with_missing = left_out_rms(search.final_scan, None) if search.found else before
    validated = as_validated(states, scan.fit, search.final if search.found else None)
    parameters = _identified(states, search.final) if search.found else []
    return DiagnoseResult(
        warnings=search_warnings(search),
        adequate=adequate,
        noise=noise,
        rms=before,
        as_validated=validated,
        lack_of_fit=against_noise(search.before),
        missing=[proposed(missing_effect) for missing_effect in search.found],
        contradicted=list(search.contradicted),
        undecided=_undecided(states, search),
        could_be=_by_effect(search.could_be),
        findings=_findings(search, before),
        next_measurement=None,
        not_tried=list(search.not_tried),
        unexplained=search.unexplained or None if search.after is None else search.unexplained,
        pattern=pattern,
        structure=remainder if search.unexplained or search.after is None else [],
        wrong_geometry=search.wrong_geometry,
        explained_by_missing=search.explained.share if search.tried else None,
        explained_interval=[search.explained.low, search.explained.high] if search.tried else None,
        heldout_rms_with_missing=with_missing,
        heldout_rms_after_choosing=rms_after_choosing(scan),
        parameters_with_missing=parameters,
        before_after=_before_after(states, search, parameters),
        n_candidates=len(scan.trials),
        n_signatures=scan.n_tried,
        pace=SearchPace(
            models=search.pace.models,
            candidates=search.pace.candidates,
            signatures=search.pace.regressors,
            seconds=search.pace.seconds,
            candidates_per_second=search.pace.candidates / search.pace.seconds,
        ),
        summary="".join(
            (
                _contradicted_words(search),
                summary(search, before, noise, validated),
                _evidence_sentence(search, states),
                _next_sentence(search),
                _pattern_sentence(pattern),
            )
        ),
        superfluous=[],
        evidence=[],
        fit_id="",
        key="",
    )


def _identified(states: LoadStates, fit: Fit) -> list[IdentifiedParameter]:
    """Return the parameters as ``identify`` answers them, the geometry's tolerance in their uncertainties."""
    by_temperature = fit.data.order.logs_temperature
    parameters = with_geometry(fit, states).parameters
    return [identified_parameter(parameter, by_temperature=by_temperature) for parameter in parameters]


def _before_after(states: LoadStates, search: Search, parameters: list[IdentifiedParameter]) -> list[BeforeAfter]:
    """Return what adding all that is missing does to the identified values."""
    if not search.found:
        return []
    present = estimated_parameters(_identified(states, search.first.fit))
    return values_before_and_after(present, estimated_parameters(parameters))


def _undecided(states: LoadStates, search: Search) -> list[UndecidedEffect]:
    """Return the effects between which single poses decide, of the first missing effect where they do."""
    scan, data = search.first, search.first.fit.data
    runs = [
        list(dict.fromkeys(states.runs[k].name for k in data.run[members]))
        for members in members_of(scan.fold_of_state)
    ]
    return [
        UndecidedEffect(
            effect=at.effect,
            where=at.where,
            share=rival.share,
            deciding_runs=[name for fold in rival.deciding for name in runs[fold]],
        )
        for rival in search.undecided
        for at in (effect_at(rival.candidate),)
    ]


def _findings(search: Search, before: Rms) -> list[Finding]:
    """Return the ranking for the next single step, best first."""
    scan = search.first
    ranking = ranked_findings(
        scan,
        before,
        rms_after_choosing(scan),
        lambda trial: left_out_rms(scan, trial),
        lambda trial, after, alternatives: explain(scan, trial, before, after, alternatives),
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


def look_alike_pairs(search: Search) -> list[tuple[Trial, Trial]]:
    """Return the first missing effect with each of its foremost look-alikes."""
    near = near_best(search.first) if search.tried else []
    return [(near[0], alternative) for alternative in near[1 : 1 + PAIRS_PLANNED]]


def _missing_effect_in_words(missing_effect: MissingEffect) -> str:
    """Return a missing effect in words, with the number of other candidates that look the same."""
    n_alternatives = len(missing_effect.alternatives)
    name = candidate_in_words(missing_effect.candidate)
    if not n_alternatives:
        return name
    if n_alternatives == 1:
        return f"{name} (or {candidate_in_words(missing_effect.alternatives[0])}, which cannot be distinguished)"
    return f"{name} (or one of {n_alternatives} others that cannot be distinguished in these poses)"


def _contradicted_words(search: Search) -> str:
    """Return the settings that the data contradict, as the beginning of the answer; "" where there are none."""
    words = []
    for setting in search.contradicted:
        if setting.parameter is None:
            words.append('balance = "first-order" (use "deformed")')
        elif setting.setting is SettingKind.FRAME:
            alike = ", ".join(effect_in_words(effect) for effect in setting.alternatives)
            cure = "write estimate = true" + (f"; cannot be distinguished in these poses: {alike}" if alike else "")
            words.append(f"{setting.parameter.replace('.', ' ')} as campaign.toml gives it ({cure})")
        else:
            free = f"{setting.free_value or 0.0:.3g} ± {setting.free_std or 0.0:.2g}"
            words.append(f"{setting.parameter} fixed at {setting.fixed_at or 0.0:.3g} (free, it is {free})")
    files = " and ".join(
        file
        for file, frames in (("model.toml", False), ("campaign.toml", True))
        if any((setting.setting is SettingKind.FRAME) == frames for setting in search.contradicted)
    )
    return f"The data contradict settings of {files}: {', '.join(words)}. Without that: " if words else ""


def _next_sentence(search: Search) -> str:
    """Return between which effects a lesser one is undecided; "" where none is."""
    between = " and ".join(candidate_in_words(rival.candidate) for rival in search.undecided_next)
    return (
        (f" A further effect is undecided between {between}: add this one first, then diagnose again.")
        if between
        else ""
    )


def _evidence_sentence(search: Search, states: LoadStates) -> str:
    """Return by what an unexplained remainder shows where no noise is known; "" where a noise is."""
    if search.after is not None or not search.unexplained or search.many_laws:
        return ""
    follows = [dependence.follows for dependence in what_it_follows(search.final_scan, states)]
    if not follows:
        return ""
    added = " with it in the model" if search.tried else ""
    what = variable(follows[0])
    return f" The noise is unknown, but the remaining error{added} depends on {what}: an effect is missing."


def _pattern_sentence(pattern: CompliancePattern | None) -> str:
    return "" if pattern is None else f" Probable location: {pattern_in_words(pattern)}."


def lower_tenth(share: float) -> float:
    """Return the percentage next below a share, in tenths: 1.0 is "at least 99.9 %", nothing is at least nothing."""
    return max(math.ceil(1000.0 * share) - 1, 0) / 10.0


def share_in_words(search: Search) -> str:
    """Return which share of the error goes with what is missing, with its 95 % interval."""
    explained = search.explained
    avoidable = "avoidable error" if search.after is not None else "squared error"
    low, share, high = (f"{100.0 * value:.0f}" for value in (explained.low, explained.share, explained.high))
    if low == high:
        # Ends that are printed alike would look exact.
        low, high = (f"{100.0 * value:.1f}".removesuffix(".0") for value in (explained.low, explained.high))
    # Still alike to a tenth: the lower end rounded down is what the data support.
    interval = f"95 %: {low} to {high} %" if low != high else f"95 %: at least {lower_tenth(explained.low):.1f} %"
    verb = "explain" if len(search.found or search.tried) > 1 else "explains"
    return f"{verb} {share} % ({interval}) of the {avoidable}"


def _too_few_to_judge(search: Search) -> bool:
    """Return whether absolute places are fitted to within the noise, and miss by far where they are left out.

    So it is where the poses hardly outnumber the parameters: the error of the fit is no evidence about the model.
    """
    if search.before is None or search.tried or search.unexplained or not search.first.fit.data.absolute.any():
        return False
    return search.before.ratio > MOST_UNDERSTATED


def summary(search: Search, before: Rms, noise: Rms | None, validated: ErrorAsValidated | None) -> str:
    """Return the answer in one or two sentences."""
    measure = leading_measure(before)
    error = dict(before.items()).get(measure) or 0.0
    floor = dict(noise.items()).get(measure) if noise is not None else None
    against = f"{error_in_words(error, measure)} in held-out poses"
    reached = None if validated is None else dict(validated.rms.items()).get(measure)
    if validated is not None and reached is not None:
        against += f", {error_in_words(reached, measure)} in {held_out(validated.scheme)}"
    against += f", noise {error_in_words(floor, measure)}" if floor else ""
    if not search.tried and search.before is None and not search.unexplained:
        return (
            "Nothing is supported; without a known noise it cannot be judged whether the model is good enough "
            f"({against})."
        )
    if _too_few_to_judge(search):
        return (
            f"Whether anything is missing cannot be judged: {len(search.first.folds)} poses determine the "
            f"{search.first.n_columns} parameters of the model and leave too few to validate it ({against}); measure "
            "more poses."
        )
    if not search.tried and not search.unexplained and search.before is not None and not search.before.adequate:
        return (
            "No effect is missing: the remaining error depends on no variable; the noise is probably larger than "
            "stated "
            f"({against})."
        )
    if not search.tried and not search.unexplained:
        return f"Nothing is missing: the error is that of the instruments ({against})."
    names = " and ".join(_missing_effect_in_words(missing_effect) for missing_effect in search.found)
    if search.undecided:
        between = " and ".join(candidate_in_words(rival.candidate) for rival in search.undecided)
        reason = "without one of the poses another of them explains the error better"
        if not any(rival.deciding for rival in search.undecided):
            reason = "these and more cannot be distinguished in these poses and loads"
        return f"Undecided between {between}: {reason} ({against})."
    share = share_in_words(search)
    if search.found and search.before is None and not search.unexplained:
        doubt = "without a known noise it cannot be judged whether more is missing"
        return f"Missing: {names}, which {share} ({against}); {doubt}."
    if search.found and not search.unexplained:
        return f"Missing: {names}, which {share} ({against})."
    if search.found and search.before is not None and not search.explained.whole:
        return f"Part of it: {names}, which {share}; no effect of the catalogue explains the rest ({against})."
    if search.found:
        rest = "and something else that no effect of the catalogue explains"
        return f"Missing: {names}, which {share}; {rest} ({against})."
    if search.wrong_geometry is not None and search.wrong_geometry.explains >= LEAST_EXPLAINED:
        return (
            f"Errors of the robot's geometry explain {100.0 * search.wrong_geometry.explains:.0f} % of the avoidable "
            f"error, of the size that absolute positions show: correct robot.toml before adding any effect ({against})."
        )
    if search.could_be:
        n = len(search.could_be)
        holder = f"each of {n} effects alone fits" if n > 1 else f"{candidate_in_words(search.could_be[0])} alone fits"
        return (
            f"Something is missing, and these {len(search.first.folds)} poses are too few to decide what: {holder} "
            f"all of them, so held-out poses cannot decide ({against})."
        )
    part = ""
    if search.tried:
        best = " and ".join(candidate_in_words(missing_effect.candidate) for missing_effect in search.tried)
        part = f" Adding {best} {share}: too little to be named."
        if search.many_laws:
            part = f" Together {best} fit these poses; that many laws would fit any data, so none of them is named."
    return f"Something is missing that no effect of the catalogue explains ({against}).{part}"

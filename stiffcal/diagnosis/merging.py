"""One answer of `diagnose` for a campaign in which several searches share no parameter."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from math import prod, sqrt

from stiffcal.diagnosis.answers.heldout_results import ErrorAsValidated
from stiffcal.diagnosis.answers.results import DiagnoseResult, ProposedEffect, SearchPace, UntestableEffect
from stiffcal.diagnosis.scans.explained import Explained
from stiffcal.identification.readings.search_subject import SearchSubject
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import EffectAt

# The search of all load states together, in answers.
ALL_STATES = "loads"


@dataclass(frozen=True)
class PartialDiagnosis:
    """The answer of one search."""

    result: DiagnoseResult
    """As if it were the only one."""
    falls: tuple[float, ...]
    """By how much the error in what is left out falls with each effect in ``missing``, in units of the noise."""
    n_rows: int
    """Readings that it rests on."""
    joints: tuple[int, ...] = ()
    """The joints that it is of, from 1; empty where all states are searched together."""
    subject: SearchSubject | None = None
    """What is searched; None: all load states together."""
    explained: Explained | None = None
    """How much of its avoidable error goes with what is missing; None where nothing is missing, or it is not known."""

    @property
    def name(self) -> str:
        """The search, as `ProposedEffect.searched_in` has it."""
        subject = ALL_STATES if self.subject is None else self.subject.name
        return "-".join((subject, *(f"j{joint}" for joint in self.joints)))

    @property
    def complete(self) -> bool:
        """Whether nothing is missing at its joints."""
        return bool(self.joints) and self.result.adequate is True and not self.result.superfluous


def merged_diagnosis(parts: Sequence[PartialDiagnosis], in_model: Collection[str] = ()) -> DiagnoseResult:
    """Return one answer: most important first, adequate where all are.

    Parameters
    ----------
    parts : an answer for each search. in_model : names of the effects that the present model holds.
    """
    first, results = parts[0].result, [part.result for part in parts]
    if len(parts) == 1:
        return first
    missing = sorted(
        (
            (fall, replace(effect, searched_in=part.name))
            for part in parts
            for fall, effect in zip(part.falls, part.result.missing, strict=True)
        ),
        key=lambda pair: -pair[0],
    )
    explained = _explained(parts)
    noises = [result.noise for result in results]
    return replace(
        first,
        warnings=list(dict.fromkeys(text for result in results for text in result.warnings)),
        adequate=_all_of([result.adequate for result in results]),
        noise=None if all(noise is None for noise in noises) else _pooled(parts, lambda result: result.noise),
        rms=_pooled(parts, lambda result: result.rms) or first.rms,
        lack_of_fit=next((result.lack_of_fit for result in results if result.lack_of_fit is not None), None),
        missing=_each_once([effect for _, effect in missing]),
        p_nothing=_product([result.p_nothing for result in results]),
        p_unknown=_one_at_least([result.p_unknown for result in results]),
        not_weighed=_one_at_least([result.not_weighed for result in results]),
        unknown=sorted((law for result in results for law in result.unknown or ()), key=lambda law: -law.probability),
        excluded_sizes=None if missing else [one for result in results for one in result.excluded_sizes or ()],
        in_model=[effect for result in results for effect in result.in_model or ()],
        contradicted=[setting for result in results for setting in result.contradicted],
        undecided=next((result.undecided for result in _by_fall(parts) if result.undecided), []),
        could_be=[effect for result in results for effect in result.could_be],
        findings=[finding for result in _by_fall(parts) for finding in result.findings],
        not_tried=_not_tried(results, in_model),
        unexplained=_any_of([result.unexplained for result in results]),
        structure=sorted(
            (dependence for result in results for dependence in result.structure),
            key=lambda dependence: -(dependence.share or 0.0),
        ),
        explained_by_missing=explained.share if explained else first.explained_by_missing,
        explained_interval=[explained.low, explained.high] if explained else first.explained_interval,
        as_validated=_only([result.as_validated for result in results]),
        pattern=next((result.pattern for result in results if result.pattern is not None), None),
        next_measurement=next(
            (result.next_measurement for result in results if result.next_measurement is not None), None
        ),
        evidence=[evidence for result in results for evidence in result.evidence],
        heldout_rms_with_missing=_pooled(parts, lambda result: result.heldout_rms_with_missing),
        heldout_rms_after_choosing=_pooled(parts, lambda result: result.heldout_rms_after_choosing)
        or first.heldout_rms_after_choosing,
        parameters_with_missing=[parameter for result in results for parameter in result.parameters_with_missing],
        before_after=[change for result in results for change in result.before_after],
        n_candidates=sum(result.n_candidates or 0 for result in results),
        n_signatures=sum(result.n_signatures or 0 for result in results),
        pace=_pace([result.pace for result in results]),
        summary=" ".join(_summaries(parts)),
        superfluous=_superfluous(results),
    )


def _each_once(missing: Sequence[ProposedEffect]) -> list[ProposedEffect]:
    """Return the effects, one that several searches found (of the set-up) once."""
    first: dict[str, ProposedEffect] = {}
    for effect in missing:
        first.setdefault(f"{effect.effect} {effect.where}", effect)
    return list(first.values())


def _not_tried(results: Sequence[DiagnoseResult], in_model: Collection[str]) -> list[UntestableEffect]:
    """Return the effects that no search tried, each once with the reason of the last search that names it.

    Effects of moving joints are searched last: the searches before them lack such runs, whatever else is missing.
    """
    tried = {finding.effect for result in results for finding in result.findings}.union(in_model)
    last = {effect.effect: effect for result in results for effect in result.not_tried if effect.effect not in tried}
    return list(last.values())


def _superfluous(results: Sequence[DiagnoseResult]) -> list[EffectAt]:
    """Return the effects that are not needed; of the set-up only those that no search needs."""
    counts: dict[str, int] = {}
    effects: dict[str, EffectAt] = {}
    for effect in (effect for result in results for effect in result.superfluous):
        label = f"{effect.effect} {effect.where}"
        counts[label] = counts.get(label, 0) + 1
        effects[label] = effect
    of_set_up = {label for label, effect in effects.items() if not list(effect.where.items())}
    return [effect for label, effect in effects.items() if label not in of_set_up or counts[label] == len(results)]


def _explained(parts: Sequence[PartialDiagnosis]) -> Explained | None:
    """Return the share of the avoidable error of all parts together; None where only one knows it."""
    known = [part.explained for part in parts if part.explained is not None]
    if len(known) < 2:
        return None
    total = sum(explained.avoidable for explained in known) or 1.0
    weights = [explained.avoidable / total for explained in known]
    share = sum(weight * explained.share for weight, explained in zip(weights, known, strict=True))
    below, above = (
        sqrt(
            sum(
                (weight * (limit - explained.share)) ** 2
                for weight, explained, limit in zip(weights, known, limits, strict=True)
            )
        )
        for limits in ([explained.low for explained in known], [explained.high for explained in known])
    )
    return Explained(share, max(0.0, share - below), min(1.0, share + above), total)


def _summaries(parts: Sequence[PartialDiagnosis]) -> list[str]:
    """Return the answers, those of joints at which nothing is missing as one."""
    texts = [part.result.summary for part in parts if not part.complete]
    for subject in dict.fromkeys(part.subject for part in parts if part.subject is not None):
        complete = sorted(joint for part in parts if part.complete and part.subject == subject for joint in part.joints)
        if complete:
            joints = ", ".join(str(joint) for joint in complete)
            plural = "s" if len(complete) > 1 else ""
            text = f"nothing is missing: the error is that of the instruments {subject.left_out}."
            texts.append(f"{subject.title} of joint{plural} {joints}: {text}")
    return texts


def _only(errors: Sequence[ErrorAsValidated | None]) -> ErrorAsValidated | None:
    """Return the errors of the one search that has them; None of several, as each is of its own readings."""
    known = [error for error in errors if error is not None]
    return known[0] if len(known) == 1 else None


def _by_fall(parts: Sequence[PartialDiagnosis]) -> list[DiagnoseResult]:
    return [part.result for part in sorted(parts, key=lambda part: -max(part.falls, default=0.0))]


def _product(probabilities: Sequence[float | None]) -> float | None:
    """Return the probability of all of several events that share nothing; None where one is not known."""
    known = [p for p in probabilities if p is not None]
    return float(prod(known)) if len(known) == len(probabilities) else None


def _one_at_least(probabilities: Sequence[float | None]) -> float | None:
    """Return the probability that one of several events happens, as far as they are known."""
    known = [p for p in probabilities if p is not None]
    return 1.0 - float(prod(1.0 - p for p in known)) if known else None


def _all_of(answers: Sequence[bool | None]) -> bool | None:
    if False in answers:
        return False
    return None if None in answers else True


def _any_of(answers: Sequence[bool | None]) -> bool | None:
    if True in answers:
        return True
    return None if None in answers else False


def _pooled(parts: Sequence[PartialDiagnosis], of: Callable[[DiagnoseResult], Rms | None]) -> Rms | None:
    """Return each measure's root mean square over the readings of all parts that have it."""
    squares: dict[str, float] = {}
    counts: dict[str, int] = {}
    for part in parts:
        rms = of(part.result)
        for measure, value in rms.items() if rms is not None else ():
            if value is not None:
                squares[measure] = squares.get(measure, 0.0) + part.n_rows * value**2
                counts[measure] = counts.get(measure, 0) + part.n_rows
    known = {measure: sqrt(squares[measure] / counts[measure]) for measure in squares if counts[measure]}
    return Rms.of({"translation": None, "rotation": None, **known}) if known else None


def _pace(paces: Sequence[SearchPace]) -> SearchPace:
    seconds, candidates = sum(pace.seconds for pace in paces), sum(pace.candidates for pace in paces)
    return SearchPace(
        models=sum(pace.models for pace in paces),
        candidates=candidates,
        signatures=sum(pace.signatures for pace in paces),
        seconds=seconds,
        candidates_per_second=candidates / max(seconds, 1e-9),
    )

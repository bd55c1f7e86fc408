"""The ranking of a search's candidates, the same for every kind of readings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.choosing import confidence_by_class
from stiffcal.diagnosis.judge import alike, fitted_values, judge, judge_choice
from stiffcal.diagnosis.naming import near_best
from stiffcal.diagnosis.pattern_results import CandidateParameter
from stiffcal.diagnosis.results import Explanation, Finding
from stiffcal.diagnosis.scan import ROUNDING, Scan, Trial
from stiffcal.diagnosis.words import candidate_in_words, places_in_words
from stiffcal.identification.document import finite
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import EffectAt, Where


def ranked_findings(
    scan: Scan,
    before: Rms,
    after_choosing: Rms | None,
    rms_after: Callable[[Trial], Rms],
    explain: Callable[[Trial, Rms, list[Candidate]], Explanation],
) -> Iterator[tuple[Trial, Finding]]:
    """Yield the candidates of one step with their findings, best first, without sizes.

    Parameters
    ----------
    scan : the candidates as fitted.
    before : rms of what is left out, by the present model.
    after_choosing : the same with the choice itself repeated without each fold, for the leader.
    rms_after : gives the rms of what is left out with a candidate.
    explain : gives the words for a supported candidate, its rms, and those that look the same.
    """
    near = [trial.candidate for trial in near_best(scan)]
    names = [candidate.name for candidate in near]
    shares = confidence_by_class(scan)
    ranked = sorted(
        scan.trials,
        key=lambda trial: names.index(trial.candidate.name) if trial.candidate.name in names else len(names),
    )
    for rank, trial in enumerate(ranked):
        leads = rank == 0 and bool(near)
        judgement = judge_choice(scan, trial) if leads else judge(scan, trial)
        name = trial.candidate.name
        after = rms_after(trial)
        alternatives = [candidate for candidate in near if candidate.name != name] if name in names else []
        explanation = explain(trial, after, alternatives) if judgement.supported else None
        same = not judgement.supported and name in names[1:]
        why = explanation.text if explanation is not None else _why_same(near[0]) if same else why_rejected(scan, trial)
        at = effect_at(trial.candidate)
        yield (
            trial,
            Finding(
                effect=at.effect,
                where=at.where,
                verdict=_verdict(judgement.supported, leads, same),
                explains=share_explained(scan, trial),
                size_m=None,
                p_value=judgement.p_value,
                heldout_rms_before=before,
                heldout_rms_after=after,
                heldout_rms_after_choosing=after_choosing if leads else None,
                confidence=shares.get(name, 0.0),
                parameters=parameters_of(trial),
                alternatives=[effect_at(candidate) for candidate in alternatives],
                why=why,
                evidence=explanation,
            ),
        )


def effect_at(candidate: Candidate) -> EffectAt:
    """Return effect and place."""
    return EffectAt(effect=candidate.effect.name, where=Where.of(candidate.place))


def parameters_of(trial: Trial) -> list[CandidateParameter]:
    """Return a candidate's values as fitted with it."""
    effect = trial.candidate.effect
    return [
        CandidateParameter(symbol=symbol, value=finite(value), unit=effect.spec(symbol).unit)
        for symbol, value in fitted_values(trial).items()
    ]


def share_explained(scan: Scan, trial: Trial) -> float | None:
    """Return the share of the avoidable error that goes, whitened."""
    before, after = float(scan.base.heldout.sum()), float(trial.score.heldout.sum())
    floor = float(scan.dof) if scan.fit.noise is not None else 0.0
    if before <= floor * (1.0 + ROUNDING):
        return None
    # What is left of equal errors is rounding.
    return (before - after) / (before - floor) if abs(before - after) > ROUNDING * before else 0.0


def _verdict(supported: bool, leads: bool, same: bool) -> Literal["supported", "possible", "rejected"]:
    """Return a candidate's verdict; ``same``: not supported itself, its displacements are those of the one that is."""
    if supported and leads:
        return "supported"
    return "possible" if supported or same else "rejected"


def _why_same(named: Candidate) -> str:
    """Return why a candidate that is not supported by itself is possible, in words."""
    same = f"its displacements are those of {candidate_in_words(named)} to within the noise"
    return f"{same}; it is not significant by itself"


def why_rejected(scan: Scan, trial: Trial) -> str:
    """Return why a candidate is not supported, in words."""
    judgement = judge(scan, trial)
    if trial.places is not None and trial.places.contradicted:
        return f"absolute positions contradict it, {places_in_words(trial.places)}"
    if not judgement.possible:
        return "its values would be impossible (negative or zero)"
    if judgement.fall <= 0.0:
        return "the error in held-out poses does not decrease"
    if not alike(scan, trial, scan.trials[0]):
        return "the error in held-out poses decreases too little, or others explain more"
    return f"not significant: {judgement.errors:.2g} standard errors over poses, p {judgement.p_value:.2g}"

"""The ranking of a search's candidates, the same for every kind of readings."""

from __future__ import annotations

from stiffcal.diagnosis.answers.pattern_results import CandidateParameter
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.diagnosis.scans.lack_of_fit import fitted_values
from stiffcal.diagnosis.scans.scan import ROUNDING, Scan, Trial
from stiffcal.identification.answers.document import finite
from stiffcal.model.summary import EffectAt, Where


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

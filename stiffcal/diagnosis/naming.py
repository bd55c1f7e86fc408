"""Which candidate is named: the evidence names, simplicity breaks ties, and general laws come last.

Candidates whose error in poses left out lies within two standard errors of the best cannot be separated by that error
alone. How often each comes first when the poses are drawn anew is the evidence among them (bootstrap of the selection,
Efron and Tibshirani, An Introduction to the Bootstrap, 1993, chapter 17). Fewer parameters decide only where that
evidence ties, or where two laws displace the tool alike: there no data of this kind can name the less simple one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.choosing import confidence
from stiffcal.diagnosis.judge import alike, fitted_values, judge, possible_values, same_within_noise
from stiffcal.diagnosis.scan import Scan, Trial, ranked_error
from stiffcal.diagnosis.thresholds import (
    EVIDENCE_TIE,
    MOST_ALTERNATIVES,
    SAME_DISPLACEMENT,
    SIZE_RATIO,
    SPECIAL_CASE,
    USUAL_SIZE,
)
from stiffcal.model.effect import ParameterRole


def near_best(scan: Scan) -> list[Trial]:
    """Return the supported candidates that cannot be separated from the best, the one to name first.

    Parameters
    ----------
    scan : the scan.

    Returns
    -------
    list of Trial
        The others by evidence; general laws (a joint's whole compliance) last: they are named only where no simple
        effect comes near, and one that holds the named effect as a special case is no alternative to it. Last of the
        simple ones those that are not significant by themselves, with more parameters for instance, but displace the
        target as the named one does. The best possible candidate alone where none is supported; empty where none is
        possible.
    """
    possible = [trial for trial in scan.trials if possible_values(scan, trial)]
    if not possible:
        return []
    best, simple = possible[0], [trial for trial in possible if not trial.candidate.effect.general]
    # A general law is not named where the best simple effect cannot be separated from it.
    leader = simple[0] if simple and alike(scan, simple[0], best) else best
    near = [trial for trial in possible if judge(scan, trial).supported and alike(scan, trial, leader)]
    if not near:
        return [leader]
    simple = [trial for trial in near if not trial.candidate.effect.general]
    named = _choose_named(scan, simple or near)
    share = confidence(scan, among=simple or near)
    alternatives = [trial for trial in near if trial is not named and not _holds(scan, trial, named)]
    alternatives.sort(
        key=lambda trial: (
            trial.candidate.effect.general,
            -share.get(trial.candidate.name, 0.0),
            ranked_error(trial),
        )
    )
    n_simple = sum(not trial.candidate.effect.general for trial in alternatives)
    return [named, *alternatives[:n_simple], *_same_as(scan, named, possible, near), *alternatives[n_simple:]]


def _same_as(scan: Scan, named: Trial, possible: Sequence[Trial], known: Sequence[Trial]) -> list[Trial]:
    """Return the simple candidates that are not known yet and displace as the named one does, to within the noise."""
    names = {trial.candidate.name for trial in known}
    return [
        trial
        for trial in possible
        if not trial.candidate.effect.general
        and trial.candidate.name not in names
        and same_within_noise(scan, trial, named)
    ]


def _choose_named(scan: Scan, near: list[Trial]) -> Trial:
    """Return the candidate with the most evidence, or the simplest of those that tie with it or displace alike.

    A candidate that would have to be many times larger than such effects are, where another of usual size does as well,
    is not named.
    """
    sizes = [times_typical(trial) for trial in near]
    near = [trial for trial, size in zip(near, sizes, strict=True) if size <= max(USUAL_SIZE, SIZE_RATIO * min(sizes))]
    share = confidence(scan, among=near)
    leader = max(near, key=lambda trial: (share[trial.candidate.name], -ranked_error(trial)))
    most = share[leader.candidate.name]
    tied = [
        trial
        for trial in near
        if trial is leader
        or share[trial.candidate.name] >= EVIDENCE_TIE * most
        or (trial.candidate.n_parameters < leader.candidate.n_parameters and same_displacement(scan, trial, leader))
    ]
    chosen = min(tied, key=lambda trial: (trial.candidate.n_parameters, ranked_error(trial)))
    return _simplest_in_limit(scan, near, chosen)


def _simplest_in_limit(scan: Scan, near: Sequence[Trial], chosen: Trial) -> Trial:
    """Return the simpler law that a candidate becomes in a limit, where it displaces alike; else the candidate."""
    for trial in near:
        same_place = trial.candidate.place == chosen.candidate.place
        is_limit = trial.candidate.effect.name in chosen.candidate.effect.in_limit
        if same_place and is_limit and same_displacement(scan, trial, chosen):
            return trial
    return chosen


def times_typical(trial: Trial) -> float:
    """Return how many times the catalogue's typical size the largest fitted compliance or set-up error is.

    Of a stiffness, how many times softer than typical. Less than typical is no objection: effects may be small. Laws
    that are curved scale with powers of the robot's torques, so that their typical size does not carry over to another
    robot.
    """
    effect, values, ratios = trial.candidate.effect, fitted_values(trial), [0.0]
    if any(spec.role is ParameterRole.NONLINEAR for spec in effect.parameters):
        return 0.0
    for symbol in trial.regressor.symbols:
        spec = effect.spec(symbol)
        amplitude, usual = abs(spec.amplitude_of(values[symbol])), abs(spec.amplitude_of(spec.typical))
        comparable = spec.inverse or spec.compliance or spec.role is ParameterRole.SETUP
        if comparable and usual > 0.0:
            ratios.append(amplitude / usual)
    return max(ratios)


def ties_with_named(scan: Scan, near: list[Trial], trial: Trial) -> bool:
    """Return whether a candidate of `near_best` could as well be named: no more parameters, and evidence that ties."""
    named = near[0]
    if trial is named:
        return True
    if trial.candidate.n_parameters > named.candidate.n_parameters:
        return False
    share = confidence(
        scan, among=[rival for rival in near if rival.candidate.effect.general == named.candidate.effect.general]
    )
    return share.get(trial.candidate.name, 0.0) >= EVIDENCE_TIE * share[named.candidate.name]


def same_displacement(scan: Scan, trial: Trial, other_trial: Trial) -> bool:
    """Return whether two candidates, as fitted, displace the tool alike beyond what the present model absorbs."""
    return displacement_cosine(scan, trial, other_trial) >= SAME_DISPLACEMENT


def displacement_cosine(scan: Scan, trial: Trial, other_trial: Trial) -> float:
    """Return the cosine of two candidates' displacements, as fitted, beyond what the present model absorbs.

    Of whitened rows: with 0.98, 4 % of the squares differ. 0 where one of them moves nothing that the model cannot.
    """
    first, second = (_own_part(scan, compared_trial) for compared_trial in (trial, other_trial))
    sizes = float(np.linalg.norm(first) * np.linalg.norm(second))
    return float(first @ second) / sizes if sizes > 0.0 else 0.0


def look_alikes(scan: Scan, near: Sequence[Trial], named: Trial) -> tuple[tuple[Candidate, ...], tuple[float, ...]]:
    """Return the foremost candidates near the best, `MOST_ALTERNATIVES` of them, and each one's cosine with the named.

    Parameters
    ----------
    scan : the scan in which ``named`` was chosen.
    near : candidates that its data cannot distinguish from it, foremost first; itself is passed over.
    """
    others = [trial for trial in near if trial.candidate.name != named.candidate.name][:MOST_ALTERNATIVES]
    return (
        tuple(trial.candidate for trial in others),
        tuple(displacement_cosine(scan, trial, named) for trial in others),
    )


def _own_part(scan: Scan, trial: Trial) -> Floats:
    """Return (m · n) whitened displacements that the candidate adds and the present model cannot."""
    regressor = trial.regressor.whole()
    amplitude = trial.score.solution[len(trial.score.solution) - len(regressor.symbols) :]
    added = np.einsum("qmn,q->mn", regressor.columns, amplitude) + regressor.fixed
    rows = scan.space.rows(np.concatenate([scan.own_columns, added[None]]))
    known, own = rows[:-1].T, rows[-1]
    return np.asarray(own - known @ np.linalg.lstsq(known, own, rcond=1e-10)[0])


def _holds(scan: Scan, trial: Trial, simpler: Trial) -> bool:
    """Return whether a general law moves, with the model's own, all that a simpler one moves."""
    own, simpler_columns = trial.regressor.columns, simpler.regressor.columns
    if not trial.candidate.effect.general or not 0 < len(simpler_columns) < len(own):
        return False
    rows = scan.space.rows(np.concatenate([scan.own_columns, own, simpler_columns]))
    rows = rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-300)
    known, requested = rows[: -len(simpler_columns)].T, rows[-len(simpler_columns) :].T
    remaining = requested - known @ np.linalg.lstsq(known, requested, rcond=1e-10)[0]
    return bool(np.linalg.norm(remaining) < SPECIAL_CASE)

"""What a search in rows that are no load states found, as `diagnose` answers it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.choosing import choice_without_each_group
from stiffcal.diagnosis.folds import FoldProducts
from stiffcal.diagnosis.judge import against_noise, rms_reduction
from stiffcal.diagnosis.ranking import effect_at, ranked_findings
from stiffcal.diagnosis.results import (
    DiagnoseResult,
    Explanation,
    Finding,
    LookAlike,
    ProposedEffect,
    SearchPace,
    UndecidedEffect,
    UntestableEffect,
)
from stiffcal.diagnosis.row_context import RowSearchContext
from stiffcal.diagnosis.row_scan import RowScan
from stiffcal.diagnosis.scan import Trial
from stiffcal.diagnosis.scoring import score_variants
from stiffcal.diagnosis.search_results import MissingEffect, SearchOf
from stiffcal.diagnosis.thresholds import LEAST_FOLDS, LOOK_ALIKE_ERRORS, LOOK_ALIKE_SHARE
from stiffcal.diagnosis.words import candidate_in_words, place_in_words, values_in_words
from stiffcal.experiments.row_search import RowFit, RowProblem
from stiffcal.identification.before_after import estimated_parameters, values_before_and_after
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import Where

RowSearch = SearchOf[RowScan, RowFit]


def row_diagnosis(context: RowSearchContext, search: RowSearch) -> DiagnoseResult:
    """Return the result document of ``diagnose`` for the rows of one problem.

    Parameters
    ----------
    context : the rows and the catalogue.
    search : what was found.
    """
    problem, scan, final = context.problem, search.first, search.final_scan
    before = left_out_rms(scan, None, problem)
    noise = _noise(search.final, problem)
    structure = context.follows(final if search.found else scan)
    adequate = None if search.before is None else not search.tried and search.before.adequate
    parameters = list(search.final.parameters) if search.found else []
    with_missing = left_out_rms(final, None, problem) if search.found else before
    changes = (
        values_before_and_after(estimated_parameters(list(scan.fit.parameters)), estimated_parameters(parameters))
        if search.found
        else []
    )
    return DiagnoseResult(
        warnings=_warnings(context, search),
        adequate=adequate,
        noise=noise,
        rms=before,
        lack_of_fit=against_noise(search.before),
        missing=[_proposed(missing) for missing in search.found],
        undecided=[
            UndecidedEffect(
                effect=effect_at(rival.candidate).effect,
                where=effect_at(rival.candidate).where,
                share=rival.share,
                deciding_runs=[],
            )
            for rival in search.undecided
        ],
        could_be=[effect_at(candidate) for candidate in search.could_be],
        findings=_findings(context, search, before),
        next_measurement=None,
        not_tried=[*search.not_tried, *_indistinct(scan)],
        unexplained=search.unexplained or None if search.after is None else search.unexplained,
        structure=structure if search.unexplained or search.after is None else [],
        explained_by_missing=search.explained.share if search.tried else None,
        explained_interval=[search.explained.low, search.explained.high] if search.tried else None,
        heldout_rms_with_missing=with_missing,
        heldout_rms_after_choosing=_rms_after_choosing(scan, problem),
        parameters_with_missing=parameters,
        before_after=changes,
        n_candidates=len(scan.trials),
        n_signatures=scan.n_tried,
        pace=SearchPace(
            models=search.pace.models,
            candidates=search.pace.candidates,
            signatures=search.pace.regressors,
            seconds=search.pace.seconds,
            candidates_per_second=search.pace.candidates / max(search.pace.seconds, 1e-9),
        ),
        summary=_summary(context, search, [dependence.follows for dependence in structure], before, noise),
        superfluous=[],
        evidence=[],
        fit_id="",
        key="",
    )


def _proposed(missing: MissingEffect) -> ProposedEffect:
    """Return an effect to add."""
    at = effect_at(missing.candidate)
    alternatives = [
        LookAlike(effect=candidate.effect.name, where=Where.of(candidate.place), cosine=cosine)
        for candidate, cosine in zip(missing.alternatives, missing.cosines, strict=True)
    ]
    return ProposedEffect(effect=at.effect, where=at.where, alternatives=alternatives)


def too_few_folds(problem: RowProblem, fit: RowFit) -> DiagnoseResult | None:
    """Return the answer where too little can be left out for any effect to be judged; None where there is enough."""
    n_folds = len(np.unique(fit.fold))
    if n_folds >= LEAST_FOLDS:
        return None
    nothing = Rms(None, None)
    needs = f"at least {LEAST_FOLDS} {problem.folds_in_words}"
    return DiagnoseResult(
        warnings=[],
        adequate=None,
        noise=_noise(fit, problem),
        rms=nothing,
        lack_of_fit=None,
        missing=[],
        could_be=[],
        findings=[],
        next_measurement=None,
        not_tried=[UntestableEffect("every effect of moving joints", needs)],
        unexplained=None,
        structure=[],
        heldout_rms_after_choosing=nothing,
        parameters_with_missing=[],
        pace=SearchPace(models=0, candidates=0, signatures=0, seconds=0.0, candidates_per_second=0.0),
        summary=f"{_who(problem)}: whether the model is good enough cannot be judged: this requires {needs}.",
        superfluous=[],
        evidence=[],
        fit_id="",
        key="",
    )


def left_out_residual(scan: RowScan, trial: Trial | None) -> Floats:
    """Return (k,) residuals with each fold left out in turn, free constants taken out and their freedom counted."""
    score = scan.base if trial is None else trial.score
    return free_of_constants(scan, score.left.residual * scan.space.sigma)


def free_of_constants(scan: RowScan, residual: Floats) -> Floats:
    """Return (k,) residuals with free constants taken out and their freedom counted."""
    residual = residual.copy()
    for members in scan.space.members:
        weight = 1.0 / scan.space.sigma[members] ** 2
        residual[members] -= float(np.sum(weight * residual[members]) / weight.sum())
        residual[members] *= np.sqrt(members.size / max(members.size - 1, 1))
    return np.asarray(residual)


def left_out_rms(scan: RowScan, trial: Trial | None, problem: RowProblem) -> Rms:
    """Return the rms of what is left out."""
    return rms_of_rows(left_out_residual(scan, trial), problem)


def _rms_after_choosing(scan: RowScan, problem: RowProblem) -> Rms:
    chosen = choice_without_each_group(scan)[scan.groups]
    residual = scan.residual[0].copy()
    for number in np.unique(chosen):
        rows = np.concatenate([scan.folds[k] for k in np.flatnonzero(chosen == number)])
        residual[rows] = left_out_residual(scan, None if number == 0 else scan.trials[number - 1])[rows]
    return rms_of_rows(residual, problem)


def rms_of_rows(values: Floats, problem: RowProblem) -> Rms:
    """Return the rms of (k,) values in the problem's measure."""
    return Rms.of({"translation": None, "rotation": None, problem.measure: float(np.sqrt(np.mean(values**2)))})


def _noise(fit: RowFit, problem: RowProblem) -> Rms | None:
    return None if fit.noise is None else rms_of_rows(fit.sigma, problem)


def _findings(context: RowSearchContext, search: RowSearch, before: Rms) -> list[Finding]:
    """Return the ranking for the next single step, best first."""
    scan, problem = search.first, context.problem
    ranking = ranked_findings(
        scan,
        before,
        _rms_after_choosing(scan, problem),
        lambda trial: left_out_rms(scan, trial, problem),
        lambda trial, after, alternatives: _explain(scan, trial, problem, alternatives, before, after),
    )
    return [replace(finding, size_Nm=_size(scan, trial)) for trial, finding in ranking]


def _size(scan: RowScan, trial: Trial) -> float:
    """Return the rms of what a candidate adds, N·m, free constants taken out."""
    count = len(trial.regressor.symbols)
    amplitude = trial.score.solution[len(trial.score.solution) - count :]
    added = np.einsum("qmk,q->mk", trial.regressor.columns, amplitude)
    return float(np.sqrt(np.mean((scan.space.rows(added[None])[0] * scan.space.sigma) ** 2)))


def _explain(
    scan: RowScan, trial: Trial, problem: RowProblem, alike: list[Candidate], before: Rms, after: Rms
) -> Explanation:
    effect = trial.candidate.effect
    helped, n_folds = int(np.count_nonzero(trial.score.heldout < scan.base.heldout)), len(scan.folds)
    first, second = (dict(rms.items()).get(problem.measure) or 0.0 for rms in (before, after))
    seen = (
        f"At {place_in_words(trial.candidate.place)}: {effect.fingerprint or effect.summary}, by "
        f"{_size(scan, trial):.2g} {problem.unit} rms; with it the error {problem.subject.left_out} decreases from "
        f"{first:.3g} to {second:.3g} {problem.unit}, at {helped} of {n_folds} {problem.folds_in_words}."
    )
    names = " and ".join(candidate_in_words(candidate) for candidate in alike)
    return Explanation(
        seen=seen,
        means=f"That is {effect.name}: {effect.summary}{values_in_words(trial)}.",
        alike=f"In these runs {names} cannot be distinguished from it." if names else "",
        check=f"To check on the machine: {effect.how_to_check}" if effect.how_to_check else "",
    )


def _indistinct(scan: RowScan) -> list[UntestableEffect]:
    needs = "a longer travel: neighbouring orders fit equally well"
    return [UntestableEffect(name, needs) for name in dict.fromkeys(c.effect.name for c in scan.indistinct)]


def _warnings(context: RowSearchContext, search: RowSearch) -> list[str]:
    """Return what a reader must know of what was found."""
    texts = []
    if search.before is None:
        texts.append(
            f"{_who(context.problem)}: the noise is unknown: the remaining error is judged by leaving out whole "
            f"{context.problem.folds_in_words}, and by resampling them as blocks"
        )
    for missing in search.found:
        if _time_would_do(context, search, missing.candidate):
            texts.append(
                f"{candidate_in_words(missing.candidate)}: time explains it as well as temperature in these runs, "
                "which warm up once; repeat them cold, warm and cold again to distinguish the two"
            )
        if missing.candidate.effect.constant_torque:
            texts.append(
                f"{candidate_in_words(missing.candidate)}: an unknown zero offset of the torque sensor has the same "
                "effect"
            )
    return texts


def _time_would_do(context: RowSearchContext, search: RowSearch, candidate: Candidate) -> bool:
    """Return whether an effect that follows the temperature would fit as well if it followed the time."""
    placed = next(
        (
            placed
            for placed in search.final.robot.placed
            if placed.effect.name == candidate.effect.name and placed.place == candidate.place
        ),
        None,
    )
    timed = None
    if placed is not None:
        timed = context.problem.with_time_for_temperature(placed.effect, placed.place, placed.shape())
    if placed is None or timed is None:
        return False
    scan = search.final_scan
    own = scan.ground.state.regressor(placed.effect, placed.place, placed.shape())
    kept = [k for k, column in enumerate(scan.columns) if not any(np.array_equal(column, c) for c in own.columns)]
    added = sum(placed.amplitude(s) * column for s, column in zip(own.symbols, own.columns, strict=True))
    rows = scan.space.rows(np.concatenate([scan.columns[kept], timed.columns, (scan.residual + added)[None]]))
    free = np.full(len(rows) - 1, np.inf)
    score = score_variants([FoldProducts.of(rows, scan.folds)], -free, free, scan.groups)
    squares = (score.left.residual - scan.base.left.residual) ** 2
    gap, errors = rms_reduction(score.heldout, scan.base.heldout, scan.by_fold(squares), scan.dof)
    return gap <= LOOK_ALIKE_SHARE or errors <= LOOK_ALIKE_ERRORS


def _who(problem: RowProblem) -> str:
    joints = problem.joints
    return f"{problem.subject.title} of joint{'s' if len(joints) > 1 else ''} {', '.join(map(str, joints))}"


def _summary(context: RowSearchContext, search: RowSearch, follows: list[str], before: Rms, noise: Rms | None) -> str:
    """Return the answer in one or two sentences."""
    problem = context.problem
    against = f"{_number(before, problem)} {problem.unit} {problem.subject.left_out}"
    if noise is not None:
        against += f", noise {_number(noise, problem)} {problem.unit}"
    remainder = ""
    if search.unexplained:
        followed = " and ".join(follows)
        remainder = f" The remaining error depends on {followed or 'none of what was logged'}."
    names = " and ".join(candidate_in_words(missing.candidate) for missing in search.found)
    between = " and ".join(candidate_in_words(rival.candidate) for rival in search.undecided)
    if search.undecided:
        text = f"undecided between {between}: without one of the {problem.folds_in_words} another explains it better"
    elif search.found and not search.unexplained:
        text = f"missing: {names}"
    elif search.found:
        text = f"missing: {names}; a further error is explained by no effect of the catalogue"
    elif search.unexplained:
        text = "something is missing that no effect of the catalogue explains"
    elif search.before is None:
        text = "nothing is supported; without a known noise it cannot be judged whether the model is good enough"
    else:
        text = "nothing is missing: the error is that of the instruments"
    more = " and ".join(candidate_in_words(rival.candidate) for rival in search.undecided_next)
    further = f" A further effect is undecided between {more}: add this one first, then diagnose again." if more else ""
    return f"{_who(problem)}: {text} ({against}).{remainder}{further}"


def _number(rms: Rms, problem: RowProblem) -> str:
    measures: Mapping[str, float | None] = dict(rms.items())
    return f"{measures.get(problem.measure) or 0.0:.3g}"

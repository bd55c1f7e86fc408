"""What is missing from a model of rows, as `diagnose` answers it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.diagnosis.answers.results import DiagnoseResult, Explanation, Finding, SearchPace, UntestableEffect
from stiffcal.diagnosis.of_rows.row_errors import left_out_rms, rms_after_choosing_rows, rms_of_rows, size_in_rows
from stiffcal.diagnosis.of_rows.row_structure import what_rows_follow
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.diagnosis.scans.lack_of_fit import against_noise
from stiffcal.diagnosis.scans.scan import Trial, helped
from stiffcal.diagnosis.thresholds import LEAST_FOLDS
from stiffcal.diagnosis.words import candidate_in_words, error_in_words, place_in_words, values_in_words
from stiffcal.identification.answers.before_after import estimated_parameters, values_before_and_after
from stiffcal.judgement.answers import (
    excluded_sizes_of,
    pace_of,
    proposed,
    ranked_findings,
    superfluous_of,
    undecided_effects,
    unknown_laws,
)
from stiffcal.judgement.diagnosed_rows import DiagnosedRows
from stiffcal.judgement.sentences import answer_of
from stiffcal.kinds.row_search import RowFit, RowProblem
from stiffcal.measurements.rms import Rms
from stiffcal.model.motion import as_motion, is_constant_torque
from stiffcal.wording import listing, significant


def row_diagnosis(found: DiagnosedRows) -> DiagnoseResult:
    """Return the result document of ``diagnose`` for the rows of one problem."""
    problem, first, last, reading = found.problem, found.first, found.last, found.reading
    before = left_out_rms(first, None, problem)
    noise = _noise(last.fit, problem)
    structure = what_rows_follow(last, problem) if found.unexplained is not False else []
    identified = list(last.fit.identified) if found.found else []
    changes = (
        values_before_and_after(estimated_parameters(list(first.fit.identified)), estimated_parameters(identified))
        if found.found
        else []
    )
    explained = found.explained
    n_effects, n_shapes = found.n_members
    against = f"{_in_words(before, problem)} {problem.subject.left_out}"
    against += f", noise {_in_words(noise, problem)}" if noise is not None else ""
    return DiagnoseResult(
        warnings=_warnings(found),
        adequate=found.adequate,
        noise=noise,
        rms=before,
        lack_of_fit=against_noise(found.before),
        missing=proposed(found.found),
        in_model=proposed(found.held),
        p_nothing=reading.p_nothing,
        p_unknown=reading.p_unknown,
        unknown=unknown_laws(found, lambda _: None),
        not_weighed=reading.not_weighed,
        excluded_sizes=excluded_sizes_of(found, "N·m", lambda _: None),
        undecided=undecided_effects(found),
        could_be=[],
        findings=_findings(found, before),
        next_measurement=None,
        not_tried=list(found.not_tried),
        unexplained=found.unexplained,
        structure=structure,
        explained_by_missing=None if explained is None else explained.share,
        explained_interval=None if explained is None else [explained.low, explained.high],
        heldout_rms_with_missing=left_out_rms(last, None, problem),
        heldout_rms_after_choosing=rms_after_choosing_rows(first, problem),
        parameters_with_missing=identified,
        before_after=changes,
        n_candidates=n_effects,
        n_signatures=n_shapes,
        pace=pace_of(found),
        summary=_of_these(problem, " ".join(answer_of(found, against, structure, noise))),
        superfluous=superfluous_of(found),
        evidence=[],
        fit_id="",
        key="",
    )


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
        summary=_of_these(problem, f"Whether the model is good enough cannot be judged: this requires {needs}."),
        superfluous=[],
        evidence=[],
        fit_id="",
        key="",
    )


def _noise(fit: RowFit, problem: RowProblem) -> Rms | None:
    return None if fit.noise is None else rms_of_rows(fit.sigma, problem)


def _findings(found: DiagnosedRows, before: Rms) -> list[Finding]:
    """Return every effect as the next single step."""
    scan, problem = found.first, found.problem
    ranking = ranked_findings(
        found,
        before,
        rms_after_choosing_rows(scan, problem),
        lambda trial: left_out_rms(scan, trial, problem),
        lambda trial, after, alike: _explain(found, trial, alike, before, after),
    )
    return [replace(finding, size_Nm=size_in_rows(scan, trial)) for trial, finding in ranking]


def _explain(found: DiagnosedRows, trial: Trial, alike: list[Candidate], before: Rms, after: Rms) -> Explanation:
    scan, problem = found.first, found.problem
    effect = trial.candidate.effect
    n_helped, n_folds = int(np.count_nonzero(helped(scan, trial))), len(scan.folds)
    first, second = (
        error_in_words(dict(rms.items()).get(problem.measure) or 0.0, problem.measure) for rms in (before, after)
    )
    seen = (
        f"At {place_in_words(trial.candidate.place)}: {effect.fingerprint or effect.summary}, by "
        f"{significant(size_in_rows(scan, trial), 2)} {problem.unit} rms; with it the error "
        f"{problem.subject.left_out} decreases "
        f"from {first} to {second}, at {n_helped} of {n_folds} {problem.folds_in_words}."
    )
    names = listing(map(candidate_in_words, alike)) if alike else ""
    return Explanation(
        seen=seen,
        means=f"That is {effect.name}: {effect.summary}{values_in_words(trial)}.",
        alike=f"In these runs {names} cannot be distinguished from it." if names else "",
        check=f"To check on the machine: {effect.how_to_check}" if effect.how_to_check else "",
    )


def _in_words(rms: Rms, problem: RowProblem) -> str:
    return error_in_words(dict(rms.items()).get(problem.measure) or 0.0, problem.measure)


def _warnings(found: DiagnosedRows) -> list[str]:
    """Return what a reader must know of what was found."""
    problem, texts = found.problem, []
    if not found.noise_known:
        texts.append(
            _of_these(
                problem,
                "The noise is unknown: the remaining error is judged by leaving out whole "
                f"{problem.folds_in_words}, and by resampling them as blocks",
            )
        )
    for one in found.found:
        if found.time_would_do(one.candidate):
            texts.append(
                f"{candidate_in_words(one.candidate)}: time explains it as well as temperature in these runs, "
                "which warm up once; repeat them cold, warm and cold again to distinguish the two"
            )
        if is_constant_torque(as_motion(one.candidate.effect), one.candidate.place, problem.robot.chain):
            texts.append(
                f"{candidate_in_words(one.candidate)}: an unknown zero offset of the torque sensor has the same effect"
            )
    return texts


def _of_these(problem: RowProblem, text: str) -> str:
    """Return a sentence that says of which joints it is."""
    joints = problem.joints
    who = f"{problem.subject.title} of joint{'s' if len(joints) > 1 else ''} {', '.join(map(str, joints))}"
    return f"{who}: {text[0].lower()}{text[1:]}"

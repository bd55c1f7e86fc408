"""Pairs of effects that show only together.

Two effects whose signatures are much alike, at work with opposite signs, leave the small difference of two large
displacements: either of them alone explains next to nothing of it, both together all (physics, section 5.5).
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np

from stiffcal.diagnosis.judge import f_tail, possible_values, rms_reduction
from stiffcal.diagnosis.scan import Scan, Trial, score_together
from stiffcal.diagnosis.thresholds import FAMILY_P, LEAST_FALL, PAIRS_SCORED, STANDARD_ERRORS, WIDEST_PAIR
from stiffcal.estimation.triangular import triangular_of_rows
from stiffcal.model.effect import ParameterRole


def best_pair(scan: Scan) -> tuple[Trial, Trial] | None:
    """Return the two candidates that together lower the held-out error most, None where no two are supported.

    Every pair is weighed by how far it lowers the fit's squares, the best of them in held-out poses, within bounds.
    """
    trials = [
        trial
        for trial in scan.trials
        if 0 < len(trial.regressor.symbols) <= WIDEST_PAIR and not trial.regressor.fixed.any()
    ]
    weighed = sorted(_ranked_pairs(scan, trials), reverse=True)
    best, least = None, np.inf
    for _, first_index, second_index in weighed[:PAIRS_SCORED]:
        pair = _score_pair(scan, trials[first_index], trials[second_index])
        heldout = float(np.sum(pair[0].score.heldout))
        possible = all(possible_values(scan, member) for member in pair)
        if heldout < least and possible and _supported(scan, pair, len(weighed)):
            best, least = pair, heldout
    return best


def _score_pair(scan: Scan, first_trial: Trial, second_trial: Trial) -> tuple[Trial, Trial]:
    """Return two trials with the score of both together, each with its own share of the solution."""
    score = score_together(scan, (first_trial, second_trial))
    count = len(second_trial.regressor.symbols)
    first = replace(score, solution=score.solution[: len(score.solution) - count])
    return replace(first_trial, score=first), replace(second_trial, score=score)


def _supported(scan: Scan, pair: tuple[Trial, Trial], n_pairs: int) -> bool:
    """Return whether two effects together are supported, all pairs of all shapes counted as tried."""
    score = pair[1].score
    fall, errors = rms_reduction(scan.base.heldout, score.heldout, score.prediction_change, scan.dof)
    count = len(score.solution) - len(scan.columns)
    count += sum(spec.role is ParameterRole.NONLINEAR for trial in pair for spec in trial.candidate.effect.parameters)
    residual_dof = float(scan.residual_dof - count)
    if residual_dof <= 0.0:
        return False
    known = np.inf if scan.fit.noise is None else scan.fit.noise.dof
    drop = (
        max(scan.base.sum_of_squares - score.sum_of_squares, 0.0)
        / max(1.0, score.sum_of_squares / residual_dof)
        / count
    )
    tried = n_pairs * pair[0].n_variants * pair[1].n_variants
    p_value = tried * f_tail(drop, count, min(residual_dof, known))
    return fall > LEAST_FALL and errors > STANDARD_ERRORS and p_value < FAMILY_P


def _ranked_pairs(scan: Scan, trials: list[Trial]) -> list[tuple[float, int, int]]:
    """Return (fall of the fit's squares less two per parameter, first, second index) of all pairs, without bounds."""
    ends = np.cumsum([0, *(len(trial.regressor.symbols) for trial in trials)])
    rows = np.empty((scan.n_columns + int(ends[-1]) + 1, scan.residual.size))
    rows[: scan.n_columns], rows[-1] = scan.space.rows(scan.own_columns), scan.space.rows(scan.residual[None])[0]
    for trial, first in zip(trials, scan.n_columns + ends, strict=False):
        rows[first : first + len(trial.regressor.symbols)] = scan.space.rows(trial.regressor.columns)
    size = np.sqrt(np.einsum("kn,kn->k", rows, rows))
    rows /= np.where(size > 0.0, size, 1.0)[:, None]
    # The triangle's lower right corner is what the base model leaves of everything else.
    left = triangular_of_rows(rows)[scan.n_columns :, scan.n_columns :]
    inner = left.T @ left
    places = [np.arange(first, last) for first, last in pairwise(ends)]
    weighed_pairs = []
    for first_index, second_index in combinations(range(len(trials)), 2):
        if _together(trials[first_index], trials[second_index]):
            rows_of_pair = np.concatenate([places[first_index], places[second_index]])
            normal = inner[np.ix_(rows_of_pair, rows_of_pair)] + 1e-9 * np.eye(len(rows_of_pair))
            drop = float(inner[rows_of_pair, -1] @ np.linalg.solve(normal, inner[rows_of_pair, -1])) * float(
                size[-1] ** 2
            )
            weighed_pairs.append((drop - 2.0 * len(rows_of_pair), first_index, second_index))
    return weighed_pairs


def _together(first_trial: Trial, second_trial: Trial) -> bool:
    """Return whether two effects can stand in one model."""
    a, b = first_trial.candidate, second_trial.candidate
    known = (*a.effect.includes, *a.effect.excludes)
    return not (
        a.place == b.place and (b.effect.name in known or a.effect.name in (*b.effect.includes, *b.effect.excludes))
    )

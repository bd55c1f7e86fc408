"""Does a name rest on one pose? Each pose is left out in turn, and what would be named without it is compared.

A single measurement can decide between effects that all others leave open: the highest lever of the data, or a pose
that is wrong. Where another candidate wins without one pose, by more than two standard errors over the other poses, the
answer is undecided, with the pose that decides. The choice is not repeated inside these deletions: only the candidates
that come near the best take part, each at its fitted law.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.choosing import confidence, first_least
from stiffcal.diagnosis.folds import fold_products, inner_outside
from stiffcal.diagnosis.judge import possible_values, rms_reduction
from stiffcal.diagnosis.normal_equations import quadratic, solve_within, without_rows
from stiffcal.diagnosis.scan import Scan, Trial, bounds_with
from stiffcal.diagnosis.slips import is_slip
from stiffcal.diagnosis.thresholds import (
    DELETIONS_OF,
    LEADERS_OF,
    LEAST_POSES,
    LOOK_ALIKE_SHARE,
    MOST_ALTERNATIVES,
    RIVALS,
    SINGLE_POSES,
    STANDARD_ERRORS,
)


@dataclass(frozen=True)
class Rival:
    """A candidate that could be named in place of another."""

    candidate: Candidate
    share: float
    """Of all deletions (of all resamplings where no pose decides), how many in which it has the least error."""
    deciding: tuple[int, ...]
    """Numbers of the folds (poses) without which it wins by more than two standard errors over poses."""


def rivals_without_a_pose(scan: Scan, near: Sequence[Trial], named: Trial) -> tuple[Rival, ...]:
    """Return the candidates between which single poses decide, the named one among them; empty where none does.

    Parameters
    ----------
    scan : the scan in which ``named`` was chosen.
    near : the candidates that come near the best (`naming.near_best`).
    named : the candidate that is named.

    Returns
    -------
    tuple of Rival
        At most `RIVALS`, the most frequent first.
    """
    contenders = _contenders(scan, near, named)
    if len(scan.folds) < LEAST_POSES or len(contenders) < 2 or is_slip(named.candidate.effect):
        return ()
    fits = [_Deleted.of(scan, trial) for trial in contenders]
    groups = fits[0].groups
    outside = np.arange(int(groups.max()) + 1)[:, None] != groups[None, :]
    first = first_least(np.stack([np.where(outside, fit.errors, 0.0).sum(axis=1) for fit in fits]))
    deciding: dict[int, list[int]] = {}
    for group, winner in enumerate(first):
        if winner and _wins(scan, fits[0], fits[winner], group):
            deciding.setdefault(int(winner), []).extend(np.flatnonzero(groups == group).tolist())
    if not deciding:
        return ()
    share = np.bincount(first, minlength=len(contenders)) / len(first)
    kept = sorted(range(len(contenders)), key=lambda k: (k != 0, k not in deciding, -share[k]))[:RIVALS]
    return tuple(
        Rival(contenders[k].candidate, float(share[k]), tuple(deciding.get(k, ())))
        for k in sorted(kept, key=lambda k: -share[k])
        if share[k] > 0.0 or k == 0
    )


def too_many_alike(scan: Scan, near: Sequence[Trial], named: Trial) -> tuple[Rival, ...]:
    """Return the foremost of the candidates that look alike where they are too many to be listed; else empty.

    Parameters
    ----------
    scan : the scan in which ``named`` was chosen.
    near : the candidates that come near the best (`naming.near_best`).
    named : the candidate that is named.

    Returns
    -------
    tuple of Rival
        Those that come first in most resamplings (``share``), `RIVALS` in all, without a deciding pose.
    """
    alike = [trial for trial in near if trial.candidate.effect.general == named.candidate.effect.general]
    if len(alike) <= 1 + MOST_ALTERNATIVES:
        return ()
    share = confidence(scan, among=alike)
    # By evidence alone: a simpler law that would be named where evidence ties is no likelier than its share.
    foremost = sorted(alike, key=lambda trial: -share[trial.candidate.name])[:RIVALS]
    return tuple(Rival(trial.candidate, share[trial.candidate.name], ()) for trial in foremost)


def _contenders(scan: Scan, near: Sequence[Trial], named: Trial) -> list[Trial]:
    """Return the named candidate, those near the best, and those that lead where one pose does not count."""
    general = named.candidate.effect.general
    alternatives = [trial for trial in near if trial.candidate.effect.general == general]
    rivals = [
        trial
        for trial in scan.trials
        if trial.candidate.effect.general == general and not is_slip(trial.candidate.effect)
    ][:LEADERS_OF]
    if rivals:
        leading = np.unique(first_least(np.stack([_remaining_squares(trial) for trial in rivals])))
        alternatives += [rivals[k] for k in leading if possible_values(scan, rivals[k])]
    result: list[Trial] = []
    for trial in (named, *alternatives):
        if _becomes(trial, named):
            continue
        if all(trial.candidate.name != known.candidate.name for known in result):
            result.append(trial)
    return result[:DELETIONS_OF]


def _becomes(trial: Trial, named: Trial) -> bool:
    """Return whether a law becomes the named one in a limit: the same physics in more detail is no other name."""
    same_place = trial.candidate.place == named.candidate.place
    return same_place and named.candidate.effect.name in trial.candidate.effect.in_limit


def _remaining_squares(trial: Trial) -> Floats:
    """Return (F,) squares that a candidate leaves of the other poses, fitted without each, two per parameter added."""
    return np.asarray(trial.score.left.rest + 2.0 * len(trial.regressor.symbols))


@dataclass(frozen=True)
class _Deleted:
    """A candidate refitted without each group of poses, with everything else."""

    rows: Floats
    """(k + 1, N) whitened rows: base columns, the candidate's, what it adds without a parameter."""
    groups: Integers
    """(F,) group of each pose: one of its own in campaigns of a few dozen."""
    solutions: Floats
    """(G, F, k) without group g and pose f in small campaigns, else (G, k) without group g."""
    errors: Floats
    """(G, F) whitened squares on pose f."""

    @classmethod
    def of(cls, scan: Scan, trial: Trial) -> _Deleted:
        """Refit."""
        regressor = trial.regressor
        rows = scan.space.rows(np.concatenate([scan.columns, regressor.columns, regressor.fixed[None]]))
        left = scan.space.rows((scan.residual - regressor.fixed)[None])
        data, bounds = np.concatenate([rows[:-1], left]), bounds_with(scan, regressor)
        n_folds = len(scan.folds)
        groups = np.arange(n_folds, dtype=np.int64) % min(n_folds, SINGLE_POSES)
        small = n_folds <= SINGLE_POSES
        # Of more poses the one on which the error is taken hardly moves the fit.
        solutions, errors = (_without_two if small else _without_groups)(scan, data, groups, bounds, trial)
        return cls(rows, groups, solutions, errors)

    def predicted(self, group: int, folds: Sequence[Integers]) -> Floats:
        """Return (N,) whitened displacements, fitted without a group and, in small campaigns, without each pose."""
        solution = self.solutions[group]
        if solution.ndim == 1:
            return np.asarray(np.append(solution, 1.0) @ self.rows)
        result = np.empty(self.rows.shape[1])
        for x, fold in zip(solution, folds, strict=True):
            result[fold] = np.append(x, 1.0) @ self.rows[:, fold]
        return result


def _without_two(
    scan: Scan, data: Floats, groups: Integers, bounds: tuple[Floats, Floats], trial: Trial
) -> tuple[Floats, Floats]:
    """Return (F, F, k) parameters without poses g and f, and (F, F) the squares that they leave of pose f.

    Parameters
    ----------
    data : (k + 1, N) whitened rows, what the candidate leaves of the residual last.
    groups : (F,) group of each pose, here of its own. bounds : (k,) lower and upper. trial : the candidate.
    """
    whole = scan.products(data)
    products, total, solutions = whole.each, whole.total, np.empty((len(groups), len(groups), len(data) - 1))
    for group, product in enumerate(products):
        rest = without_rows(total, product)
        inner = np.stack([without_rows(rest, other) for other in products])
        inner[group] = rest
        solutions[group] = solve_within(inner[:, :-1, :-1], inner[:, :-1, -1], *bounds, trial.score.solution)
    return solutions, quadratic(products, solutions)


def _without_groups(
    scan: Scan, data: Floats, groups: Integers, bounds: tuple[Floats, Floats], trial: Trial
) -> tuple[Floats, Floats]:
    """Return (G, k) parameters without each group of poses, and (G, F) the squares that they leave of each pose.

    Parameters
    ----------
    data, groups, bounds, trial : as in `_without_two`.
    """
    group_of_row = groups[scan.fold_of_row]
    products = fold_products(data, [np.flatnonzero(group_of_row == group) for group in range(int(groups.max()) + 1)])
    before, base = scan.outside, len(scan.columns)
    outside = inner_outside(before, len(data) - 1)
    rest = without_rows(products.sum(axis=0) + (0.0 if outside is None else outside), products)
    solutions = solve_within(rest[:, :-1, :-1], rest[:, :-1, -1], *bounds, trial.score.solution)
    # what misses what is known before is an error of all poses alike
    missed = np.sum((before[:, -1] - solutions[:, :base] @ before[:, :-1].T) ** 2, axis=1) / len(groups)
    errors = np.stack([scan.by_fold((data[-1] - x @ data[:-1]) ** 2) for x in solutions]) + missed[:, None]
    return solutions, errors


def _wins(scan: Scan, named: _Deleted, rival: _Deleted, group: int) -> bool:
    """Return whether another candidate has less error without a group of poses, by two standard errors over poses."""
    kept = np.flatnonzero(named.groups != group)
    apart = named.predicted(group, scan.folds) - rival.predicted(group, scan.folds)
    dof = round(scan.dof * len(kept) / len(named.groups))
    squared_change = scan.by_fold(apart**2)[kept]
    fall, errors = rms_reduction(named.errors[group, kept], rival.errors[group, kept], squared_change, dof)
    return fall > LOOK_ALIKE_SHARE and errors > STANDARD_ERRORS

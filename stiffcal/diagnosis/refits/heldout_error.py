"""The error in held-out poses, in metres and radians, of the present model and of it with each candidate."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.answers.heldout_results import ErrorAsValidated, ErrorInExperiment
from stiffcal.diagnosis.scans.base_rows import bounds_of_candidate
from stiffcal.diagnosis.scans.choosing import choice_without_each_group
from stiffcal.diagnosis.scans.load_scan import LoadScan, fold_rows
from stiffcal.diagnosis.scans.scan import Trial, helped
from stiffcal.diagnosis.scans.scoring import Score
from stiffcal.estimation.unknowns import amplitudes, with_estimates
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.readings.state_kinds import measured_kinds
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.measurements.rms import Rms
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.validation.heldout import corrected_for_freedom, heldout_residuals
from stiffcal.validation.schemes import LEAVE_ONE_POSE_OUT
from stiffcal.validation.validate import rms_of


def _own_columns(scan: LoadScan, n_columns: int) -> Floats:
    """Return (n_columns,) 1 of the columns whose part of the residual is predicted, 0 of those of the geometry.

    Like every other rms, with what errors of the geometry leave; a sag is a run's own unknown, as its offset is.
    """
    own = np.ones(n_columns)
    n_sags = 0 if scan.geometry is None else len(scan.geometry.sag)
    own[scan.n_columns : len(scan.columns) - n_sags] = 0.0
    return own


def _with_candidate(scan: LoadScan, trial: Trial | None) -> tuple[Floats, Floats]:
    """Return columns (p + q, m, n) with a candidate's after the model's own, and a copy of the residual (m, n)."""
    if trial is None:
        return scan.columns, scan.residual.copy()
    regressor = trial.regressor.whole()
    return np.concatenate([scan.columns, regressor.columns]), scan.residual - regressor.fixed


def _explained(columns: Floats, values: Floats, fold: Integers) -> Floats:
    """Return (m, n) what columns (k, m, n) make with values (F, k) of the folds, by their numbers (n,) in order."""
    found, (_, number) = np.zeros(columns.shape[1:]), np.unique(fold, return_inverse=True)
    for column, value in zip(columns, values[number].T, strict=True):
        found += column * value
    return found


def _take_out_slip(residual: Floats, score: Score, columns: Floats, own: Floats) -> None:
    """Take a slip out of (m, n) residuals, in place.

    No other pose shows it: in its own it is judged by the load cycles, as its score is.
    """
    for positions, change in score.in_run:
        states = np.unique(positions % residual.shape[1])
        residual[:, states] -= np.tensordot(change * own, columns[:, :, states], axes=1)


def left_out_residual(scan: LoadScan, trial: Trial | None) -> Floats:
    """Return (m, n) residuals with each pose left out in turn, its run's offset taken out.

    Parameters
    ----------
    scan : the scan.
    trial : the candidate, None for the present model.
    """
    score = scan.base if trial is None else trial.score
    if score.left.without is None:
        return corrected_for_freedom(scan.space.unwhitened(score.left.residual), scan.fit.data)
    columns, residual = _with_candidate(scan, trial)
    own = _own_columns(scan, len(columns))
    residual -= _explained(columns, score.left.without * own, scan.fold_of_state)
    _take_out_slip(residual, score, columns, own)
    return corrected_for_freedom(scan.space.centred(residual[None])[0], scan.fit.data)


def residual_without_folds(scan: LoadScan, trial: Trial | None, fold: Integers) -> Floats:
    """Return (m, n) residuals with each fold left out in turn, its run's offset taken out.

    What `left_out_residual` is of single poses, by whatever is left out together.

    Parameters
    ----------
    scan : the scan.
    trial : the candidate, None for the present model.
    fold : (n,) number of what is left out with each state; states of a run share one.
    """
    score = scan.base if trial is None else trial.score
    columns, residual = _with_candidate(scan, trial)
    problem = scan.leave_out(fold_rows(scan.fit.data, fold))
    if trial is not None:
        regressor = trial.regressor.whole()
        *added, fixed = scan.space.rows(np.concatenate([regressor.columns, regressor.fixed[None]]))
        problem = problem.with_columns(np.array(added), *bounds_of_candidate(regressor), fixed)
    own = _own_columns(scan, len(columns))
    residual -= _explained(columns, problem.steps * own, fold)
    _take_out_slip(residual, score, columns, own)
    return corrected_for_freedom(scan.space.centred(residual[None])[0], scan.fit.data)


def left_out_rms(scan: LoadScan, trial: Trial | None) -> Rms:
    """Return the rms in held-out poses."""
    return Rms.of(rms_of(left_out_residual(scan, trial), scan.fit.data))


def rms_after_choosing(scan: LoadScan) -> Rms:
    """Return the rms in held-out poses where the choice of the candidate is repeated without each group of poses.

    Each pose is predicted by the candidate that the other groups choose, fitted without that pose; translation and
    rotation are taken from the residuals themselves, as a candidate may lower one of them alone.
    """
    chosen = choice_without_each_group(scan)[scan.groups]
    residual = np.empty_like(scan.residual)
    for number in np.unique(chosen):
        states = np.isin(scan.fold_of_state, np.flatnonzero(chosen == number))
        trial = None if number == 0 else scan.trials[number - 1]
        residual[:, states] = left_out_residual(scan, trial)[:, states]
    return Rms.of(rms_of(residual, scan.fit.data))


def as_validated(states: LoadStates, present: Fit, with_missing: Fit | None) -> ErrorAsValidated | None:
    """Return the errors of models as ``validate`` states them; None where it leaves out single poses, as the search.

    Parameters
    ----------
    states : the campaign's load states. present : the present model's fit. with_missing : that with what is missing.
    """
    heldout = heldout_residuals(states, present)
    if heldout.scheme == LEAVE_ONE_POSE_OUT:
        return None
    return ErrorAsValidated(
        scheme=heldout.scheme,
        rms=Rms.of(rms_of(heldout.residual, heldout.data)),
        with_missing=None if with_missing is None else fitted_rms(states, with_missing),
    )


def fitted_rms(states: LoadStates, fit: Fit) -> Rms:
    """Return a fit's rms in held-out poses."""
    heldout = heldout_residuals(states, fit)
    return Rms.of(rms_of(heldout.residual, heldout.data))


def contribution(scan: LoadScan, trial: Trial) -> Floats:
    """Return (m, n) what the candidate adds to the displacements, its run's mean taken out."""
    regressor = trial.regressor.whole()
    amplitude = trial.score.solution[len(trial.score.solution) - len(regressor.symbols) :]
    added = np.einsum("qmn,q->mn", regressor.columns, amplitude) + regressor.fixed
    return np.asarray(scan.space.centred(added[None])[0])


def size_at_tool(scan: LoadScan, trial: Trial) -> float:
    """Return the rms of what the candidate adds at the tool, m."""
    return float(rms_of(contribution(scan, trial), scan.fit.data)["translation"] or 0.0)


def poses_helped(scan: LoadScan, trial: Trial) -> int:
    """Return in how many poses the held-out error falls."""
    return int(np.count_nonzero(helped(scan, trial)))


def errors_by_experiment(scan: LoadScan, trial: Trial) -> list[ErrorInExperiment]:
    """Return the errors in what is left out, by kind of experiment; empty where the scan is of one kind."""
    kinds = measured_kinds(scan.fit.data)
    if len(kinds) < 2:
        return []
    folds = members_of(scan.fold_of_state)
    fell = helped(scan, trial)
    before, after = left_out_residual(scan, None), left_out_residual(scan, trial)
    errors = []
    for kind, members in kinds:
        own = scan.fit.data.subset(members)
        of_kind = np.array([members[states_of_fold].any() for states_of_fold in folds], dtype=np.bool_)
        errors.append(
            ErrorInExperiment(
                experiment=kind.name,
                before=rms_of(before[:, members], own)[kind.measure],
                after=rms_of(after[:, members], own)[kind.measure],
                n_fell=int(np.count_nonzero(fell[of_kind])),
                n_folds=int(np.count_nonzero(of_kind)),
            )
        )
    return errors


def with_values_of(scan: LoadScan, trial: Trial) -> CompliantRobot:
    """Return the model with the candidate, both with the values that the scan found with all poses."""
    fit = scan.fit
    from stiffcal.diagnosis.scans.lack_of_fit import fitted_values

    columns = fit.columns
    robot = with_estimates(fit.robot, columns, amplitudes(fit.robot, columns) + trial.score.solution[: len(columns)])
    added = PlacedEffect(trial.candidate.effect, trial.candidate.place, fitted_values(trial))
    return CompliantRobot(robot.chain, (*robot.placed, added), robot.deformed)

"""The error of a model of rows in what is left out, in the unit of the readings."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.of_rows.row_scan import RowScan
from stiffcal.diagnosis.scans.choosing import choice_without_each_group
from stiffcal.diagnosis.scans.scan import Trial
from stiffcal.kinds.row_search import RowProblem
from stiffcal.measurements.rms import Rms


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


def rms_after_choosing_rows(scan: RowScan, problem: RowProblem) -> Rms:
    """Return the rms of what is left out with the choice of the candidate repeated without each group of it."""
    chosen = choice_without_each_group(scan)[scan.groups]
    residual = scan.residual[0].copy()
    for number in np.unique(chosen):
        rows = np.concatenate([scan.folds[k] for k in np.flatnonzero(chosen == number)])
        residual[rows] = left_out_residual(scan, None if number == 0 else scan.trials[number - 1])[rows]
    return rms_of_rows(residual, problem)


def rms_of_rows(values: Floats, problem: RowProblem) -> Rms:
    """Return the rms of (k,) values in the problem's measure."""
    return Rms.of({"translation": None, "rotation": None, problem.measure: float(np.sqrt(np.mean(values**2)))})


def size_in_rows(scan: RowScan, trial: Trial) -> float:
    """Return the rms of what a candidate adds, in the measure's unit, free constants taken out."""
    count = len(trial.regressor.symbols)
    amplitude = trial.score.solution[len(trial.score.solution) - count :]
    added = np.einsum("qmk,q->mk", trial.regressor.columns, amplitude)
    return float(np.sqrt(np.mean((scan.space.rows(added[None])[0] * scan.space.sigma) ** 2)))

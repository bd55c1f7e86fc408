"""What a remainder of torque over motion follows when no effect accounts for it.

For each thing that was logged a smooth curve over it is added to the model, once whatever the direction and once with
the direction's sign, and judged as effects are: in what is left out of the fit, so that passes which err each in its
own way follow nothing by chance. The folds, whole speeds or seconds of motion, are drawn anew as blocks: neighbouring
samples are no repeats of each other, and where the noise is not known nothing else shows what chance makes.
"""

from __future__ import annotations

import numpy as np

from stiffcal import wording
from stiffcal.arrays import Floats
from stiffcal.diagnosis.answers.results import ResidualDependence
from stiffcal.diagnosis.of_rows.row_scan import RowScan
from stiffcal.diagnosis.scans.lack_of_fit import f_tail, rms_reduction
from stiffcal.diagnosis.thresholds import LACK_OF_FIT_P, LEAST_FALL, STANDARD_ERRORS
from stiffcal.kinds.row_search import RowProblem

# Below this share nothing is reported as followed.
LEAST_SHARE = 0.1
# A smooth curve: up to the cube.
DEGREE = 3
# Resamplings of the folds, and the least share in which the error must fall where the noise is not known.
DRAWS, LEAST_OF_DRAWS = 2000, 0.975


def what_rows_follow(scan: RowScan, problem: RowProblem) -> list[ResidualDependence]:
    """Return what the residual of the scan's model follows, largest share first."""
    if len(scan.folds) < 2:
        return []
    before = scan.base.heldout
    total = float(before.sum())
    floor = float(scan.dof) if scan.fit.noise is not None else 0.0
    direction, found = problem.course().direction, []
    model, covariates = scan.leave_out(), problem.covariates()
    for covariate in covariates:
        curves = _curves(covariate.value, direction)
        free = np.full(len(curves), np.inf)
        followed = model.with_columns(scan.space.rows(curves[:, None]), -free, free)
        left = followed.residual
        after, change = scan.by_fold(left**2), scan.by_fold((scan.base.left.residual - left) ** 2)
        fall, errors = rms_reduction(before, after, change, scan.dof)
        residual_dof = scan.residual_dof - len(curves)
        if residual_dof <= 0 or fall <= LEAST_FALL or errors <= STANDARD_ERRORS:
            continue
        drop = (scan.base.sum_of_squares - followed.sum_of_squares) / len(curves)
        statistic = drop / max(followed.sum_of_squares / residual_dof, 1e-300)
        if f_tail(statistic, len(curves), residual_dof) * len(covariates) > LACK_OF_FIT_P:
            continue
        in_draws = share_of_draws(before - after)
        if scan.fit.noise is None and in_draws < LEAST_OF_DRAWS:
            continue
        share = float(np.clip((total - after.sum()) / max(total - floor, 1e-12), 0.0, 1.0))
        if share > LEAST_SHARE:
            words = (
                f"{covariate.words}; {problem.subject.left_out} the error decreases in {wording.share(in_draws)} of "
                f"{DRAWS} resamplings of whole {problem.folds_in_words}"
            )
            found.append(ResidualDependence(follows=covariate.name, share=share, seen=words, in_resamplings=in_draws))
    return sorted(found, key=lambda dependence: -(dependence.share or 0.0))


def share_of_draws(fall: Floats) -> float:
    """Return the share of resamplings of F folds in which their falls (F,) add up to more than nothing."""
    drawn = np.random.default_rng(0).integers(fall.size, size=(DRAWS, fall.size))
    return float(np.mean(fall[drawn].sum(axis=1) > 0.0))


def _curves(value: Floats, direction: Floats) -> Floats:
    """Return (2 · DEGREE, k) powers of a covariate (k,), whatever the direction and with its sign."""
    scaled = 2.0 * (value - value.min()) / np.ptp(value) - 1.0
    powers = np.stack([np.polynomial.legendre.Legendre.basis(degree)(scaled) for degree in range(1, DEGREE + 1)])
    return np.concatenate([powers, powers * direction])

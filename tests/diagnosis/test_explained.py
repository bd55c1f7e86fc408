"""The share of the error that effects explain, where values are not known without some of the poses."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.diagnosis.scans.explained import Explained, explained_share, predictive_squares
from stiffcal.diagnosis.scans.folds import FoldProducts
from stiffcal.diagnosis.scans.lack_of_fit import LackOfFit
from stiffcal.diagnosis.scans.scan import Scan
from stiffcal.diagnosis.scans.scoring import score_variants
from stiffcal.diagnosis.thresholds import LEAST_EXPLAINED

FOLDS, PER_FOLD = 8, 12


class PlainRows:
    """Rows that are white already."""

    n_constants = 0

    def rows(self, stack: Floats) -> Floats:
        return stack.reshape(len(stack), -1)


def scan_of(columns: Floats, values: Floats) -> Scan:
    """Return the scan of a linear model with columns (p, n) fitted to values (n,)."""
    folds = tuple(np.arange(k * PER_FOLD, (k + 1) * PER_FOLD) for k in range(FOLDS))
    solution = np.linalg.lstsq(columns.T, values, rcond=None)[0]
    residual = values - solution @ columns
    bound = np.full(len(columns), np.inf)
    products = FoldProducts.of(np.concatenate([columns, residual[None]]), folds)
    groups = np.arange(FOLDS)
    base = score_variants([products], -bound, bound, groups)
    fit = cast(Any, SimpleNamespace(noise=SimpleNamespace(dof=np.inf, source="repeats"), robot=None))
    return Scan(
        fit, base, (), folds, groups, values.size, len(columns), 1, PlainRows(), columns[:, None, :], residual[None],
        (-bound, bound), outside=np.zeros((0, len(columns) + 1)),
    )  # fmt: skip


def lack_of(scan: Scan, p_value: float) -> LackOfFit:
    ratio = float(np.sqrt(scan.base.heldout.sum() / scan.dof))
    statistic = scan.base.sum_of_squares / (scan.dof - scan.n_columns)
    return LackOfFit(statistic, (float(scan.dof - scan.n_columns), np.inf), p_value, ratio)


def columns_of_one_fold(rng: np.random.Generator) -> Floats:
    """A constant, and a column that all but the first fold hardly feel."""
    few = np.full(FOLDS * PER_FOLD, 0.05) + 0.01 * rng.standard_normal(FOLDS * PER_FOLD)
    few[:PER_FOLD] = 1.0 + 0.1 * rng.standard_normal(PER_FOLD)
    return np.stack([np.ones(FOLDS * PER_FOLD), few])


def test_predictive_squares_are_weighed_by_the_covariance_of_the_prediction() -> None:
    rng = np.random.default_rng(3)
    columns = columns_of_one_fold(rng)
    scan = scan_of(columns, columns.T @ [2.0, 30.0] + rng.standard_normal(FOLDS * PER_FOLD))
    for fold, squares in zip(scan.folds, predictive_squares(scan), strict=True):
        rest = np.setdiff1d(np.arange(FOLDS * PER_FOLD), fold)
        values = scan.residual[0]
        covariance = np.linalg.inv(columns[:, rest] @ columns[:, rest].T)
        error = values[fold] - columns[:, fold].T @ covariance @ columns[:, rest] @ values[rest]
        spread = np.eye(PER_FOLD) + columns[:, fold].T @ covariance @ columns[:, fold]
        assert squares == pytest.approx(error @ np.linalg.solve(spread, error), rel=1e-6)


def test_what_is_not_known_without_a_pose_is_no_missing_effect() -> None:
    """Held-out errors of the true model exceed the noise, as one fold alone shows one of its values."""
    excess = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        columns = columns_of_one_fold(rng)
        values = columns.T @ [2.0, 30.0] + rng.standard_normal(FOLDS * PER_FOLD)
        first, last = scan_of(columns[:1], values), scan_of(columns, values)
        excess.append(lack_of(last, 0.5).ratio)
        explained = explained_share(first, last, lack_of(first, 0.0), lack_of(last, 0.5))
        assert explained.share >= LEAST_EXPLAINED
    assert np.mean(excess) > 1.3


def test_a_model_that_does_not_fit_is_judged_by_its_held_out_errors() -> None:
    rng = np.random.default_rng(5)
    columns = columns_of_one_fold(rng)
    other = np.repeat(rng.standard_normal(FOLDS), PER_FOLD)
    values = columns.T @ [2.0, 8.0] + 3.0 * other + rng.standard_normal(FOLDS * PER_FOLD)
    first, last = scan_of(columns[:1], values), scan_of(columns, values)
    assert explained_share(first, last, lack_of(first, 0.0), lack_of(last, 1e-6)).share < LEAST_EXPLAINED


def lack(ratio: float) -> LackOfFit:
    return LackOfFit(ratio**2, (100.0, np.inf), 0.0, ratio)


def scan_with_heldout(heldout: list[float]) -> Scan:
    """Return as much of a scan as the share needs: held-out squares of each pose, in units of the noise."""
    squares = np.array(heldout)
    base = SimpleNamespace(heldout=squares)
    return cast("Scan", SimpleNamespace(base=base, dof=10 * len(squares), folds=tuple(range(len(squares)))))


def share_between(before: list[float], after: list[float]) -> Explained:
    ratios = [float(np.sqrt(np.sum(squares) / (10 * len(squares)))) for squares in (before, after)]
    return explained_share(scan_with_heldout(before), scan_with_heldout(after), lack(ratios[0]), lack(ratios[1]))


def test_the_share_is_of_the_avoidable_error_and_has_an_interval_over_poses() -> None:
    explained = share_between([50.0, 60.0, 40.0, 50.0] * 3, [14.0, 14.0, 14.0, 14.0] * 3)
    assert explained.share == pytest.approx(0.9)
    assert 0.85 < explained.low < 0.9 < explained.high < 0.95


def test_a_share_that_one_pose_makes_has_a_wide_interval() -> None:
    explained = share_between([400.0] + [20.0] * 11, [10.0] + [20.0] * 11)
    assert explained.share > 0.7
    assert explained.low < 0.1

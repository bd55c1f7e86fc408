"""The batched solves of the diagnosis against plain least squares."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from stiffcal.diagnosis.scans.folds import FoldProducts, fold_products, inner_outside
from stiffcal.diagnosis.scans.load_scan import LoadScan
from stiffcal.diagnosis.scans.normal_equations import quadratic, solve_within, without_rows
from stiffcal.diagnosis.scans.scoring import score_variants
from stiffcal.diagnosis.scans.slips import score_in_run
from stiffcal.estimation.leave_out import LeaveOut
from stiffcal.estimation.unknowns import free_columns
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs


@pytest.mark.parametrize("likeness", [0.0, 0.9, 0.999])
def test_bounded_solution_is_the_best_within_bounds(likeness: float) -> None:
    """Against scipy's bounded least squares, also where columns are much alike and parameters must leave their bounds.

    Rounding of inner products with columns alike to 1 − 1e-3 is 1e-16 / 1e-3.
    """
    rng = np.random.default_rng(4)
    lower, upper = np.array([-np.inf, -0.2, 0.0, 0.0, 0.0, 0.0, -1.0]), np.array([np.inf] * 6 + [0.1])
    columns, target = rng.normal(size=(80, 60, 7)), rng.normal(size=(80, 60))
    columns = np.sqrt(1.0 - likeness) * columns + np.sqrt(likeness) * columns[:, :, :1]
    normal, right = columns.transpose(0, 2, 1) @ columns, np.einsum("bnk,bn->bk", columns, target)
    near = np.array([0.0, -0.2, 0.0, 1.0, 0.0, 1.0, 0.1])
    for start in (None, near):
        found = solve_within(normal, right, lower, upper, start)
        assert np.all((found >= lower) & (found <= upper))
        for A, b, x in zip(columns, target, found, strict=True):
            best = lsq_linear(A, b, bounds=(lower, upper), method="bvls", tol=1e-14).x
            assert np.sum((A @ x - b) ** 2) <= (1.0 + 1e-9) * np.sum((A @ best - b) ** 2)


def test_leaving_folds_out_equals_refitting() -> None:
    """HeldoutResiduals squares from inner products are those of fits really made without the fold."""
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(4, 120))
    folds = [np.arange(k, 120, 6) for k in range(6)]
    score = score_variants([FoldProducts.of(rows, folds)], np.full(3, -np.inf), np.full(3, np.inf), np.arange(6))
    for number, fold in enumerate(folds):
        rest = np.setdiff1d(np.arange(120), fold)
        x, *_ = np.linalg.lstsq(rows[:3, rest].T, rows[3, rest], rcond=None)
        left = rows[3, fold] - x @ rows[:3, fold]
        assert score.heldout[number] == pytest.approx(float(left @ left), rel=1e-6)
        assert score.left.without is not None
        assert np.allclose(score.left.without[number], x, rtol=1e-6)
        assert np.allclose(score.left.residual[fold], left, rtol=1e-6)
        assert score.left.rest[number] == pytest.approx(float(np.sum((rows[3, rest] - x @ rows[:3, rest]) ** 2)))
    assert np.allclose(np.diagonal(score.nested), score.heldout, rtol=1e-6)


def test_the_shape_is_chosen_without_the_fold_it_is_judged_on() -> None:
    """Of two variants the one that is better on the rest is judged, also where the other suits the fold better."""
    rng = np.random.default_rng(2)
    truth, noise = rng.normal(size=90), 0.01 * rng.normal(size=90)
    residual = truth + noise
    folds = [np.arange(30), np.arange(30, 60), np.arange(60, 90)]
    tempting = rng.normal(size=90)
    tempting[:30] = residual[:30]  # perfect on the first fold, useless elsewhere
    products = [FoldProducts.of(np.stack([column, residual]), folds) for column in (truth, tempting)]
    score = score_variants(products, np.array([-np.inf]), np.array([np.inf]), np.arange(3))
    assert score.variant == 0
    assert score.heldout[0] == pytest.approx(float(noise[:30] @ noise[:30]), rel=0.2)


def test_the_change_of_a_prediction_is_of_the_variant_that_is_judged() -> None:
    """Also of what a variant adds without a parameter, and without what a prior adds to the inner products."""
    rng, open_to = np.random.default_rng(5), np.full(2, np.inf)
    folds, groups, prior = [np.arange(k, 60, 3) for k in range(3)], np.arange(3), np.array([[1.4, 0.0]])
    column, residual = rng.normal(size=(2, 60))
    base = score_variants(
        [FoldProducts.of(np.stack([column, residual]), folds, inner_outside(prior, 1))],
        -open_to[:1],
        open_to[:1],
        groups,
    )
    variants = [
        FoldProducts.of(np.stack([column, rng.normal(size=60), residual - fixed]), folds, inner_outside(prior, 2))
        for fixed in 0.3 * rng.normal(size=(4, 60))
    ]
    alone = [score_variants([variant], -open_to, open_to, groups, base) for variant in variants]
    for one in alone:
        moved = (base.left.residual - one.left.residual) ** 2
        np.testing.assert_allclose(one.prediction_change, [moved[fold].sum() for fold in folds], rtol=1e-12)
    together = score_variants(variants, -open_to, open_to, groups, base)
    judged = [int(np.argmin([abs(one.heldout[f] - together.heldout[f]) for one in alone])) for f in range(3)]
    assert len(set(judged)) > 1
    np.testing.assert_allclose(
        together.prediction_change, [alone[k].prediction_change[f] for f, k in enumerate(judged)], rtol=1e-12
    )


def test_quadratic_is_the_sum_of_squares() -> None:
    """|r − x·c|² from inner products."""
    rng = np.random.default_rng(3)
    rows, x = rng.normal(size=(3, 40)), np.array([0.3, -1.2])
    left = rows[2] - x @ rows[:2]
    assert quadratic(rows @ rows.T, x) == pytest.approx(float(left @ left))


def test_columns_whose_rows_are_all_left_out_are_zero() -> None:
    """With both of two poses left out, what the subtraction leaves of the columns is rounding, and explains nothing."""
    rng = np.random.default_rng(2)
    rows = rng.normal(size=(4, 90)) * np.array([[1.0], [1e3], [1e-3], [1.0]])
    folds = [np.arange(k, 90, 3) for k in range(3)]
    products = fold_products(rows, folds)
    shuffled = products[[2, 0, 1]].sum(axis=0)  # in another order, as another processor sums
    assert np.all(without_rows(shuffled, products.sum(axis=0)) == 0.0)
    some = without_rows(shuffled, products[0])
    assert np.allclose(some, products[1] + products[2], rtol=1e-12)
    score = score_variants([FoldProducts(products[:2], rows, folds[:2])], np.zeros(3), np.full(3, np.inf), np.arange(2))
    # both left out: nothing is known, and the residual of either is what it was
    assert score.nested[0, 1] == pytest.approx(products[1, -1, -1])
    assert score.nested[1, 0] == pytest.approx(products[0, -1, -1])


def test_no_parameters_have_no_values() -> None:
    none = np.zeros(0)
    assert solve_within(np.zeros((4, 3, 0, 0)), np.zeros((4, 3, 0)), none, none).shape == (4, 3, 0)


def test_a_slip_changes_its_pose_in_every_repeated_choice_alike() -> None:
    """What its load cycles say of the slipped pose stands for that pose with and without any other one left out."""
    rng = np.random.default_rng(6)
    rows, folds = rng.normal(size=(5, 120)), [np.arange(k, 120, 4) for k in range(4)]
    open_below, open_above = np.full(4, -np.inf), np.full(4, np.inf)
    products, groups = fold_products(rows, folds), np.arange(4)
    plain = products[:, [0, 1, 2, 4]][:, :, [0, 1, 2, 4]]
    base = score_variants([FoldProducts(plain, rows[[0, 1, 2, 4]], folds)], open_below[:3], open_above[:3], groups)
    score = score_variants([FoldProducts(products, rows, folds)], open_below, open_above, groups, base)
    stretches = np.split(folds[2], 3)
    without_slip = LeaveOut(rows[[0, 1, 2, 4]], stretches, np.zeros((0, 4)), open_below[:3], open_above[:3])
    slipped = LeaveOut(rows, stretches, np.zeros((0, 5)), open_below, open_above)
    judged = score_in_run(score, base, (without_slip, slipped), 2, groups)
    np.testing.assert_allclose(judged.nested[:, 2] - score.nested[:, 2], judged.heldout[2] - score.heldout[2])
    others = [0, 1, 3]
    np.testing.assert_array_equal(judged.nested[:, others], score.nested[:, others])
    np.testing.assert_array_equal(judged.heldout[others], score.heldout[others])


def test_what_is_known_before_stays_when_a_pose_is_left_out() -> None:
    """Of plain least squares with those rows below the others; the residual is moved by what they want."""
    rng = np.random.default_rng(7)
    rows, folds = rng.normal(size=(4, 60)), [np.arange(k, 60, 5) for k in range(5)]
    known = np.array([[3.0, 1.0, 0.7], [0.0, 2.0, -0.4]])  # of the first two columns, the residual last
    products = FoldProducts.of(rows, folds, outside=inner_outside(known, 3))
    free = np.full(3, np.inf)
    score = score_variants([products], -free, free, np.arange(5))
    wide = np.insert(known, 2, 0.0, axis=1)
    for number, fold in enumerate(folds):
        kept = np.setdiff1d(np.arange(60), fold)
        stack = np.vstack([rows[:, kept].T, wide])
        x = np.linalg.lstsq(stack[:, :3], stack[:, 3], rcond=None)[0]
        assert score.left.without is not None
        np.testing.assert_allclose(score.left.without[number], x, rtol=1e-8)
        assert score.heldout[number] == pytest.approx(float(np.sum((rows[3, fold] - x @ rows[:3, fold]) ** 2)))
    whole = np.vstack([rows.T, wide])
    best = np.linalg.lstsq(whole[:, :3], whole[:, 3], rcond=None)[0]
    assert score.sum_of_squares == pytest.approx(float(np.sum((whole[:, :3] @ best - whole[:, 3]) ** 2)))


def test_an_effect_that_goes_leaves_its_part_of_what_is_known_of_several() -> None:
    """Torques that two moments explain together, of which one is taken out: the other has to explain them alone."""
    robot = joint_springs(six_axes(), np.full(6, 1e6))
    fit = SimpleNamespace(robot=robot, columns=free_columns(robot))
    known = np.zeros((1, 7))
    known[0, :2], known[0, -1] = (2.0, 3.0), 0.5
    kept = np.array([False, True, True, True, True, True])
    left = LoadScan.known_before(cast(LoadScan, SimpleNamespace(outside=known, fit=fit)), kept, 6)
    np.testing.assert_allclose(left, [[3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5 + 2.0 * 1e-6]])

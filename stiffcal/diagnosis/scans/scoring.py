"""How a candidate does in poses left out of its fit, from small matrices of inner products.

For every pose (fold) the base model, the candidate and the residual are refitted without it, in closed form (`folds`,
`few_rows`). All pairs of groups of folds, for the choice repeated inside each fold, go through one batched solve.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.scans.few_rows import AddedColumns
from stiffcal.diagnosis.scans.folds import FoldProducts, LeftOutFolds
from stiffcal.diagnosis.scans.normal_equations import quadratic, solve_within, without_rows


@dataclass(frozen=True)
class Score:
    """A candidate's errors, whitened sums of squares."""

    sum_of_squares: float
    """Of the residual, fitted with all poses."""
    heldout: Floats
    """(F,) on each pose left out."""
    nested: Floats
    """(F, F) on pose g with poses f and g left out (row f, column g; the diagonal is ``heldout``)."""
    solution: Floats
    """(k,) parameters with all poses, base model first."""
    left: LeftOutFolds
    """What the fits without each pose leave, at the shape that is best with all; rows as `RowSpace` returns them."""
    variant: int
    """Which shape was best with all poses."""
    prediction_change: Floats
    """(F,) by how much the candidate moves the prediction of each pose left out, whitened squares; zero for the base
    model itself.
    """
    normal: Floats
    """(k, k) whitened inner products of the columns, all poses together: the information of ``solution``."""
    in_run: tuple[tuple[Integers, Floats], ...] = ()
    """Of a slip, for each load cycle of the slipped pose: the positions (s,) of its rows, and by how much the
    parameters (k,) fitted without it differ from the base model's.
    """


def score_variants(
    variants: Iterable[FoldProducts | AddedColumns],
    lower: Floats,
    upper: Floats,
    groups: Integers,
    base: Score | None = None,
) -> Score:
    """Score a candidate whose shape is chosen, in every fold anew, among variants.

    Parameters
    ----------
    variants : the base columns, the candidate's and the residual, per shape; taken one after the other.
    lower, upper : (k,) bounds.
    groups : (F,) group of each fold for the repeated choice.
    base : the base model's score, of rows in the same order; its parameters come first.
    """
    fitted, solutions, normals, left_out, heldout = [], [], [], [], []
    squared_change, nested, nested_training = [], [], []
    for variant in variants:
        total = variant.total
        solution = solve_within(total[:-1, :-1], total[:-1, -1], lower, upper)
        solutions.append(solution)
        normals.append(total[:-1, :-1])
        fitted.append(float(quadratic(total, solution)))
        left, squares = variant.left_out(lower, upper, solution)
        left_out.append(left)
        heldout.append(squares)
        squared_change.append(np.zeros_like(squares) if base is None else variant.moved(left, base.left))
        twice_left, twice_training = _without_pairs(variant.grouped(groups), total, (lower, upper), solution)
        nested.append(twice_left)
        nested_training.append(twice_training)
        del variant  # let go of its rows before the next one's are made
    best = int(np.argmin(fitted))
    chosen = np.argmin([left.rest for left in left_out], axis=0)
    picked = np.argmin(nested_training, axis=0)
    folds = np.arange(len(groups))
    return Score(
        sum_of_squares=fitted[best],
        heldout=np.stack(heldout)[chosen, folds],
        nested=np.take_along_axis(np.stack(nested), picked[None], axis=0)[0],
        solution=solutions[best],
        left=left_out[best],
        variant=best,
        prediction_change=np.stack(squared_change)[chosen, folds],
        normal=normals[best],
    )


def _without_pairs(
    grouped: Floats, total: Floats, bounds: tuple[Floats, Floats], near: Floats
) -> tuple[Floats, Floats]:
    """Return (G, G) squares on group h with groups g and h left out, and those that the same fits leave of the rest.

    Parameters
    ----------
    grouped : (G, k + 1, k + 1) inner products of each group. total : of all together.
    bounds, near : as in `solve_folds`.
    """
    first, second = np.triu_indices(len(grouped))
    apart = (first != second)[:, None, None]
    rest = without_rows(total, grouped[first] + np.where(apart, grouped[second], 0.0))
    solution = solve_within(rest[:, :-1, :-1], rest[:, :-1, -1], *bounds, near)
    left, training = np.empty((2, len(grouped), len(grouped)))
    left[first, second], left[second, first] = (quadratic(grouped[of], solution) for of in (second, first))
    training[first, second] = training[second, first] = quadratic(rest, solution)
    return left, training

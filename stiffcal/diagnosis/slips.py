"""Slips inside a run: every state is tried as the first after a step, in closed form.

A step from state s to the end of its run is local to that run. Its column per axis, with the run's offset taken out,
needs nothing but sums of the states' precisions from s on: with P_i the precision of state i, T = Σ P_i over the run
and A_s = Σ_{i ≥ s} P_i, the step's normal matrix is A_s − A_s T⁻¹ A_s and its right side Σ_{i ≥ s} P_i r_i. A thousand
states cost as much as one refit. The best of them is then scored with everything else refitted.

Poses left out cannot judge it: the run that slipped is the only one to show it. There, whole load cycles are left out
in its stead (physics, section 4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.folds import FoldProducts
from stiffcal.diagnosis.normal_equations import quadratic, solve_within, without_rows
from stiffcal.diagnosis.scoring import Score
from stiffcal.identification.projection import Projection
from stiffcal.identification.readings import Observations
from stiffcal.identification.row_layout import GAUGE, TRANSLATION
from stiffcal.model.effect import Effect, ParameterRole
from stiffcal.reduction.load_cycles import UNLOADED_SHARE

# A step's columns that keep less than this share of their squares next to the run's offset are the offset.
LEAST_SHARE = 1e-9


def is_slip(effect: Effect) -> bool:
    """Return whether an effect begins at one state of the campaign."""
    return any(
        spec.role is ParameterRole.NONLINEAR and spec.discrete and spec.symbol == "state" for spec in effect.parameters
    )


def best_slip(space: Projection, residual: Floats) -> int | None:
    """Return the position of the state where a step explains most of the residual; None where no run has two states.

    Parameters
    ----------
    space : whitening and runs.
    residual : (m, n) measured minus predicted.
    """
    data = space.data
    precision = space.whitening.precision()
    centred = space.centred(residual[None])[0]
    weighted = np.einsum("abn,bn->an", precision, centred)
    axes = data.rows_of(TRANSLATION, GAUGE)
    best, most = None, 0.0
    for start, count in zip(space.offsets.edges, space.offsets.counts, strict=True):
        if count < 2:
            continue
        run_rows = slice(int(start), int(start + count))
        after = np.cumsum(precision[:, :, run_rows][:, :, ::-1], axis=2)[:, :, ::-1]
        right = np.cumsum(weighted[:, run_rows][:, ::-1], axis=1)[:, ::-1]
        total = np.linalg.pinv(after[:, :, 0], hermitian=True)
        normal = after - np.einsum("abn,bc,cdn->adn", after, total, after)
        inside = np.moveaxis(normal[np.ix_(axes, axes)], -1, 0)[1:]
        target = right[axes].T[1:]
        # A step before all readings in use is the run's offset: what rounding leaves of it is no step.
        known = np.einsum("naa->na", inside) > LEAST_SHARE * np.diagonal(after[:, :, 0])[axes]
        scale = np.where(known, np.sqrt(np.maximum(np.einsum("naa->na", inside), 1e-300)), np.inf)
        inside = inside / scale[:, :, None] / scale[:, None, :] + 1e-9 * np.eye(len(axes))
        gain = np.einsum("na,na->n", target / scale, np.linalg.solve(inside, (target / scale)[..., None])[..., 0])
        if gain.size and gain.max() > most:
            best, most = int(start) + 1 + int(np.argmax(gain)), float(gain.max())
    return best


def load_stretches(data: Observations, members: Integers) -> list[Integers]:
    """Return a run's states in stretches from one unloaded reading to the next."""
    size = np.sqrt(np.sum(data.wrench[:3, members] ** 2, axis=0))
    if not size.any():
        size = np.sqrt(np.sum(data.wrench[3:, members] ** 2, axis=0))
    resting = np.flatnonzero(size <= UNLOADED_SHARE * size.max())
    cuts = resting[(resting > 0) & (resting < len(members) - 1)] + 1
    return [stretch for stretch in np.split(members, cuts) if len(stretch)]


def score_in_run(
    score: Score,
    base: Score,
    products: FoldProducts,
    rows: Floats,
    stretches: Sequence[Integers],
    fold: int,
    groups: Integers,
    lower: Floats,
    upper: Floats,
) -> Score:
    """Return a slip's score with the pose that slipped judged by leaving out its load cycles.

    Parameters
    ----------
    score : as poses left out give it.
    base : the base model's.
    products : inner products, base columns first, residual last.
    rows : (k + 1, m · n) the whitened rows behind them.
    stretches : positions in ``rows`` of each stretch.
    fold : number of the pose's fold.
    groups : (F,) groups of folds for the repeated choice.
    lower, upper : (k,) bounds.
    """
    total = products.total
    stretch_products = np.stack([rows[:, stretch] @ rows[:, stretch].T for stretch in stretches])
    rest = without_rows(total, stretch_products)
    p = len(base.solution)
    plain = np.ix_(range(len(stretch_products)), [*range(p), total.shape[0] - 1], [*range(p), total.shape[0] - 1])
    x = solve_within(rest[:, :-1, :-1], rest[:, :-1, -1], lower, upper)
    y = solve_within(rest[plain][:, :-1, :-1], rest[plain][:, :-1, -1], lower[:p], upper[:p])
    fall = float(np.sum(quadratic(stretch_products[plain], y) - quadratic(stretch_products, x)))
    change = x.copy()
    change[:, :p] -= y
    heldout, squared_change, nested = score.heldout.copy(), score.prediction_change.copy(), score.nested.copy()
    better = base.heldout[fold] - fall
    nested[:, groups[fold]] += better - heldout[fold]
    heldout[fold] = better
    squared_change[fold] = float(np.einsum("fk,fkl,fl->", change, stretch_products[:, :-1, :-1], change))
    in_run = tuple(zip(stretches, change, strict=True))
    return replace(score, heldout=heldout, prediction_change=squared_change, nested=nested, in_run=in_run)

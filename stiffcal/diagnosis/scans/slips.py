"""Slips inside a run: every state is tried as the first after a step, in closed form.

A step from state s to the end of its run is local to that run. Its column per axis, with the run's offset taken out,
needs nothing but sums of the states' precisions from s on: with P_i the precision of state i, T = Σ P_i over the run
and A_s = Σ_{i ≥ s} P_i, the step's normal matrix is A_s − A_s T⁻¹ A_s and its right side Σ_{i ≥ s} P_i r_i. A thousand
states cost as much as one refit. The best of them is then scored with everything else refitted.

Poses left out cannot judge it: the run that slipped is the only one to show it. There, whole load cycles are left out
in its stead (physics, section 4).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.scans.scoring import Score
from stiffcal.estimation.leave_out import LeaveOut
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import GAUGE, TRANSLATION
from stiffcal.model.effect import Effect, ParameterRole
from stiffcal.reduction.loads.cycles import UNLOADED_SHARE

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
    problems: tuple[LeaveOut, LeaveOut],
    fold: int,
    groups: Integers,
) -> Score:
    """Return a slip's score with the pose that slipped judged by leaving out its load cycles.

    Parameters
    ----------
    score : as poses left out give it.
    base : the base model's.
    problems : of the base model, and of it with the slip, the load cycles of the pose that slipped as folds.
    fold : number of the pose's fold.
    groups : (F,) groups of folds for the repeated choice.
    """
    plain, slipped = problems
    cycles = np.concatenate(slipped.folds)
    fall = float(np.sum(plain.residual[cycles] ** 2) - np.sum(slipped.residual[cycles] ** 2))
    change = slipped.steps.copy()
    change[:, : len(base.solution)] -= plain.steps
    heldout, squared_change, nested = score.heldout.copy(), score.prediction_change.copy(), score.nested.copy()
    better = base.heldout[fold] - fall
    nested[:, groups[fold]] += better - heldout[fold]
    heldout[fold] = better
    in_run = tuple(zip(slipped.folds, change, strict=True))
    squared_change[fold] = sum(float(np.sum((step @ slipped.white[:-1, cycle]) ** 2)) for cycle, step in in_run)
    return replace(score, heldout=heldout, prediction_change=squared_change, nested=nested, in_run=in_run)

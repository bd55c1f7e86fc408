"""One look at the whole catalogue: every candidate refitted with everything else, judged on unseen poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.diagnosis.candidates import Candidate, variants
from stiffcal.diagnosis.scoring import Score, fold_products, score_variants
from stiffcal.diagnosis.thresholds import CHOICE_FOLDS, RESAMPLINGS
from stiffcal.identification.fit import Fit
from stiffcal.identification.identify import raw_whitening
from stiffcal.identification.noise import Whitening, whiten
from stiffcal.identification.observation import Observations, evaluate, free_columns
from stiffcal.identification.projection import Projection
from stiffcal.identification.signatures import Linearised, Signature
from stiffcal.model.effect import Sort
from stiffcal.validation.unseen import pose_folds

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# The leaders' shapes are narrowed down; who is further behind than this is not near.
REFINED = 8
# Grids step by a factor of two to three; four rounds of square roots from 1.6 bring a shape to within three per cent.
REFINING_FACTOR = 1.6
REFINING_ROUNDS = 4


@dataclass(frozen=True)
class Trial:
    """A candidate with its errors.

    Attributes
    ----------
    candidate : who.
    signature : at the shape that was best with all poses.
    score : its errors.
    n_variants : how many shapes were tried.
    """

    candidate: Candidate
    signature: Signature
    score: Score
    n_variants: int


@dataclass(frozen=True)
class Scan:
    """All candidates beside one model.

    Attributes
    ----------
    fit : the model they are tried beside.
    base : the model's own errors, as a candidate without columns.
    trials : best unseen error first.
    folds : (F,) lists of row positions, one pose each.
    fold_of_state : (n,).
    groups : (F,) group of each fold in which the choice is repeated.
    dof : whitened rows minus the runs' offsets.
    n_columns : parameters of the base model that were free.
    n_tried : how many signatures were compared, shapes included.
    space : whitened rows.
    columns : (p, m, n) of the base model's free parameters, about the fit.
    residual : (m, n) measured minus predicted, offsets not taken out.
    """

    fit: Fit
    base: Score
    trials: tuple[Trial, ...]
    folds: tuple[Integers, ...]
    fold_of_state: Integers
    groups: Integers
    dof: int
    n_columns: int
    n_tried: int
    space: Projection
    columns: Floats
    residual: Floats


def weights_of(fit: Fit) -> Whitening:
    """Return the whitening of the fit's data with the fit's noise (residuals' own size where none is known)."""
    data = fit.data
    if fit.noise is None:
        squares = np.where(data.seen, fit.residual**2, 0.0)
        size = raw_whitening(data, None).scale.copy()
        for kind in (False, True):
            rows = data.rotational == kind
            if rows.any():
                n_seen = max(1, int(np.count_nonzero(data.seen[rows])))
                size[rows] = np.where(data.seen[rows], 1.0 / np.sqrt(np.sum(squares[rows]) / n_seen), 0.0)
        return Whitening(size)
    pieces = [block.sensitivity for block in evaluate(fit.robot, data, (), with_sensitivity=True, rigid=True)]
    sensitivity = np.concatenate([piece for piece in pieces if piece is not None], axis=2)
    return whiten(fit.noise, data, sensitivity)


def fold_rows(data: Observations, fold: Integers) -> list[Integers]:
    """Return each fold's positions in whitened rows (m · n)."""
    m = len(data.measured)
    return [(np.arange(m)[:, None] * data.n_states + np.flatnonzero(fold == k)).ravel() for k in np.unique(fold)]


def choice_groups(n_folds: int) -> Integers:
    """Deal folds into groups for the repeated choice, every n-th to the same."""
    return np.arange(n_folds, dtype=np.int64) % min(n_folds, CHOICE_FOLDS)


def scan_candidates(fit: Fit, candidates: Sequence[Candidate], whitening: Whitening | None = None) -> Scan:
    """Try every candidate beside the present fit.

    Parameters
    ----------
    fit : the present model's fit.
    candidates : who is tried.
    whitening : weights to use in place of the fit's own.
    """
    data = fit.data
    state = Linearised.about(fit.robot, data)
    space = Projection.of(data, weights_of(fit) if whitening is None else whitening)
    fixed = fit.held | {one.name for one in fit.parameters if one.fixed}
    columns = free_columns(fit.robot, fixed)
    own = np.concatenate([block.columns for block in evaluate(fit.robot, data, columns)], axis=2)
    residual = np.where(data.seen, data.measured - state.predicted, 0.0)
    base_rows, residual_row = space.rows(own), space.rows(residual[None])
    fold = pose_folds(data)
    folds = fold_rows(data, fold)
    groups = choice_groups(len(folds))
    low, high = _base_bounds(fit, columns)
    base = score_variants([fold_products(np.concatenate([base_rows, residual_row]), folds)], low, high, groups)
    inner_base = _inner(base_rows, base_rows, folds)
    trials, n_tried = [], 0
    for candidate in candidates:
        found = list(variants(candidate, state, fit.robot.chain))
        if not found:
            continue
        n_tried += len(found)
        products = [_products(one, base_rows, residual_row, inner_base, space, folds) for one in found]
        own_low, own_high = _bounds(found[0])
        score = score_variants(products, np.concatenate([low, own_low]), np.concatenate([high, own_high]), groups, base)
        trials.append(Trial(candidate, found[score.variant], score, len(found)))
    trials.sort(key=lambda trial: float(np.sum(trial.score.unseen)))

    def refined(trial: Trial) -> Trial:
        return _refined(trial, state, base_rows, residual_row, inner_base, space, folds, low, high, groups, base)

    trials[:REFINED] = [refined(trial) for trial in trials[:REFINED]]
    trials.sort(key=lambda trial: float(np.sum(trial.score.unseen)))
    dof = int(np.count_nonzero(data.seen)) - (len(np.unique(data.run)) * len(data.measured) if data.free_offset else 0)
    return Scan(
        fit, base, tuple(trials), tuple(folds), fold, groups, dof, len(columns), max(n_tried, 1), space, own, residual
    )


def _refined(
    trial: Trial,
    state: Linearised,
    base_rows: Floats,
    residual_row: Floats,
    inner_base: Floats,
    space: Projection,
    folds: Sequence[Integers],
    low: Floats,
    high: Floats,
    groups: Integers,
    base: Score,
) -> Trial:
    """Narrow a law's continuous shape down, between the neighbours of the best of its grid, in all folds alike."""
    effect, place = trial.candidate.effect, trial.candidate.place
    continuous = [spec.symbol for spec in effect.parameters if spec.sort is Sort.SHAPE and not spec.discrete]
    if not continuous:
        return trial
    own_low, own_high = _bounds(trial.signature)
    known = {tuple(trial.signature.shape[s] for s in continuous): trial.signature}
    best, spread = dict(trial.signature.shape), REFINING_FACTOR
    for _ in range(REFINING_ROUNDS):
        for symbol in continuous:
            for factor in (1.0 / spread, spread):
                spec = effect.spec(symbol)
                shape = {**best, symbol: float(np.clip(best[symbol] * factor, spec.lower, spec.upper))}
                key = tuple(shape[s] for s in continuous)
                if key not in known:
                    signature = state.signature(effect, place, shape)
                    if signature.symbols == trial.signature.symbols:
                        known[key] = signature
        found = list(known.values())
        products = [_products(one, base_rows, residual_row, inner_base, space, folds) for one in found]
        score = score_variants(products, np.concatenate([low, own_low]), np.concatenate([high, own_high]), groups, base)
        best, spread = dict(found[score.variant].shape), np.sqrt(spread)
    return Trial(trial.candidate, found[score.variant], score, trial.n_variants + len(found))


def _inner(left: Floats, right: Floats, folds: Sequence[Integers]) -> Floats:
    return np.stack([left[:, fold] @ right[:, fold].T for fold in folds])


def _products(
    signature: Signature,
    base_rows: Floats,
    residual_row: Floats,
    inner_base: Floats,
    space: Projection,
    folds: Sequence[Integers],
) -> Floats:
    """Return (F, k + 1, k + 1) inner products of base columns, the candidate's and the residual."""
    rows = space.rows(signature.columns)
    last = residual_row - space.rows(signature.fixed[None]) if signature.fixed.any() else residual_row
    p, q = len(base_rows), len(rows)
    mine = np.concatenate([rows, last])
    result = np.empty((len(folds), p + q + 1, p + q + 1))
    result[:, :p, :p] = inner_base
    cross = _inner(base_rows, mine, folds)
    result[:, :p, p:] = cross
    result[:, p:, :p] = np.swapaxes(cross, 1, 2)
    result[:, p:, p:] = _inner(mine, mine, folds)
    return result


def _base_bounds(fit: Fit, columns: Sequence[object]) -> tuple[Floats, Floats]:
    """Return how far the base model's parameters can go from where they are; only compliances have an edge at zero."""
    low, high = [], []
    from stiffcal.identification.observation import Column

    for column in columns:
        assert isinstance(column, Column)
        one = fit.robot.placed[column.placed]
        spec = one.effect.spec(column.symbol)
        edge = -np.inf
        if column.sort is Sort.AMPLITUDE and (spec.inverse or spec.lower == 0.0):
            edge = min(0.0, -one.amplitude(column.symbol))
        low.append(edge)
        high.append(np.inf)
    return np.array(low), np.array(high)


def _bounds(signature: Signature) -> tuple[Floats, Floats]:
    """Return the bounds of a candidate's amplitudes: what cannot be negative is not."""
    low, high = [], []
    for symbol in signature.symbols:
        spec = signature.effect.spec(symbol)
        low.append(0.0 if spec.inverse or (spec.lower >= 0.0 and spec.sort is Sort.AMPLITUDE) else -np.inf)
        high.append(np.inf)
    return np.array(low), np.array(high)


def confidence(scan: Scan, seed: int = 0) -> dict[str, float]:
    """Return how often each candidate comes first when poses are drawn anew, with replacement."""
    if not scan.trials:
        return {}
    rng = np.random.default_rng(seed)
    n_folds = len(scan.folds)
    weights = rng.multinomial(n_folds, np.full(n_folds, 1.0 / n_folds), size=RESAMPLINGS)
    errors = np.stack([trial.score.unseen for trial in scan.trials]) @ weights.T
    first = np.bincount(np.argmin(errors, axis=0), minlength=len(scan.trials)) / RESAMPLINGS
    return {trial.candidate.name: float(share) for trial, share in zip(scan.trials, first, strict=True)}


def chosen_in_every_fold(scan: Scan) -> Floats:
    """Return (G,) unseen squares with the choice of the candidate repeated in every group of poses.

    The base model takes part in the choice: where nothing helps, nothing is chosen.
    """
    n_groups = int(scan.groups.max()) + 1
    everyone = [scan.base, *(trial.score for trial in scan.trials)]
    errors = []
    for score in everyone:
        inner = score.nested.sum(axis=1) - np.diagonal(score.nested)
        errors.append(inner)
    chosen = np.argmin(np.stack(errors), axis=0)
    return np.array([everyone[chosen[g]].nested[g, g] for g in range(n_groups)])

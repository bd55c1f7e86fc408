"""One look at the whole catalogue: every candidate refitted with everything else, judged on held-out poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.candidates import Candidate, variants
from stiffcal.diagnosis.results import AgreementWithPlaces
from stiffcal.diagnosis.scoring import (
    FoldProducts,
    FoldRows,
    Score,
    fold_products,
    quadratic,
    rows_by_fold,
    score_variants,
    solve_within,
)
from stiffcal.diagnosis.thresholds import CHOICE_FOLDS, MANY_SHAPES
from stiffcal.identification.regressors import Regressor, RegressorMaker, StoredRegressor
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import Effect, ParameterRole

# The leaders' shapes are narrowed down; who is further behind than this is not near.
REFINED = 8
# Grids step by a factor of two to three; four rounds of square roots from 1.6 bring a shape to within three per cent.
REFINING_FACTOR = 1.6
REFINING_ROUNDS = 4
# Errors that differ by less, relatively, are equal: they are sums of many squares.
ROUNDING = 1e-9
# Shapes (values of nonlinear parameters) that take part in the choice in every fold: the best with all poses, and two.
VARIANTS_IN_FOLDS = 3


class KnownNoise(Protocol):
    """The noise of a fit, as far as the judge asks for it."""

    @property
    def dof(self) -> float:
        """Degrees of freedom behind it; infinite where it is known."""

    @property
    def source(self) -> str:
        """Where it is known from, as in `NoiseSource`."""


class ModelFit(Protocol):
    """A fit of any kind of experiment, as far as the search and the judge ask for it."""

    @property
    def robot(self) -> CompliantRobot:
        """The model with the estimated values."""

    @property
    def noise(self) -> KnownNoise | None:
        """Noise of the readings; None where it cannot be determined."""


class RowSpace(Protocol):
    """Turns what was measured or predicted into independent rows of unit variance."""

    def rows(self, stack: Floats) -> Floats:
        """Return (k, m · n) whitened rows of (k, m, n), free constants eliminated."""


@dataclass(frozen=True)
class Trial:
    """A candidate with its errors."""

    candidate: Candidate
    """Effect and place."""
    regressor: Regressor | StoredRegressor
    """At the shape that was best with all poses; in large campaigns it is made again when it is asked for."""
    score: Score
    """Its errors."""
    n_variants: int
    """How many shapes were tried."""
    places: AgreementWithPlaces | None = None
    """What absolute places show of it; None where they cannot show it."""


@dataclass(frozen=True)
class Scan:
    """All candidates as additions to one model, of any kind of experiment.

    m quantities are measured in each of n states (or means over bins of samples, which are called states here).
    """

    fit: ModelFit
    """The model to which they are added."""
    base: Score
    """The model's own errors, as a candidate without columns."""
    trials: tuple[Trial, ...]
    """Best held-out error first."""
    folds: tuple[Integers, ...]
    """(F,) lists of row positions: what is left out together, one pose (or speed, or block of time) each."""
    groups: Integers
    """(F,) group of each fold in which the choice is repeated."""
    dof: int
    """Whitened rows minus the free constants."""
    n_columns: int
    """Parameters of the base model that were free."""
    n_tried: int
    """How many regressors were compared, shapes included."""
    space: RowSpace
    """Whitened rows."""
    columns: Floats
    """(p + q, m, n) of the base model's free parameters, about the fit, and of q nuisance errors."""
    residual: Floats
    """(m, n) measured minus predicted, free constants not taken out."""
    bounds: tuple[Floats, Floats]
    """(p + q,) lower and upper, how far the base model's parameters and the nuisance errors can go."""
    prior: Floats | None = field(default=None, kw_only=True)
    """(p + q,) precision of each before the data: zero of the model's own parameters; None without nuisance errors."""

    @property
    def own_columns(self) -> Floats:
        """(p, m, n) of the base model's free parameters alone."""
        return self.columns[: self.n_columns]

    def products(self, rows: Floats) -> Floats:
        """Return (F, k, k) inner products of rows (k, m · n) fold by fold, `columns` first, their prior included."""
        return fold_products(rows, self.folds, self.prior)

    def of_folds(self, rows: Floats) -> Floats | FoldRows:
        """Return what `score_variants` takes of rows (k + 1, m · n), `columns` first, residual last."""
        order, cuts = sorted_by_fold(self.folds)
        few = None if has_prior(self.prior) else rows_by_fold(rows[:, order], cuts)
        return few or self.products(rows)

    def drift(self) -> tuple[float, float, float]:
        """Return the residuals' drift within runs: `LackOfFit.drift`, its p-value, correlation of successive ones."""
        return 1.0, 1.0, 0.0

    def mean_square(self) -> float:
        """Return the residuals' mean square, for models of the same data whose noise is not known."""
        return float(np.sum(self.residual**2))

    def release(self) -> None:
        """Let go of what regressors could be made again from."""


def choice_groups(n_folds: int) -> Integers:
    """Deal folds into groups for the repeated choice, every n-th to the same."""
    return np.arange(n_folds, dtype=np.int64) % min(n_folds, CHOICE_FOLDS)


def has_prior(prior: Floats | None) -> bool:
    """Return whether anything is known of a parameter before the data."""
    return prior is not None and bool(prior.any())


def sorted_by_fold(folds: Sequence[Integers]) -> tuple[Integers, list[slice]]:
    """Return (m · n,) indices that sort whitened rows by fold, and the rows of each fold after sorting."""
    ends = np.cumsum([len(fold) for fold in folds])
    return np.concatenate(folds), [slice(int(e) - len(fold), int(e)) for e, fold in zip(ends, folds, strict=True)]


@dataclass(frozen=True)
class BaseRows:
    """The present model's rows, sorted by fold, to which candidates are added."""

    state: RegressorMaker
    """Makes candidates' regressors about the model."""
    space: RowSpace
    """Whitening and free constants."""
    rows: Floats
    """(p, m · n) base columns, sorted by fold."""
    residual: Floats
    """(1, m · n) whitened residual, sorted by fold."""
    order: Integers
    """(m · n,) indices that sort whitened rows by fold."""
    cuts: list[slice]
    """The rows of each fold after sorting."""
    inner_sum: Floats
    """(p, p) inner products of the base columns over all folds."""
    groups: Integers
    """(F,) groups of folds for the repeated choice."""
    low: Floats
    """(p,) lower bounds of the base model's parameters."""
    high: Floats
    """(p,) their upper bounds."""
    base: Score
    """Its score."""
    prior: Floats | None = None
    """(p,) precision of the base columns' parameters before the data; None: none."""

    @cached_property
    def inner(self) -> Floats:
        """(F, p, p) inner products of the base columns, by fold."""
        return fold_products(self.rows, self.cuts, self.prior)

    @classmethod
    def of(
        cls, state: RegressorMaker, space: RowSpace, stack: Floats, folds: Sequence[Integers], low: Floats,
        high: Floats, prior: Floats | None = None,
    ) -> BaseRows:  # fmt: skip
        """Prepare; ``stack`` (p + 1, m, n) holds the base columns and the residual, ``prior`` (p,) their precision."""
        order, cuts = sorted_by_fold(folds)
        rows = space.rows(stack)[:, order]
        few = None if has_prior(prior) else rows_by_fold(rows, cuts)
        whole, groups = few or FoldProducts(fold_products(rows, cuts, prior)), choice_groups(len(folds))
        base, inner = score_variants([whole], low, high, groups), whole.total[:-1, :-1]
        return cls(state, space, rows[:-1], rows[-1:], order, cuts, inner, groups, low, high, base, prior)

    def rows_of(self, regressor: Regressor) -> Floats:
        """Return (q + 1, m · n): the candidate's columns and what is left of the residual, sorted by fold."""
        rows = self.space.rows(np.concatenate([regressor.columns, regressor.fixed[None]]))[:, self.order]
        rows[-1] = self.residual[0] - rows[-1]
        return np.asarray(rows)

    def products(self, mine: Floats) -> Floats:
        """Return (F, k + 1, k + 1) inner products of base columns, the candidate's and the residual."""
        p, q = len(self.rows), len(mine)
        whole = np.concatenate([self.rows, mine])
        result = np.empty((len(self.cuts), p + q, p + q))
        result[:, :p, :p] = self.inner
        for k, cut in enumerate(self.cuts):
            result[k, :, p:] = whole[:, cut] @ mine[:, cut].T
        result[:, p:, :p] = np.swapaxes(result[:, :p, p:], 1, 2)
        return result

    def of_folds(self, mine: Floats) -> Floats | FoldRows:
        """Return what `score_variants` takes of base columns, the candidate's and the residual."""
        few = None if has_prior(self.prior) else rows_by_fold(np.concatenate([self.rows, mine]), self.cuts)
        return few or self.products(mine)

    def bounds(self, regressor: Regressor) -> tuple[Floats, Floats]:
        """Return the bounds of base and candidate."""
        low, high = amplitude_bounds(regressor)
        return np.concatenate([self.low, low]), np.concatenate([self.high, high])

    def sum_of_squares(self, regressor: Regressor) -> float:
        """Return the residual's whitened sum of squares with a candidate added, fitted with all poses."""
        candidate_rows, p = self.rows_of(regressor), len(self.rows)
        total = np.empty((p + len(candidate_rows), p + len(candidate_rows)))
        total[:p, :p] = self.inner_sum
        total[:p, p:], total[p:, p:] = self.rows @ candidate_rows.T, candidate_rows @ candidate_rows.T
        total[p:, :p] = total[:p, p:].T
        solution = solve_within(total[:-1, :-1], total[:-1, -1], *self.bounds(regressor))
        return float(quadratic(total, solution))

    def score(self, regressors: Sequence[Regressor]) -> tuple[Score, Regressor]:
        """Score a candidate, the choice among its foremost shapes repeated in every fold; and the best of them."""
        rows = (self.rows_of(regressor) for regressor in regressors)
        score = score_variants(map(self.of_folds, rows), *self.bounds(regressors[0]), self.groups, self.base)
        best = regressors[score.variant]
        if best.fixed.any():
            score = replace(score, prediction_change=self._prediction_change(best, score))
        return score, best

    def _prediction_change(self, regressor: Regressor, score: Score) -> Floats:
        """Return (F,) by how much a candidate moves each pose left out, what it adds without a parameter included."""
        candidate_rows, p = self.rows_of(regressor), len(self.rows)
        change = score.without.copy()
        change[:, :p] -= self.base.without
        shift = self.residual[0] - candidate_rows[-1]
        rows = np.concatenate([self.rows, candidate_rows[:-1]])
        squares = [np.sum((x @ rows[:, cut] + shift[cut]) ** 2) for x, cut in zip(change, self.cuts, strict=True)]
        return np.array(squares)


def score_together(scan: Scan, trials: Sequence[Trial]) -> Score:
    """Score several candidates as one, each at the shape that was best alone."""
    regressors = [trial.regressor for trial in trials]
    remaining = scan.residual - sum(regressor.fixed for regressor in regressors)
    rows = scan.space.rows(
        np.concatenate([scan.columns, *(regressor.columns for regressor in regressors), remaining[None]])
    )
    bounds = [scan.bounds, *(amplitude_bounds(regressor) for regressor in regressors)]
    low, high = (np.concatenate(side) for side in zip(*bounds, strict=True))
    return score_variants([scan.of_folds(rows)], low, high, scan.groups, scan.base)


def scan_rows(
    ground: BaseRows,
    candidates: Sequence[Candidate],
    kept: Callable[[Regressor | StoredRegressor], Regressor | StoredRegressor] = lambda regressor: regressor,
    try_one: Callable[[Candidate], Trial | None] | None = None,
) -> tuple[tuple[Trial, ...], int]:
    """Try candidates as additions to a model; return them, best held-out error first, and how many were tried.

    Parameters
    ----------
    ground : the model's rows.
    candidates : who is tried.
    kept : what is kept of a regressor that is not looked at any more.
    try_one : tries one candidate, where that is not `try_candidate`; None where it does not show.
    """
    trials = []
    for candidate in candidates:
        trial = try_candidate(candidate, ground) if try_one is None else try_one(candidate)
        if trial is not None:
            trials.append(replace(trial, regressor=kept(trial.regressor)))
    n_tried = sum(trial.n_variants for trial in trials)
    trials.sort(key=ranked_error)
    for place, trial in enumerate(trials[:REFINED]):
        refined = _refine_nonlinear(trial, ground)
        trials[place] = replace(refined, regressor=kept(refined.regressor))
    trials.sort(key=ranked_error)
    return tuple(trials), max(n_tried, 1)


def try_candidate(candidate: Candidate, ground: BaseRows, most: int = MANY_SHAPES) -> Trial | None:
    """Try one candidate, in the best of its shapes, ``most`` at most; None where it does not show."""
    shapes = _BestShapes(ground)
    for regressor in variants(candidate, ground.state, most):
        shapes.add(regressor)
    if not shapes.n_tried:
        return None
    score, best = shapes.score()
    return Trial(replace(candidate, effect=best.effect), best, score, shapes.n_tried)


class _BestShapes:
    """The shapes of a candidate that leave least with all poses, which are the best without one or two too."""

    def __init__(self, ground: BaseRows) -> None:
        self._ground = ground
        self._best: list[tuple[float, int, Regressor]] = []
        self.n_tried = 0

    def add(self, regressor: Regressor) -> None:
        """Try a shape."""
        self._best.append((self._ground.sum_of_squares(regressor), self.n_tried, regressor))
        self._best.sort(key=lambda entry: entry[:2])
        del self._best[VARIANTS_IN_FOLDS:]
        self.n_tried += 1

    @property
    def shape(self) -> Mapping[str, float]:
        """The best shape so far."""
        return self._best[0][2].shape

    def score(self) -> tuple[Score, Regressor]:
        """Score the candidate in poses left out, and return the best of its shapes."""
        return self._ground.score([regressor for _, _, regressor in self._best])


def is_possible_shape(effect: Effect, shape: Mapping[str, float]) -> bool:
    """Return whether shape parameters can be, the amplitudes being usual ones."""
    return effect.impossible({spec.symbol: shape.get(spec.symbol, spec.typical) for spec in effect.parameters}) is None


def _refine_nonlinear(trial: Trial, ground: BaseRows) -> Trial:
    """Narrow a law's continuous shape down, between the neighbours of the best of its grid, in all folds alike."""
    effect, place = trial.candidate.effect, trial.candidate.place
    continuous = [
        spec.symbol for spec in effect.parameters if spec.role is ParameterRole.NONLINEAR and not spec.discrete
    ]
    if not continuous:
        return trial
    best, spread = dict(trial.regressor.shape), REFINING_FACTOR
    known, shapes = {tuple(best[s] for s in continuous)}, _BestShapes(ground)
    shapes.add(ground.state.regressor(effect, place, best))
    for _ in range(REFINING_ROUNDS):
        for symbol in continuous:
            for factor in (1.0 / spread, spread):
                spec = effect.spec(symbol)
                shape = {**best, symbol: float(np.clip(best[symbol] * factor, spec.lower, spec.upper))}
                key = tuple(shape[s] for s in continuous)
                if key not in known and is_possible_shape(effect, shape):
                    regressor = ground.state.regressor(effect, place, shape)
                    if regressor.symbols == trial.regressor.symbols:
                        known.add(key)
                        shapes.add(regressor)
        best, spread = dict(shapes.shape), np.sqrt(spread)
    score, regressor = shapes.score()
    return Trial(trial.candidate, regressor, score, trial.n_variants + shapes.n_tried)


def amplitude_bounds(regressor: Regressor | StoredRegressor) -> tuple[Floats, Floats]:
    """Return the bounds of a candidate's amplitudes: what cannot be negative is not."""
    low, high = [], []
    for symbol in regressor.symbols:
        spec = regressor.effect.spec(symbol)
        low.append(0.0 if spec.inverse or (spec.lower >= 0.0 and spec.role is ParameterRole.AMPLITUDE) else -np.inf)
        high.append(np.inf)
    return np.array(low), np.array(high)


def bounds_with(scan: Scan, regressor: Regressor | StoredRegressor) -> tuple[Floats, Floats]:
    """Return (k,) the lower and upper bounds of the base model's parameters and a candidate's amplitudes."""
    low, high = (np.concatenate(pair) for pair in zip(scan.bounds, amplitude_bounds(regressor), strict=True))
    return low, high


def ranked_error(trial: Trial) -> float:
    """Return the whitened squares in poses left out, to nine digits: values that differ by rounding only rank equal.

    Candidates that explain nothing all have the model's own error, and keep their order on every processor.
    """
    return float(f"{np.sum(trial.score.heldout):.8e}")

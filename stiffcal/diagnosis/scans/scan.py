"""One look at the whole catalogue: every candidate refitted with everything else, judged on held-out poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.answers.results import AgreementWithPlaces
from stiffcal.diagnosis.scans.base_rows import BaseRows, bounds_of_candidate
from stiffcal.diagnosis.scans.candidates import Candidate, variants
from stiffcal.diagnosis.scans.scoring import Score
from stiffcal.diagnosis.thresholds import MANY_SHAPES
from stiffcal.errors import Progress, no_progress
from stiffcal.estimation.leave_out import LeaveOut
from stiffcal.estimation.rows import RowSpace
from stiffcal.identification.fitting.regressors import Regressor, StoredRegressor
from stiffcal.model.assembled.composite import CompliantRobot
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
    outside: Floats = field(kw_only=True)
    """(r, p + q + 1) rows of what is known of them before, in no fold, the residual last."""

    @property
    def residual_dof(self) -> int:
        """Degrees of freedom of the base model's sum of squares, to which what is known before belongs."""
        return self.dof + int(np.count_nonzero(self.outside.any(axis=1))) - len(self.columns)

    @property
    def own_columns(self) -> Floats:
        """(p, m, n) of the base model's free parameters alone."""
        return self.columns[: self.n_columns]

    @cached_property
    def fold_of_row(self) -> Integers:
        """(m · n,) fold of each whitened row."""
        result = np.empty(self.residual.size, dtype=np.int64)
        for number, fold in enumerate(self.folds):
            result[fold] = number
        return result

    def by_fold(self, values: Floats) -> Floats:
        """Return (F,) sums of values (m · n) of whitened rows over each fold."""
        return np.bincount(self.fold_of_row, weights=values, minlength=len(self.folds)).astype(np.float64)

    def leave_out(self, folds: Sequence[Integers] | None = None) -> LeaveOut:
        """Return the model's rows with folds left out in turn; None: those of the scan."""
        rows = self.space.rows(np.concatenate([self.columns, self.residual[None]]))
        return LeaveOut(rows, self.folds if folds is None else folds, self.outside, *self.bounds)

    def drift(self) -> tuple[float, float, float]:
        """Return the residuals' drift within runs: `LackOfFit.drift`, its p-value, correlation of successive ones."""
        return 1.0, 1.0, 0.0

    def mean_square(self) -> float:
        """Return the residuals' mean square, for models of the same data whose noise is not known."""
        return float(np.sum(self.residual**2))

    def release(self) -> None:
        """Let go of what regressors could be made again from."""


def scan_rows(
    ground: BaseRows,
    candidates: Sequence[Candidate],
    kept: Callable[[Regressor | StoredRegressor], Regressor | StoredRegressor] = lambda regressor: regressor,
    try_one: Callable[[Candidate], Trial | None] | None = None,
    progress: Progress = no_progress,
) -> tuple[tuple[Trial, ...], int]:
    """Try candidates as additions to a model; return them, best held-out error first, and how many were tried.

    Parameters
    ----------
    ground : the model's rows.
    candidates : who is tried.
    kept : what is kept of a regressor that is not looked at any more.
    try_one : tries one candidate, where that is not `try_candidate`; None where it does not show.
    progress : receives each candidate.
    """
    trials = []
    for done, candidate in enumerate(candidates):
        progress(f"held-out error with each effect: {done + 1} of {len(candidates)}", done / len(candidates))
        trial = try_candidate(candidate, ground) if try_one is None else try_one(candidate)
        if trial is not None:
            trials.append(replace(trial, regressor=kept(trial.regressor)))
    n_tried = sum(trial.n_variants for trial in trials)
    trials.sort(key=ranked_error)
    for place, trial in enumerate(trials[:REFINED]):
        refined = refine_nonlinear(trial, ground)
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


def refine_nonlinear(trial: Trial, ground: BaseRows) -> Trial:
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


def bounds_with(scan: Scan, regressor: Regressor | StoredRegressor) -> tuple[Floats, Floats]:
    """Return (k,) the lower and upper bounds of the base model's parameters and a candidate's amplitudes."""
    low, high = (np.concatenate(pair) for pair in zip(scan.bounds, bounds_of_candidate(regressor), strict=True))
    return low, high


def helped(scan: Scan, trial: Trial) -> Booleans:
    """Return (F,) where the error in what is left out falls with a candidate, by more than rounding."""
    return np.asarray(trial.score.heldout < scan.base.heldout * (1.0 - ROUNDING))


def ranked_error(trial: Trial) -> float:
    """Return the whitened squares in poses left out, to nine digits: values that differ by rounding only rank equal.

    Candidates that explain nothing all have the model's own error, and keep their order on every processor.
    """
    return float(f"{np.sum(trial.score.heldout):.8e}")

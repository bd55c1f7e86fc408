"""From scores to verdicts: supported, possible or rejected; who looks alike; whether the model is good enough."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.diagnosis.scan import Scan, Trial, chosen_in_every_fold
from stiffcal.diagnosis.scoring import Score
from stiffcal.diagnosis.thresholds import (
    ADEQUATE_RATIO,
    FAMILY_P,
    LACK_OF_FIT_P,
    LEAST_FALL,
    LOOK_ALIKE_ERRORS,
    LOOK_ALIKE_SHARE,
    STANDARD_ERRORS,
)
from stiffcal.identification.fit import Fit
from stiffcal.model.effect import Sort

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LackOfFit:
    """The model's residuals against the noise.

    Attributes
    ----------
    statistic : mean whitened square of the residuals over that of repeats, F-distributed where nothing is missing.
    dof : degrees of freedom of the residuals and of the noise.
    p_value : probability of so much by chance.
    ratio : unseen error over noise.
    """

    statistic: float
    dof: tuple[float, float]
    p_value: float
    ratio: float

    @property
    def adequate(self) -> bool:
        """True where the unseen error is the noise, to within five per cent or to within what the noise is known."""
        return self.ratio <= ADEQUATE_RATIO or self.p_value > LACK_OF_FIT_P


def f_tail(statistic: float, dof: float, other: float) -> float:
    """Return the upper tail of the F distribution (χ²/dof where the other degrees of freedom are infinite)."""
    from scipy.special import chdtrc, fdtrc

    if not np.isfinite(other):
        return float(chdtrc(dof, statistic * dof))
    return float(fdtrc(dof, other, statistic))


def lack_of_fit(fit: Fit, scan: Scan) -> LackOfFit | None:
    """Return how the model's residuals stand against the noise; None where no noise is known."""
    if fit.noise is None:
        return None
    dof = scan.dof - scan.n_columns
    statistic = scan.base.fitted / dof
    ratio = float(np.sqrt(np.sum(scan.base.unseen) / scan.dof))
    return LackOfFit(statistic, (float(dof), fit.noise.dof), f_tail(statistic, dof, fit.noise.dof), ratio)


@dataclass(frozen=True)
class Judgement:
    """What the unseen error says of one candidate.

    Attributes
    ----------
    fall : by how much the unseen error falls, in units of the noise.
    errors : the same in standard errors over poses.
    p_value : family-wise.
    possible : the values can be.
    """

    fall: float
    errors: float
    p_value: float
    possible: bool

    @property
    def supported(self) -> bool:
        """True where fall, standard errors and p all hold and the values can be."""
        return self.possible and self.fall > LEAST_FALL and self.errors > STANDARD_ERRORS and self.p_value < FAMILY_P


def _fall(before: Floats, after: Floats, dof: int) -> tuple[float, float]:
    """Return the fall of the rms and its size in standard errors over folds."""
    drop = before - after
    fall = float(np.sqrt(before.sum() / dof) - np.sqrt(max(after.sum(), 0.0) / dof))
    spread = float(np.std(drop, ddof=1) * np.sqrt(len(drop))) if len(drop) > 1 else np.inf
    return fall, float(drop.sum()) / spread if spread > 0.0 else np.inf


def family_p(scan: Scan, trial: Trial) -> float:
    """Return the probability of so large a fall of the fit's squares by chance, for all that were tried together."""
    q = len(trial.signature.symbols) + sum(1 for s in trial.candidate.effect.parameters if s.sort is Sort.SHAPE)
    rest = scan.dof - scan.n_columns - q
    if rest <= 0:
        return 1.0
    # Where more is missing than this candidate, what is left scatters wider than the noise.
    scale = max(1.0, trial.score.fitted / rest)
    drop = max(scan.base.fitted - trial.score.fitted, 0.0)
    other = float(rest) if scan.fit.noise is None else min(float(rest), scan.fit.noise.dof)
    return min(1.0, scan.n_tried * f_tail(drop / scale / max(q, 1), max(q, 1), other))


def possible_values(trial: Trial) -> bool:
    """Return whether the candidate's values can be: something is left of them within their bounds."""
    values = fitted_values(trial)
    if trial.signature.symbols and not any(abs(v) > 0.0 for s, v in values.items() if s in trial.signature.symbols):
        return False
    return trial.candidate.effect.impossible(values) is None


def fitted_values(trial: Trial) -> dict[str, float]:
    """Return the candidate's parameter values: shapes and amplitudes, as reported."""
    values = dict(trial.signature.shape)
    count = len(trial.signature.symbols)
    for symbol, amplitude in zip(
        trial.signature.symbols, trial.score.solution[len(trial.score.solution) - count :], strict=True
    ):
        inverse = trial.candidate.effect.spec(symbol).inverse
        values[symbol] = (1.0 / amplitude if amplitude > 0.0 else np.inf) if inverse else float(amplitude)
    return values


def judge(scan: Scan, trial: Trial) -> Judgement:
    """Judge a candidate by its own unseen errors."""
    fall, errors = _fall(scan.base.unseen, trial.score.unseen, scan.dof)
    return Judgement(fall, errors, family_p(scan, trial), possible_values(trial))


def judge_choice(scan: Scan, leader: Trial) -> Judgement:
    """Judge the leader with the choice repeated in every fold: picking the best of a hundred flatters."""
    fall, errors = _fall(np.diagonal(scan.base.nested).copy(), chosen_in_every_fold(scan), scan.dof)
    own = judge(scan, leader)
    return Judgement(min(fall, own.fall), min(errors, own.errors), own.p_value, own.possible)


def alike(scan: Scan, score: Score, best: Score) -> bool:
    """Return whether a score cannot be told from the best: within two standard errors over poses."""
    behind = score.unseen - best.unseen
    spread = float(np.std(behind, ddof=1) * np.sqrt(len(behind))) if len(behind) > 1 else np.inf
    gap = float(np.sqrt(score.unseen.sum() / scan.dof) - np.sqrt(best.unseen.sum() / scan.dof))
    return float(behind.sum()) <= LOOK_ALIKE_ERRORS * spread or gap <= LOOK_ALIKE_SHARE


def leaders(scan: Scan) -> list[Trial]:
    """Return those that cannot be told from the best, fewest parameters first, then least unseen error."""
    able = [trial for trial in scan.trials if possible_values(trial)]
    if not able:
        return []
    near = [trial for trial in able if alike(scan, trial.score, able[0].score)]
    # Of those, only candidates that help at all by themselves.
    near = [trial for trial in near if judge(scan, trial).supported] or near[:1]
    return sorted(near, key=lambda trial: (trial.candidate.n_parameters, float(trial.score.unseen.sum())))

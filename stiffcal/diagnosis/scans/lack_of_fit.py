"""From scores to verdicts: supported, possible or rejected; who looks alike; whether the model is good enough."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.scans.normal_equations import solve_within
from stiffcal.diagnosis.scans.scan import ModelFit, Scan, Trial, bounds_with
from stiffcal.diagnosis.scans.slips import is_slip
from stiffcal.diagnosis.thresholds import (
    ADEQUATE_RATIO,
    FAMILY_P,
    FARTHEST_NORMAL,
    LACK_OF_FIT_P,
    LEAST_FALL,
    LOOK_ALIKE_ERRORS,
    LOOK_ALIKE_SHARE,
    STANDARD_ERRORS,
)
from stiffcal.identification.answers.document import finite
from stiffcal.measurements.rms import VarianceRatio
from stiffcal.model.effect import ParameterRole


@dataclass(frozen=True)
class LackOfFit:
    """The model's residuals against the noise."""

    statistic: float
    """Mean whitened square of the residuals over that of repeats, F-distributed where nothing is missing."""
    dof: tuple[float, float]
    """Degrees of freedom of the residuals and of the noise."""
    p_value: float
    """Probability of so much by chance."""
    ratio: float
    """Rms error in poses left out over the rms noise; 1 where the model is complete."""
    drift: float = 1.0
    """Residuals' rms over the rms difference of readings a fifth of a run apart, divided by √2: 1 without drift.
    Repeats are a cycle apart, so that drift in between counts as their noise and does not show in ``ratio``.
    """
    drift_p_value: float = 1.0
    """Probability of so large a ``drift`` by chance."""
    lag_one_correlation: float = 0.0
    """Correlation of successive residuals beyond that of the drift."""

    @property
    def drifts(self) -> bool:
        """True where residuals drift in the course of a run: part of the repeats' scatter is then not noise."""
        return self.drift > ADEQUATE_RATIO and self.drift_p_value < LACK_OF_FIT_P

    @property
    def fits(self) -> bool:
        """True where the fit with all poses leaves no more than the noise."""
        return self.p_value > LACK_OF_FIT_P and not self.drifts

    @property
    def adequate(self) -> bool:
        """True where the held-out error is the noise, to within five per cent or to within what the noise is known."""
        return self.fits or (self.ratio <= ADEQUATE_RATIO and not self.drifts)


def f_tail(statistic: float, dof: float, denominator_dof: float) -> float:
    """Return the upper tail of the F distribution (χ²/dof where the denominator's degrees of freedom are infinite)."""
    from scipy.special import chdtrc, fdtrc

    if not np.isfinite(denominator_dof):
        return float(chdtrc(dof, statistic * dof))
    return float(fdtrc(dof, denominator_dof, statistic))


def against_noise(lack: LackOfFit | None) -> VarianceRatio | None:
    """Return residuals against noise as a result; None where that is not known."""
    if lack is None:
        return None
    return VarianceRatio(statistic=lack.statistic, dof=[lack.dof[0], finite(lack.dof[1])], p_value=lack.p_value)


def lack_of_fit(fit: ModelFit, scan: Scan) -> LackOfFit | None:
    """Return how the model's residuals stand against the noise; None where no noise is known."""
    if fit.noise is None:
        return None
    dof = scan.residual_dof
    statistic = scan.base.sum_of_squares / dof
    # Rows are whitened with the noise: the rms of whitened errors in poses left out is error over noise.
    ratio = float(np.sqrt(np.sum(scan.base.heldout) / scan.dof))
    p_value = f_tail(statistic, dof, fit.noise.dof)
    return LackOfFit(statistic, (float(dof), fit.noise.dof), p_value, ratio, *scan.drift())


@dataclass(frozen=True)
class Judgement:
    """The change of the held-out error by one candidate."""

    fall: float
    """By how much the held-out error falls, in units of the noise."""
    errors: float
    """The same in standard errors over poses."""
    p_value: float
    """Family-wise."""
    possible: bool
    """The values can be."""

    @property
    def supported(self) -> bool:
        """True where fall, standard errors and p all hold and the values can be."""
        return self.possible and self.fall > LEAST_FALL and self.errors > STANDARD_ERRORS and self.p_value < FAMILY_P


def rms_reduction(before: Floats, after: Floats, squared_change: Floats, dof: int) -> tuple[float, float]:
    """Return the fall of the rms and its size in standard errors over poses.

    Parameters
    ----------
    before, after : (F,) held-out squares of each pose.
    squared_change : (F,) whitened squares by which the candidate moves the pose's prediction.

    Notes
    -----
    Where a candidate acts in a few poses only — play shows where the torque changes its sign, a bent link where it is
    loaded across — the falls differ widely although each is just what the candidate predicts: e moved by d with
    |e|² − |e − d|² = |d|² on average. The spread of the falls as such would call an effect that explains nine tenths
    of three poses out of twelve doubtful. What measures chance is how far each pose's fall lies from its share by
    ``squared_change``: the standard error of a total by ratio (Cochran, Sampling Techniques, 1977, section 6.4). It is
    never taken smaller than what the noise alone makes, var(|e|² − |e − d|²) = 4 |d|².
    """
    drop, n = before - after, len(before)
    fall = float(np.sqrt(before.sum() / dof) - np.sqrt(max(after.sum(), 0.0) / dof))
    total = float(squared_change.sum())
    if n < 2 or total <= 0.0:
        return fall, 0.0
    deviation = drop - squared_change * (drop.sum() / total)
    variance = max(float(np.sum(deviation**2)) * n / (n - 1), 4.0 * total * max(1.0, float(after.sum()) / dof))
    return fall, float(drop.sum() / np.sqrt(variance))


def family_p(scan: Scan, trial: Trial) -> float:
    """Return the probability of so large a fall of the fit's squares by chance, for all that were tried together."""
    q = len(trial.regressor.symbols) + sum(
        1 for s in trial.candidate.effect.parameters if s.role is ParameterRole.NONLINEAR
    )
    residual_dof = scan.residual_dof - q
    if residual_dof <= 0:
        return 1.0
    # Where more is missing than this candidate, what is left scatters wider than the noise.
    scale = max(1.0, trial.score.sum_of_squares / residual_dof)
    drop = max(scan.base.sum_of_squares - trial.score.sum_of_squares, 0.0)
    denominator_dof = float(residual_dof) if scan.fit.noise is None else min(float(residual_dof), scan.fit.noise.dof)
    return min(1.0, scan.n_tried * f_tail(drop / scale / max(q, 1), max(q, 1), denominator_dof))


def possible_values(scan: Scan, trial: Trial) -> bool:
    """Return whether the candidate's values can be: something is left of them within their bounds.

    What absolute places contradict cannot be.
    """
    if trial.places is not None and trial.places.contradicted:
        return False
    values, symbols = fitted_values(trial), trial.regressor.symbols
    specs = {symbol: trial.candidate.effect.spec(symbol) for symbol in symbols}
    amplitudes = {symbol: spec.amplitude_of(values[symbol]) for symbol, spec in specs.items()}
    if symbols and not any(abs(value) > 0.0 for value in amplitudes.values()):
        return False
    return trial.candidate.effect.impossible(values) is None


def relative_std(trial: Trial) -> float:
    """Return the standard uncertainty of a candidate's size along its fitted values, as a share of it."""
    values = trial.score.solution[len(trial.score.solution) - len(trial.regressor.symbols) :]
    information = float(values @ _information(trial) @ values)
    return 1.0 / float(np.sqrt(information)) if information > 0.0 else np.inf


def _information(trial: Trial) -> Floats:
    """Return (q, q) the information of the data on a candidate's amplitudes, the base model's refitted with them."""
    k = len(trial.score.solution)
    p = k - len(trial.regressor.symbols)
    scale = np.sqrt(np.maximum(np.diagonal(trial.score.normal)[:k], 1e-300))
    normal = trial.score.normal[:k, :k] / np.outer(scale, scale)
    # As in `solve_within`: columns that agree to seven digits share what they explain.
    added, mixed, base = normal[p:, p:], normal[:p, p:], normal[:p, :p] + 1e-10 * np.eye(p)
    return np.asarray((added - mixed.T @ np.linalg.solve(base, mixed)) * np.outer(scale[p:], scale[p:]))


def fitted_values(trial: Trial) -> dict[str, float]:
    """Return the candidate's parameter values: shapes and amplitudes, as reported."""
    values = dict(trial.regressor.shape)
    count = len(trial.regressor.symbols)
    for symbol, amplitude in zip(
        trial.regressor.symbols, trial.score.solution[len(trial.score.solution) - count :], strict=True
    ):
        values[symbol] = trial.candidate.effect.spec(symbol).value_of(float(amplitude))
    return values


def judge(scan: Scan, trial: Trial) -> Judgement:
    """Judge a candidate by its own held-out errors."""
    fall, errors = rms_reduction(scan.base.heldout, trial.score.heldout, trial.score.prediction_change, scan.dof)
    return Judgement(fall, errors, family_p(scan, trial), possible_values(scan, trial))


def alike(scan: Scan, trial: Trial, best: Trial) -> bool:
    """Return whether a candidate cannot be distinguished from the best: within two standard errors over poses.

    Standard errors as in `rms_reduction`: the difference of the two predictions in left-out poses, against the
    measurement. Nor can one whose displacement is the same within the noise (`same_within_noise`), whatever the errors
    in poses left out happen to be.
    """
    if trial is best:
        return True
    score, best_score = trial.score, best.score
    gap = float(np.sqrt(score.heldout.sum() / scan.dof) - np.sqrt(best_score.heldout.sum() / scan.dof))
    if gap <= LOOK_ALIKE_SHARE:
        return True
    squared_change = (score.left.residual - best_score.left.residual) ** 2
    _, errors = rms_reduction(score.heldout, best_score.heldout, scan.by_fold(squared_change), scan.dof)
    return errors <= LOOK_ALIKE_ERRORS or same_within_noise(scan, trial, best)


def same_within_noise(scan: Scan, trial: Trial, other_trial: Trial) -> bool:
    """Return whether each of two candidates reproduces what the other displaces, as fitted, to within the noise.

    Notes
    -----
    If one of them is true, the other, refitted with everything else, leaves λ = |d − P d|² of its displacement d, in
    units of the noise. The difference of their squares over its standard deviation 2√λ is then normal about ± √λ / 2.
    A candidate found two standard errors ahead is the wrong one with odds Φ(−2 − √λ / 2) to Φ(−2 + √λ / 2): one in
    twelve for λ = 1, less than one in a hundred from λ = 4. Below, no error in poses left out distinguishes them.
    """
    if is_slip(trial.candidate.effect) or is_slip(other_trial.candidate.effect):
        return False
    first, second = trial.score.sum_of_squares, other_trial.score.sum_of_squares
    unit = _unit_of_squares(scan, trial if first <= second else other_trial)
    # With so little left the squares of all poses differ by λ + 2√λ z, z normal: a quick no to almost all candidates.
    if abs(first - second) > (LOOK_ALIKE_ERRORS**2 + 2.0 * LOOK_ALIKE_ERRORS * FARTHEST_NORMAL) * unit:
        return False
    left = max(_not_reproduced(scan, trial, other_trial), _not_reproduced(scan, other_trial, trial))
    return left <= LOOK_ALIKE_ERRORS**2 * unit


def _unit_of_squares(scan: Scan, trial: Trial) -> float:
    """Return the square of the scatter that a candidate leaves: 1, more where more is missing or no noise is known."""
    residual_dof = max(scan.residual_dof - len(trial.regressor.symbols), 1)
    scatter = trial.score.sum_of_squares / residual_dof
    # Without a known noise rows are whitened with what the present model leaves, the candidate's displacement included.
    return scatter if scan.fit.noise is None else max(1.0, scatter)


def _not_reproduced(scan: Scan, trial: Trial, other_trial: Trial) -> float:
    """Return the whitened squares that one candidate, fitted with everything else, leaves of another's prediction."""
    own, other, base = trial.regressor, other_trial.regressor, len(scan.columns)
    stack = [scan.columns, other.columns, own.columns, (own.fixed - other.fixed)[None]]
    rows = scan.space.rows(np.concatenate(stack))
    width = base + len(other.columns)
    values = trial.score.solution
    aim = values[:base] @ rows[:base] + values[base:] @ rows[width:-1] + rows[-1]
    columns = rows[:width]
    normal = columns @ columns.T
    known, target = scan.outside[:, :-1], scan.outside[:, -1]
    normal[:base, :base] += known.T @ known
    right = columns @ aim
    right[:base] += known.T @ target
    solution = solve_within(normal, right, *bounds_with(scan, other))
    left = float(solution @ (normal @ solution - 2.0 * right) + aim @ aim + target @ target)
    return max(left - float(np.sum((target - known @ values[:base]) ** 2)), 0.0)

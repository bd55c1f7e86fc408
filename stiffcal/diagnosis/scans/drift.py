"""Whether residuals drift in the course of a run, and how far successive ones are correlated.

Half the mean squared difference over the variance is 1 for independent readings, with variance 1/n (von Neumann 1941;
Young 1941). Readings next to each other may be correlated (air, filters of instruments), and repeats a cycle later
scatter by all of that noise. So readings a fifth of a run apart are compared, up to `LINGERING` readings, and the
variance allows for the correlation within that distance (Bartlett 1946: 1 + 2 Σ ρ²).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.thresholds import ADEQUATE_RATIO, LACK_OF_FIT_P, LINGERING
from stiffcal.identification.readings.observations import Observations


@dataclass(frozen=True)
class Drift:
    """What residuals do in the course of runs."""

    ratio: float = 1.0
    """Their rms over the rms difference of readings a fifth of a run apart, divided by √2: 1 without drift."""
    p_value: float = 1.0
    """Probability of so large a ratio by chance."""
    correlation: tuple[float, ...] = (0.0,)
    """Of readings one, two … apart, beyond that of the drift."""

    @property
    def drifts(self) -> bool:
        """Whether residuals wander further than noise lingers."""
        return self.ratio > ADEQUATE_RATIO and self.p_value < LACK_OF_FIT_P

    @property
    def independent(self) -> float:
        """What a square is worth where several are summed: 1 for independent readings."""
        return 1.0 / (1.0 + 2.0 * sum(value**2 for value in self.correlation))


def drift_of_states(data: Observations, white: Floats, dof: float) -> Drift:
    """Return the drift of load states' residuals; none where runs carry no offsets and no place is absolute.

    Parameters
    ----------
    white : (m, n) whitened residual, 0 where nothing was read. dof : its degrees of freedom.
    """
    walks = data.carries_offset | data.absolute
    if not walks.any():
        return Drift()
    if not data.free_offset:
        # offsets of runs take nothing from differences; what is estimated takes from these as from squares
        dof = float(np.count_nonzero(data.measured_mask))
    group = walking_together(data)
    _, n_of_run = np.unique(group[walks], return_counts=True)
    return drift_of(group, data.measured_mask, white, dof, float(np.median(n_of_run)))


def walking_together(data: Observations) -> Integers:
    """Return (n,) a number of each state's run; all absolute places, in their order, are one."""
    return np.where(data.absolute, int(data.run.max(initial=0)) + 1, data.run)


def drift_of(run: Integers, measured_mask: Booleans, white: Floats, dof: float, length: float) -> Drift:
    """Return the drift of residuals.

    Parameters
    ----------
    run : (n,) number of the run of each state, in their order. measured_mask : (m, n) True where something was read.
    white : (m, n) whitened residual, 0 where nothing was read. dof : its degrees of freedom.
    length : states of a usual run.
    """
    from scipy.special import ndtr

    if dof < 1:
        return Drift()
    lags = int(np.clip(length // 5, 1, LINGERING))
    halves = [_half_square(run, measured_mask, white, lag) for lag in range(1, lags + 1)]
    (far, n_pairs), whole = halves[-1], float(np.sum(white**2)) / dof
    if n_pairs < 2 or far <= 0.0:
        return Drift()
    correlation = np.clip([1.0 - half / far for half, _ in halves], 0.0, 1.0)
    n_independent = n_pairs / (1.0 + 2.0 * float(np.sum(correlation**2)))
    chance = float(ndtr(-(1.0 - far / whole) * np.sqrt(n_independent)))
    return Drift(float(np.sqrt(whole / far)), chance, tuple(correlation.tolist()))


def _half_square(run: Integers, measured_mask: Booleans, white: Floats, lag: int) -> tuple[float, int]:
    """Return half the mean squared difference of readings so many states apart in their runs, and of how many."""
    measured_pairs = (run[lag:] == run[:-lag]) & measured_mask[:, lag:] & measured_mask[:, :-lag]
    n_pairs = int(np.count_nonzero(measured_pairs))
    total = float(np.sum(np.where(measured_pairs, white[:, lag:] - white[:, :-lag], 0.0) ** 2))
    return total / (2.0 * max(n_pairs, 1)), n_pairs

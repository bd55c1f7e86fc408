"""The noise of a torque reading: how neighbouring samples of a pass scatter about a smooth curve.

Each pass is cut into windows of `WINDOW` samples, and a cubic is fitted to each. What is left of it has the variance
σ² tr(M R)/w, M the projection on what a cubic leaves, R the noise's correlation, here ρ^|i − j|: σ and ρ follow from
the sums of the squares and of the products of neighbours. Scatter between passes, hours and positions is none of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.estimation.bins import noise_of_mean

WINDOW, CUBIC = 12, 3
# A correlation within so many standard errors of zero is none.
CLEAR = 3.0
# Speeds have noise of their own where they differ by more than chance makes at this probability …
DIFFERENT_P = 1e-4
# … and each has at least so many degrees of freedom, which its noise is known with to a fifth.
LEAST_DOF = 12.0
LEAST_OF_LEVEL = 30.0
_CORRELATIONS = np.linspace(-0.5, 0.95, 291)


@dataclass(frozen=True)
class PassNoise:
    """The noise of single samples of one joint's passes."""

    sigma: Floats
    """(n,) N·m, of a single sample, for each of the n samples."""
    correlation: float
    """Of neighbouring samples, the next but one by its square and so on."""
    dof: float
    """Degrees of freedom behind it."""

    def of_mean(self, count: Integers) -> Floats:
        """Return by what the noise of single samples is multiplied in a mean over ``count`` neighbours (b,)."""
        return noise_of_mean(count, self.correlation)


def pass_noise(torque: Floats, reading: Integers, level: Integers, weight: Floats) -> PassNoise | None:
    """Return the noise of the samples of one joint; None where its passes are too short to show it.

    Parameters
    ----------
    torque : (n,) N·m, means of neighbouring samples. reading : (n,) the pass of each, in the order of time.
    level : (n,) the speed's number.
    weight : (n,) how many samples each is the mean of; ``sigma`` is that of these means.
    """
    scaled = torque * np.sqrt(weight)
    windows, levels = _windows(scaled, reading, level)
    if not len(windows) or len(windows) * (WINDOW - CUBIC - 1) < LEAST_DOF:
        return None
    left = windows @ _projection()
    squares = np.sum(left**2, axis=1)
    if float(squares.sum()) <= 1e-24 * float(np.sum(windows**2)):
        return None  # copies of one reading carry no information on the noise
    rho = _correlation(left)
    freedom = float(np.trace(_projection() @ _correlated(rho)))
    total = float(squares.sum()) / (freedom * len(windows))
    sigma = np.full(len(torque), np.sqrt(total))
    numbers = np.unique(levels)
    of_level = np.array([squares[levels == number].sum() for number in numbers])
    counts = np.array([np.count_nonzero(levels == number) for number in numbers]) * (WINDOW - CUBIC - 1.0)
    known = counts >= LEAST_OF_LEVEL
    if np.count_nonzero(known) > 1 and _differ(of_level[known], counts[known]):
        for number, square, count in zip(numbers[known], of_level[known], counts[known], strict=True):
            sigma[level == number] = np.sqrt(square / (freedom * count / (WINDOW - CUBIC - 1.0)))
    return PassNoise(sigma / np.sqrt(weight), rho, float(counts.sum()))


def _windows(scaled: Floats, reading: Integers, level: Integers) -> tuple[Floats, Integers]:
    """Return (w, WINDOW) stretches of passes, as many as fit into each, and (w,) their levels."""
    pieces: list[Floats] = []
    levels: list[Integers] = []
    for number in np.unique(reading):
        members = np.flatnonzero(reading == number)
        count = members.size // WINDOW
        if count:
            first = (members.size - count * WINDOW) // 2
            pieces.append(scaled[members[first : first + count * WINDOW]].reshape(count, WINDOW))
            levels.append(np.full(count, level[members[0]], dtype=np.int64))
    if not pieces:
        return np.zeros((0, WINDOW)), np.zeros(0, dtype=np.int64)
    return np.concatenate(pieces), np.concatenate(levels)


@cache
def _projection() -> Floats:
    """Return (WINDOW, WINDOW) what takes a cubic out."""
    basis = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, WINDOW), CUBIC + 1))[0]
    return np.asarray(np.eye(WINDOW) - basis @ basis.T)


def _correlated(rho: float) -> Floats:
    steps = np.abs(np.subtract.outer(np.arange(WINDOW), np.arange(WINDOW)))
    return np.asarray(rho**steps)


@cache
def _expected() -> tuple[Floats, float]:
    """Return (g,) neighbours' products over squares at each of `_CORRELATIONS`, and their spread from white noise."""
    project = _projection()
    neighbours = 0.5 * (np.eye(WINDOW, k=1) + np.eye(WINDOW, k=-1))
    inner = project @ neighbours @ project
    ratios = [np.trace(inner @ _correlated(rho)) / np.trace(project @ _correlated(rho)) for rho in _CORRELATIONS]
    white = float(np.trace(inner) / np.trace(project))
    deviation = inner - white * project
    return np.array(ratios), float(np.sqrt(2.0 * np.trace(deviation @ deviation)) / np.trace(project))


def _correlation(left: Floats) -> float:
    """Return the correlation of neighbouring samples from what a cubic leaves (w, WINDOW); 0 where it may be that."""
    ratios, spread = _expected()
    ratio = float(np.sum(left[:, 1:] * left[:, :-1]) / np.sum(left**2))
    white = float(np.interp(0.0, _CORRELATIONS, ratios))
    if abs(ratio - white) <= CLEAR * spread / np.sqrt(len(left)):
        return 0.0
    return float(np.interp(ratio, ratios, _CORRELATIONS))


def _differ(squares: Sequence[float] | Floats, dof: Floats) -> bool:
    """Return whether variances differ (Bartlett 1937)."""
    from scipy.special import chdtrc

    variance = np.maximum(np.asarray(squares) / dof, 1e-300)
    pooled = float(np.sum(squares) / dof.sum())
    statistic = float(dof.sum() * np.log(pooled) - np.sum(dof * np.log(variance)))
    correction = 1.0 + (float(np.sum(1.0 / dof)) - 1.0 / float(dof.sum())) / (3.0 * (len(dof) - 1.0))
    return bool(chdtrc(len(dof) - 1.0, statistic / correction) < DIFFERENT_P)

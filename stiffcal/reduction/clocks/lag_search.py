"""The lag at which one log follows another: a regression of one on the other at every lag, by Fourier transforms."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.quantities import unit, unit_names
from stiffcal.reduction.holds.finding import Holds, find_holds
from stiffcal.reduction.logs.blocks import noise_of
from stiffcal.wording import significant

LEAST_OVERLAP = 0.3  # of the shorter log
# Logs of one run begin and end within a part of it; a rate or unit that is wrong is so by more than this factor.
MOST_APART = 3.0
# Logs of one run that differ in length by more than this share do not hold the same loads.
AS_LONG = 0.1
MOST_GRID = 1 << 14  # points of the common grid on which every lag is tried
# A log moves where the slow part of it, so many means, scatters by more than white noise leaves of them: 200 means of
# that scatter by 1 ± 0.05, and half as much again leaves room for noise that is not quite white. A few readings move
# where they differ at all.
FEW_READINGS, MEANS, MOVING = 16, 200, 1.5
# A log follows another where a regression explains so many squares of noise for each of its numbers, and so many more:
# χ² of n numbers is below n + 2 √(n t) + 2 t but for e⁻ᵗ (Laurent and Massart 2000), for one of 16 000 lags in ten
# thousand runs t is 19, and noise of logs is not white. And this share of all squares, as a drift of both explains
# some.
FOLLOWS_PER_NUMBER, FOLLOWS, LEAST_SHARE = 4.0, 60.0, 0.02
# A second lag counts where it explains as much but for this factor; what is explained whole has no second one.
AGAIN, WHOLLY = 1.02, 0.999
# Of a log's range, for the noise of one that shows none (coarse digits, a simulation): less than any sensor's.
LEAST_NOISE, LEAST_NOISE_OF_LOAD = 1e-6, 1e-9
ROUNDING = 1e-6  # of a step of the grid: a reading that is on a grid point but for rounding is on it
OF_STILL_COMPONENT = 1e-6  # of a regression's mean square: components of a load that do not move have no gain
LEAST_LEFT = 1e-9  # of the squares: what is explained whole has a finite likelihood


@dataclass(frozen=True)
class SharedSignal:
    """What a device measured that another may have measured too, on its own clock."""

    source: str
    """The source's name."""
    time: Floats
    """(m,) s."""
    values: Floats
    """(m, c) wrench, position, joint angles, lengths: anything that follows the load linearly, nearly."""
    leads: bool
    """True for the load itself (wrench): the others are regressed on it."""

    @cached_property
    def holds(self) -> Holds:
        """Where its values stand still: every other log that is aligned to this one asks for them."""
        return find_holds(self.time, self.values)


def moves(values: Floats) -> bool:
    """Return whether a log shows more than noise: its slow part against what white noise would leave of it.

    Examples
    --------
    >>> import numpy as np
    >>> moves(np.random.default_rng(0).normal(size=(1000, 6)))
    False
    """
    if len(values) < FEW_READINGS:
        return bool(np.ptp(values, axis=0).max(initial=0.0) > 0.0) if len(values) > 1 else False
    noise = noise_of(values)
    size = max(len(values) // MEANS, 1)
    n_used = (len(values) // size) * size
    means = values[:n_used].reshape(-1, size, values.shape[1]).mean(axis=1)
    quiet = noise == 0.0
    if quiet.any() and bool((np.ptp(values[:, quiet], axis=0) > 0.0).any()):
        return True
    spread = means.std(axis=0) / np.maximum(noise / np.sqrt(size), np.finfo(float).tiny)
    return bool((spread[~quiet] > MOVING).any())


class CoarseLag(NamedTuple):
    """The lag at which a regression of one log on another leaves least."""

    value: float
    """s, to a step of the common grid."""
    gain: float
    """What the regression explains there, in log-likelihood over a constant, of times at which both have readings."""


def coarse_lag(first: SharedSignal, second: SharedSignal) -> CoarseLag | str:
    """Return the lag at which a regression of ``second`` on ``first`` leaves least, or why there is none."""
    span = max(np.ptp(first.time), np.ptp(second.time))
    step = max(interval_of(first.time), interval_of(second.time), span / MOST_GRID)
    (u, in_u), (y, in_y) = _on_grid(first, step), _on_grid(second, step)
    u /= np.maximum(np.sqrt(np.sum(u**2, axis=0) / in_u.sum()), 1e-12 * max(np.abs(u).max(), 1e-300))
    y /= np.maximum(noise_of(second.values), LEAST_NOISE * np.maximum(np.ptp(second.values, axis=0), 1e-300))
    lags, gain, share = _gain_of_lags(u, y, in_u, in_y)
    if lags.size == 0:
        return f"{first.source} and {second.source} overlap too little{_of_another_length(first, second)}"
    best = int(np.argmax(gain))
    n_free = u.shape[1] * y.shape[1]
    explained = share[best] * min(in_u.sum(), in_y.sum())
    if explained < FOLLOWS_PER_NUMBER * n_free + FOLLOWS or share[best] < LEAST_SHARE:
        return f"{second.source} does not follow {first.source}{_of_another_length(first, second)}"
    # the next best lag outside the peak: loads that repeat exactly do not distinguish one cycle from the next
    falls = np.flatnonzero(gain < 0.5 * gain[best])
    left = falls[falls < best].max(initial=-1)
    right = falls[falls > best].min(initial=gain.size)
    elsewhere = np.concatenate([gain[: left + 1], gain[right:]])
    if elsewhere.size and share[best] < WHOLLY and gain[best] < AGAIN * elsewhere.max():
        found = f"the loads repeat: {second.source} matches {first.source} at more than one time offset"
        lasts, other = float(np.ptp(second.time)), float(np.ptp(first.time))
        if min(lasts, other) > (1.0 - AS_LONG) * max(lasts, other):
            return found
        return (
            f"{found}, and lasts {significant(lasts, 4)} s where that lasts {significant(other, 4)} "
            f"s: did the log of one end early?"
        )
    return CoarseLag(float(lags[best] * step + second.time[0] - first.time[0]), float(gain[best]))


def _of_another_length(first: SharedSignal, second: SharedSignal) -> str:
    """Return in words that the two logs last so differently that a rate or a unit of time is wrong, or "".

    Which unit it is, the logs decide: with times in it one follows the other.
    """
    lasts, other = float(np.ptp(second.time)), float(np.ptp(first.time))
    if _as_long(lasts, other):
        return ""
    sentence = f"; {second.source} lasts {significant(lasts, 4)} s, {first.source} {significant(other, 4)} s: "
    for name in unit_names("time"):
        factor = unit(name, "time").factor
        for scale, numbers, taken in ((factor, name, "s"), (1.0 / factor, "s", name)):
            if not _as_long(scale * lasts, other):
                continue
            scaled = SharedSignal(second.source, scale * second.time, second.values, second.leads)
            if not isinstance(coarse_lag(first, scaled), str):
                return (
                    f"{sentence}they agree where the times of {second.source} are in {numbers} and were taken for "
                    f"{taken}, or those of {first.source} the other way round"
                )
    return f"{sentence}check rate_hz or the unit of time of both"


def _as_long(lasts: float, other: float) -> bool:
    return other <= MOST_APART * lasts and lasts <= MOST_APART * other


def interval_of(time: Floats) -> float:
    """Return the usual time from one reading to the next, s."""
    return float(np.median(np.diff(time)))


def _on_grid(signal: SharedSignal, step: float) -> tuple[Floats, Floats]:
    """Return the values averaged in steps from the log's start (n, c), about their mean, and where there are any (n,).

    Where there are none the value is 0: nothing is known of a gap, and it enters no regression.
    """
    index = np.floor((signal.time - signal.time[0]) / step + ROUNDING).astype(np.int64)
    n = int(index[-1]) + 1
    count = np.bincount(index, minlength=n)
    sums = np.stack([np.bincount(index, weights=column, minlength=n) for column in signal.values.T], axis=1)
    have = count > 0
    means = sums[have] / count[have, None]
    values = np.zeros(sums.shape)
    values[have] = means - means.mean(axis=0)
    return values, have.astype(np.float64)


def _gain_of_lags(u: Floats, y: Floats, in_u: Floats, in_y: Floats) -> tuple[Floats, Floats, Floats]:
    """Regress y (N, c) on u (M, p) at every lag, y[i] against u[i - lag], where both have readings.

    Parameters
    ----------
    u, y : 0 where there are no readings. in_u, in_y : (M,), (N,) 1 where there are, else 0.

    Returns
    -------
    Lags, the gain in log-likelihood over a constant, and the share of y's square sum that is explained.
    """
    n_u, n_y = len(u), len(y)
    size = 1 << int(np.ceil(np.log2(n_u + n_y)))

    def spectrum(values: Floats) -> NDArray[np.complex128]:
        return np.asarray(np.fft.rfft(values, size, axis=0))

    lags = np.arange(-(n_u - 1), n_y, dtype=np.int64)
    design = np.concatenate([in_u[:, None], u], axis=1)
    n_columns = design.shape[1]
    spectrum_u, spectrum_y, spectrum_in_y = np.conj(spectrum(design)), spectrum(y), spectrum(in_y)
    pairs = np.rint(np.fft.irfft(spectrum_u[:, 0] * spectrum_in_y, size)[lags % size])
    keep = pairs >= max(LEAST_OVERLAP * min(in_u.sum(), in_y.sum()), 2 * n_columns)
    lags, pairs = lags[keep], pairs[keep]
    if lags.size == 0:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    gram = np.empty((lags.size, n_columns, n_columns))
    for column in range(n_columns):
        products = np.conj(spectrum(design[:, : column + 1] * design[:, column : column + 1]))
        sums = np.fft.irfft(products * spectrum_in_y[:, None], size, axis=0)[lags % size]
        gram[:, column, : column + 1] = gram[:, : column + 1, column] = sums
    cross = np.empty((lags.size, n_columns, y.shape[1]))
    for column in range(y.shape[1]):
        cross[:, :, column] = np.fft.irfft(spectrum_u * spectrum_y[:, column : column + 1], size, axis=0)[lags % size]
    ridge = OF_STILL_COMPONENT * np.trace(gram, axis1=1, axis2=2)[:, None, None] / n_columns * np.eye(n_columns)
    explained = np.einsum("lpc,lpc->l", cross, np.linalg.solve(gram + ridge, cross))
    total = np.fft.irfft(spectrum_u[:, 0] * spectrum(np.sum(y**2, axis=1)), size)[lags % size]
    constant = np.sum(cross[:, 0, :] ** 2, axis=1) / pairs
    about = np.maximum(total - constant, 1e-300)
    residual = np.clip(total - explained, LEAST_LEFT * about, about)
    return lags.astype(np.float64), pairs * np.log(about / residual), 1.0 - residual / about

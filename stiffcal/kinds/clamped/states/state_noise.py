"""The noise of a clamped run's readings, with its correlation in time.

The noise of a signal is taken as a stationary autoregressive series. Its autocovariance r₀, r₁, … gives the variance of
every weighted sum of readings, wᵀ R w with R_ij = r_|i − j|, and what a parabola is expected to leave of a stretch: the
products of what it leaves at lag k have the expectation Σ_m C_km r_m, C from the projection P that takes it out. The
series is the one of lowest order whose expected products are those observed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stiffcal.arrays import Floats

# Readings up to this distance show the correlation of the noise …
MOST_LAGS = 16
# … but no more than this share of a stretch: a parabola hides what is slower.
LAGS_PER_READING = 0.4
# Order of the series at most: 2 is a low-pass filter of second order.
MOST_ORDER = 3
# Of fewer products nothing is known of the correlation.
LEAST_PRODUCTS = 100
# An order is added where it improves the products by the square of so many standard errors.
CLEAR = 3.0
# Reflection coefficients stay below this: the series stays stationary.
MOST_REFLECTION = 0.98
# An autocovariance ends where it stays below this share of the variance, and at so many readings.
NEGLIGIBLE, LONGEST = 1e-3, 256


@dataclass(frozen=True)
class SeriesNoise:
    """Stationary noise of one signal."""

    covariance: Floats
    """(L + 1,) autocovariance at distances of 0 … L readings, in the signal's unit squared; zero beyond."""
    _residual: dict[int, tuple[float, float]] = field(default_factory=dict, compare=False, repr=False)
    """Answers of `expected_residual` by the number of readings, per unit variance."""

    @property
    def sigma(self) -> float:
        """Standard deviation of a single reading, in the signal's unit."""
        return float(np.sqrt(self.covariance[0]))

    @property
    def is_white(self) -> bool:
        """True where no reading is correlated with another."""
        return self.covariance.size == 1

    @property
    def inflation(self) -> float:
        """By what factor the correlation raises the variance of a mean over many readings."""
        if self.covariance[0] <= 0.0:
            return 1.0
        return float(2.0 * self.covariance.sum() / self.covariance[0] - 1.0)

    def at_least(self, sigma: float) -> SeriesNoise:
        """Return noise of the same correlation whose standard deviation is ``sigma`` or more."""
        if self.sigma >= sigma:
            return self
        if self.covariance[0] <= 0.0:
            return white(sigma)
        return SeriesNoise(self.covariance * (sigma**2 / self.covariance[0]))

    def times(self, columns: Floats) -> Floats:
        """Return R Q for columns Q (n, c) over n successive readings."""
        product = float(self.covariance[0]) * columns
        for lag in range(1, min(self.covariance.size, len(columns))):
            product[lag:] += self.covariance[lag] * columns[:-lag]
            product[:-lag] += self.covariance[lag] * columns[lag:]
        return product

    def of_weighted(self, weight: Floats) -> float:
        """Return the standard deviation of a weighted sum of successive readings, weights (n,): √(wᵀ R w)."""
        return float(np.sqrt(max(float(weight @ self.times(weight[:, None])[:, 0]), 0.0)))

    def expected_residual(self, basis: Floats) -> tuple[float, float]:
        """Return mean and standard deviation of the sum of squares that an orthonormal basis (n, c) leaves of it.

        E = tr(P R), variance 2 tr(P R P R); of readings at equal distances, so that it is made once for each n.
        """
        count = len(basis)
        if count not in self._residual:
            r = self.covariance[:count]
            correlated = self.times(basis)
            inner = basis.T @ correlated
            pairs = count - np.arange(r.size)
            of_square = 2.0 * float(pairs @ r**2) - count * r[0] ** 2
            of_square += float(np.sum(inner**2)) - 2.0 * float(np.sum(correlated**2))
            mean = float(count * r[0] - np.trace(inner))
            self._residual[count] = mean, float(np.sqrt(2.0 * max(of_square, 0.0)))
        return self._residual[count]


def white(sigma: float) -> SeriesNoise:
    """Return noise without correlation of standard deviation ``sigma``."""
    return SeriesNoise(np.array([sigma**2]))


def residual_noise(remaining: Sequence[Floats], bases: Sequence[Floats]) -> SeriesNoise | None:
    """Return the noise from what parabolas leave of stretches; None where these are too short to show it.

    Parameters
    ----------
    remaining : of each stretch (n,) what its parabola leaves. bases : of each (n, 3) orthonormal columns of parabolas.
    """
    lags = _lags(np.array([rest.size for rest in remaining], dtype=np.int64))
    long_enough = [k for k, rest in enumerate(remaining) if lags and rest.size * LAGS_PER_READING >= lags]
    if not long_enough:
        return None
    products, pairs = np.zeros(lags + 1), np.zeros(lags + 1)
    of_length: dict[int, tuple[int, Floats]] = {}
    for k in long_enough:
        rest = remaining[k]
        products += [float(rest[lag:] @ rest[: rest.size - lag]) for lag in range(lags + 1)]
        pairs += rest.size - np.arange(lags + 1)
        number, basis = of_length.get(rest.size, (0, bases[k]))
        of_length[rest.size] = number + 1, basis
    if pairs[-1] < LEAST_PRODUCTS or products[0] <= 0.0:
        return None
    expected = np.zeros((lags + 1, min(max(of_length), LONGEST)))
    for number, basis in of_length.values():
        columns = _expected_products(basis, lags)
        expected[:, : columns.shape[1]] += number * columns
    return _lowest_order(products, pairs, expected)


def _lags(lengths: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> int:
    """Return up to which distance most stretches of these lengths show a correlation; 0 where they show none."""
    if not lengths.size:
        return 0
    # half of the readings lie in stretches at least this long
    order = np.sort(lengths)[::-1]
    typical = order[np.searchsorted(np.cumsum(order), 0.5 * order.sum())]
    return min(int(LAGS_PER_READING * float(typical)), MOST_LAGS)


def _expected_products(basis: Floats, lags: int) -> Floats:
    """Return (L + 1, m) C_km: what unit autocovariance at lag m adds to the products at lag k of a stretch.

    C_km is the sum over i of (P E_m P)_{i, i+k}, P = 1 − Q Qᵀ, E_m one on the m-th side diagonals.
    """
    count = len(basis)
    columns = np.zeros((lags + 1, min(count, LONGEST)))
    for m in range(columns.shape[1]):
        moved = np.zeros_like(basis)
        moved[m:] += basis[: count - m]
        if m:
            moved[: count - m] += basis[m:]
        twice = basis @ (basis.T @ moved)
        for k in range(lags + 1):
            head, tail = slice(0, count - k), slice(k, count)
            columns[k, m] = (
                (count - k) * (k == m)
                - np.sum(basis[head] * moved[tail])
                - np.sum(moved[head] * basis[tail])
                + np.sum(twice[head] * basis[tail])
            )
    return columns


def _lowest_order(products: Floats, pairs: Floats, expected: Floats) -> SeriesNoise:
    """Return the series of lowest order whose expected products (L + 1,) are the observed ones to within chance."""
    from scipy.optimize import least_squares

    scale = products[0] / np.sqrt(pairs)

    def missed(reflection: Floats) -> Floats:
        shape = _autocovariance(reflection)[: expected.shape[1]]
        predicted = expected[:, : shape.size] @ shape
        # the variance is the one that meets the sum of squares
        return np.asarray((products - products[0] / predicted[0] * predicted)[1:] / scale[1:])

    best = np.zeros(0)
    left = missed(best)
    for _ in range(1, min(MOST_ORDER, len(products) - 1) + 1):
        # a start on each side: for order 2 the sum of squares has two minima
        starts = [np.append(best, last) for last in (-0.3, 0.3)]
        fits = [least_squares(missed, start, bounds=(-MOST_REFLECTION, MOST_REFLECTION)) for start in starts]
        fit = min(fits, key=lambda result: float(result.cost))
        if not fit.success or left @ left - fit.fun @ fit.fun <= CLEAR**2:
            break
        best, left = np.asarray(fit.x), np.asarray(fit.fun)
    shape = _autocovariance(best)
    known = shape[: expected.shape[1]]
    return SeriesNoise(shape * float(products[0] / (expected[0, : known.size] @ known)))


def _autocovariance(reflection: Floats) -> Floats:
    """Return (L + 1,) the autocorrelation of an autoregressive series from its reflection coefficients (p,).

    The coefficients follow by Levinson's recursion (Levinson 1946), the correlation from its response to an impulse.
    """
    from scipy.linalg.lapack import dtbtrs  # scipy.signal takes longer to load than a run takes to be read

    coefficients = np.zeros(0)
    for value in reflection:
        coefficients = np.append(coefficients - value * coefficients[::-1], value)
    if not coefficients.size:
        return np.ones(1)
    impulse = np.zeros(LONGEST)
    impulse[0] = 1.0
    # the response y solves y_i − Σ_k c_k y_(i−k) = impulse_i: a lower triangular matrix with so many bands
    bands = np.repeat(np.append(1.0, -coefficients)[:, np.newaxis], LONGEST, axis=1)
    response = dtbtrs(bands, impulse[:, np.newaxis], uplo="L")[0][:, 0]
    spectrum = np.abs(np.fft.rfft(response, 2 * LONGEST)) ** 2
    shape = np.fft.irfft(spectrum)[:LONGEST]
    shape = shape / shape[0]
    above = np.flatnonzero(np.abs(shape) > NEGLIGIBLE)
    return np.asarray(shape[: above[-1] + 1])

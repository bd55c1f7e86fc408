"""Tails and scales of the noise: single readings may be off in every hypothesis, more of them the heavier the tails.

Readings scatter normally or by Student's t, with degrees of freedom that nobody knows, and each kind of reading with a
scale of its own: stated noise may be right for translations and wrong for rotations. Of what a set of members leaves,
ε̂ = P y with P = V⁻¹ − V⁻¹X (XᵀV⁻¹X + Λ)⁻¹XᵀV⁻¹, a reading has the variance f = diag P, its share that is free; it
counts by so much:

    log p = log p of normal noise of one scale + log Σ_ν p(ν) exp Σ f (log t_ν(ε̂ / √f) − log N(ε̂ / √f))

each at its own best scales. Every set has the tails of what it leaves itself: no set gains by what its rival leaves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.judgement.inner_products import InnerProducts
from stiffcal.judgement.numbers import (
    BIN_RANGE,
    BINS,
    LEAST_FREE,
    LEAST_WORTH,
    NORMAL,
    ROUNDING,
    SCALE_PASSES,
    TAILS,
    TAILS_WITHIN,
)
from stiffcal.judgement.shared import Shared


@dataclass(frozen=True)
class Readings:
    """Readings as they are left by sets of members."""

    shared: Shared
    """What every set has."""
    residual: Floats
    """(r,) whitened, what members have in it as well."""
    free: Floats
    """(r,) share of each that runs' constants leave free, 0 where nothing was read."""
    kind: Integers
    """(r,) of each (`stiffcal.identification.readings.row_layout`)."""
    without_members: dict[int, tuple[Floats, Floats]] = field(default_factory=dict)
    """By discrepancy of the grid what is left (r,) without members, and its share (r,)."""

    def gains(
        self, inner: InnerProducts, chosen: Sequence[int], scale: Floats, by_discrepancy: Floats, known: float
    ) -> Floats:
        """Return (t,) what the tails of the noise add to the log evidence of a set.

        Of each kind of covariance they are those of its most probable size, where that is near the best of all.

        Parameters
        ----------
        inner : of members' columns. chosen : the set. scale : (t, q) the best sizes of its columns.
        by_discrepancy : (t,) log evidence of the set for normal noise.
        known : as of `stiffcal.judgement.noise_scale.NoiseScale`.
        """
        best = float(by_discrepancy.max())
        stretches = [slice(0, 1), *self.shared.at]
        tops = [at.start + int(np.argmax(by_discrepancy[at])) for at in stretches]
        near = [k for k, top in enumerate(tops) if by_discrepancy[top] > best - TAILS_WITHIN]
        left, free = np.empty((2, len(near), len(self.residual)))
        for place, k in enumerate(near):
            left[place], free[place] = self.left(inner, chosen, scale[tops[k]], tops[k])
        gains = log_gains(left, free, self.kind, known)
        found = np.full(len(by_discrepancy), gains[[by_discrepancy[tops[k]] for k in near].index(best)])
        for k, gain in zip(near, gains.tolist(), strict=True):
            found[stretches[k]] = gain
        return found

    def left(self, inner: InnerProducts, chosen: Sequence[int], scale: Floats, number: int) -> tuple[Floats, Floats]:
        """Return what a set leaves of the readings, (r,), and which share of each is free, in its noise there.

        Parameters
        ----------
        inner : of members' columns. chosen : the set. scale : (q,) of its columns.
        number : of the discrepancy.
        """
        left, free = self._without_members(number)
        variance = self.shared.variance_of_noise(number)
        if not len(chosen):
            return left * np.sqrt(variance), free * variance
        own = inner.of_set(chosen)
        gram = own.gram[number] * np.outer(scale, scale) + np.eye(len(scale))
        size = np.sqrt(np.diag(gram))
        unit = gram / np.outer(size, size)
        unit[np.diag_indices(len(unit))] += ROUNDING
        inverse = np.linalg.inv(np.linalg.cholesky(unit)) * (scale / size)
        half = inverse @ np.concatenate([inner.reduced(i, number) for i in chosen])
        left, free = left - (inverse @ own.target[number]) @ half, free - np.einsum("qr,qr->r", half, half)
        return left * np.sqrt(variance), free * variance

    def _without_members(self, number: int) -> tuple[Floats, Floats]:
        if number not in self.without_members:
            shared = self.shared
            factor, _ = shared.own[number]
            basis = shared.basis(number)
            moved = shared.inverse(self.residual[None], number)[0]
            wanted = shared.prior[:, :-1].T @ shared.prior[:, -1]
            left = moved - (factor @ (shared.columns @ moved + wanted)) @ basis
            free = self.free - shared.leverage(number) - np.sum(basis**2, axis=0)
            self.without_members[number] = left, free
        return self.without_members[number]


@dataclass(frozen=True, eq=False)
class Tail:
    """How single readings scatter."""

    dof: float
    """Degrees of freedom of the t distribution; infinite: normally."""
    variance: Mapping[int, float]
    """Of the readings of each kind, in that of the rows."""
    log_density: float
    """Of the readings, their shares that are not free left out."""

    def weights(self, square: Floats, kind: Integers) -> Floats:
        """Return how much readings (r,) count, by their squares over their variance; 1 each for normal noise.

        Weighted squares are as large as the variance in the mean, as those of normal noise are.
        """
        if np.isinf(self.dof):
            return np.ones_like(square)
        variance = np.array([self.variance.get(k, 1.0) for k in range(int(kind.max(initial=0)) + 1)])
        return _weights(square / variance[kind], self.dof)

    @property
    def worth(self) -> float:
        """How many of normal noise a weighted square is worth: these vary by 2, it by 2 ν / (ν + 3)."""
        return 1.0 if np.isinf(self.dof) else (self.dof + 3.0) / self.dof

    @property
    def worth_plain(self) -> float:
        """How many of normal noise a plain square is worth, by its variance; up to four degrees of freedom hardly any.

        Of repeats, whose scatter is found from plain squares.
        """
        return 1.0 if np.isinf(self.dof) else max((self.dof - 4.0) / (self.dof - 1.0), LEAST_WORTH)


def tails_of(left: Floats, free: Floats, kind: Integers, known: float) -> dict[Tail, float]:
    """Return how readings may scatter, each with the logarithm of its probability times density; normally first.

    Parameters
    ----------
    left, free : (r,) as of `Readings.left`. kind : (r,) of the readings.
    known : as of `stiffcal.judgement.noise_scale.NoiseScale`.
    """
    kinds, shares = np.unique(kind).tolist(), _log_shares()
    parts = {k: _scales(*_binned(left[None, kind == k], free[None, kind == k]), known) for k in kinds}
    found = {}
    for number, dof in enumerate((np.inf, *TAILS.tolist())):
        density = float(sum(log_density[number, 0] for _, log_density in parts.values()))
        tail = Tail(dof, {k: float(variance[number, 0]) for k, (variance, _) in parts.items()}, density)
        found[tail] = float(shares[number]) + density
    return found


def log_gains(left: Floats, free: Floats, kind: Integers, known: float) -> Floats:
    """Return (t,) what unknown tails and scales of the noise add to the log density of readings.

    Parameters
    ----------
    left, free : (t, r) as of `Readings.left` at some discrepancies. kind, known : as of `tails_of`.
    """
    _, (one_scale, *_) = _scales(*_binned(left, free), known)
    density = sum(_scales(*_binned(left[:, kind == k], free[:, kind == k]), known)[1] for k in np.unique(kind).tolist())
    return np.asarray(np.logaddexp.reduce(_log_shares()[:, None] + density, axis=0) - one_scale)


def _log_shares() -> Floats:
    """Return (d,) logarithms of the probabilities that readings scatter normally, and by each of `TAILS`."""
    return np.log([NORMAL, *np.full(len(TAILS), (1.0 - NORMAL) / len(TAILS))])


def _weights(over: Floats, dof: Floats | float) -> Floats:
    return np.asarray((dof + 1.0) / (dof - 2.0 + over))


def _binned(left: Floats, free: Floats) -> tuple[Floats, Floats]:
    """Return (t, b) means of squares of like size over their variance, and how many readings they are worth."""
    taken = free > LEAST_FREE
    square, share = left**2 / np.where(taken, free, 1.0), np.where(taken, free, 0.0)
    low, high = BIN_RANGE
    number = np.clip((np.log(np.maximum(square, 1e-300)) - low) * (BINS / (high - low)), 0, BINS - 1).astype(np.int64)
    number += BINS * np.arange(len(left))[:, None]
    worth, whole = (
        np.bincount(number.ravel(), weight.ravel(), BINS * len(left)).reshape(-1, BINS)
        for weight in (share, share * square)
    )
    return np.asarray(whole / np.maximum(worth, 1e-300)), worth.astype(np.float64)


def _scales(square: Floats, share: Floats, known: float) -> tuple[Floats, Floats]:
    """Return the best variances (d, t) of noise, normal and of `TAILS`, and the log densities of readings with these.

    Parameters
    ----------
    square, share : (t, b) as of `_binned`.
    """
    from scipy.special import gammaln

    count, whole = share.sum(axis=-1), np.sum(share * square, axis=-1)

    def variance_of(squares: Floats) -> Floats:
        if np.isinf(known):
            return np.ones_like(squares)
        return np.asarray(np.maximum((squares + known) / np.maximum(count + known, 1e-300), 1e-300))

    normal = variance_of(whole)
    dof = TAILS[:, None, None]
    variance = np.broadcast_to(normal, (len(TAILS), len(normal)))
    for _ in range(SCALE_PASSES):
        weights = _weights(square / variance[..., None], dof)
        variance = variance_of(np.sum(share * weights * square, axis=-1))
    each = -0.5 * (dof + 1.0) * np.log1p(square / variance[..., None] / (dof - 2.0))
    constant = gammaln(0.5 * (TAILS + 1.0)) - gammaln(0.5 * TAILS) - 0.5 * np.log(0.5 * (TAILS - 2.0))
    with_tails = np.sum(share * each, axis=-1) + constant[:, None] * count - 0.5 * count * np.log(variance)
    plain = -0.5 * whole / normal - 0.5 * count * np.log(normal)
    return np.concatenate([normal[None], variance]), np.concatenate([plain[None], with_tails])

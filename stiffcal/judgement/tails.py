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
from stiffcal.judgement.priors import NORMAL, TAILS
from stiffcal.judgement.shared import ROUNDING, Shared

NEAR = 4.0
"""Nats behind a set's best discrepancy up to which the tails of what it leaves are found."""
LEAST_FREE = 1e-3
"""Share of a reading that is left free, below which it shows nothing."""
LEAST_WORTH = 0.01
"""Of a plain square, where its variance is infinite."""
BINS, RANGE = 320, (-12.0, 20.0)
"""Bins of log ε̂²/f, and where they begin and end."""
PASSES = 12
"""Steps in which a scale is found."""


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
    """(r,) of each (`stiffcal.identification.row_layout`)."""
    without_members: dict[int, tuple[Floats, Floats]] = field(default_factory=dict)
    """By discrepancy of the grid what is left (r,) without members, and its share (r,)."""

    def gains(
        self, inner: InnerProducts, chosen: Sequence[int], scale: Floats, by_discrepancy: Floats, known: float
    ) -> Floats:
        """Return (t,) what the tails of the noise add to the log evidence of a set.

        Parameters
        ----------
        inner : of members' columns. chosen : the set. scale : (t, q) the best sizes of its columns.
        by_discrepancy : (t,) log evidence of the set for normal noise.
        known : as of `stiffcal.judgement.evidence.NoiseScale`.
        """
        best = int(np.argmax(by_discrepancy))
        near = np.flatnonzero(by_discrepancy > by_discrepancy[best] - NEAR)
        found = {}
        for t in near.tolist():
            left, free = self.left(inner, chosen, scale[t], t)
            variance = self.shared.variance_of_noise(t)
            found[t] = log_gain(left * np.sqrt(variance), free * variance, self.kind, known)
        return np.array([found.get(t, found[best]) for t in range(len(by_discrepancy))])

    def left(self, inner: InnerProducts, chosen: Sequence[int], scale: Floats, number: int) -> tuple[Floats, Floats]:
        """Return what a set leaves of the readings, (r,), and which share of each is free.

        Parameters
        ----------
        inner : of members' columns. chosen : the set. scale : (q,) of its columns.
        number : of the discrepancy.
        """
        left, free = self._without_members(number)
        if not len(chosen):
            return left, free
        own = inner.of_set(chosen)
        gram = own.gram[number] * np.outer(scale, scale) + np.eye(len(scale))
        size = np.sqrt(np.diag(gram))
        unit = gram / np.outer(size, size)
        unit[np.diag_indices(len(unit))] += ROUNDING
        inverse = np.linalg.inv(np.linalg.cholesky(unit)) * (scale / size)
        half = inverse @ np.concatenate([inner.reduced(i, number) for i in chosen])
        return left - (inverse @ own.target[number]) @ half, free - np.einsum("qr,qr->r", half, half)

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
    known : as of `stiffcal.judgement.evidence.NoiseScale`.
    """
    parts = {k: _binned(left[kind == k], free[kind == k]) for k in np.unique(kind).tolist()}
    found = {}
    for dof in (np.inf, *TAILS.tolist()):
        own = {k: _with_scale(*part, dof, known) for k, part in parts.items()}
        density = float(sum(log_density for _, log_density in own.values()))
        share = NORMAL if np.isinf(dof) else (1.0 - NORMAL) / len(TAILS)
        tail = Tail(dof, {k: variance for k, (variance, _) in own.items()}, density)
        found[tail] = float(np.log(share)) + density
    return found


def log_gain(left: Floats, free: Floats, kind: Integers, known: float) -> float:
    """Return what unknown tails and scales of the noise add to the log density of readings; as of `tails_of`."""
    _, one_scale = _with_scale(*_binned(left, free), np.inf, known)
    return float(np.logaddexp.reduce(list(tails_of(left, free, kind, known).values()))) - one_scale


def _weights(over: Floats, dof: float) -> Floats:
    return np.asarray((dof + 1.0) / (dof - 2.0 + over))


def _binned(left: Floats, free: Floats) -> tuple[Floats, Floats]:
    """Return means of squares of like size over their variance, and how many readings they are worth."""
    taken = free > LEAST_FREE
    square, share = left[taken] ** 2 / free[taken], free[taken]
    low, high = RANGE
    number = np.clip((np.log(np.maximum(square, 1e-300)) - low) * (BINS / (high - low)), 0, BINS - 1).astype(np.int64)
    worth = np.bincount(number, share, BINS).astype(np.float64)
    mean = np.bincount(number, share * square, BINS) / np.maximum(worth, 1e-300)
    return mean[worth > 0.0], worth[worth > 0.0]


def _with_scale(square: Floats, share: Floats, dof: float, known: float) -> tuple[float, float]:
    """Return the best variance of noise of some degrees of freedom, and the log density of readings with that."""
    from scipy.special import gammaln

    count, variance = float(np.sum(share)), 1.0
    if not np.isinf(known):
        variance = max((float(share @ square) + known) / max(count + known, 1e-300), 1e-300)
        for _ in range(0 if np.isinf(dof) else PASSES):
            weighted = float(share @ (_weights(square / variance, dof) * square))
            variance = max((weighted + known) / max(count + known, 1e-300), 1e-300)
    over = square / variance
    if np.isinf(dof):
        each = -0.5 * over
    else:
        each = gammaln(0.5 * (dof + 1.0)) - gammaln(0.5 * dof) - 0.5 * np.log(0.5 * (dof - 2.0))
        each = each - 0.5 * (dof + 1.0) * np.log1p(over / (dof - 2.0))
    return variance, float(share @ each) - 0.5 * count * float(np.log(variance))

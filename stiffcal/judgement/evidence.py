"""The evidence of sets of members: how probable the readings are, all sizes and the noise integrated.

Rows of unit variance, with the columns X of what every hypothesis has (joint springs and what else the user asked for),
and the columns Z of a set's members. For a discrepancy τ and sizes u of its members, coefficients are normal about 0
with variances u², and the noise's scale is integrated with ν degrees of freedom about the one that the rows have:

    log p = −½ log|V| − ½ log|XᵀV⁻¹X + Λ| − ½ log|I + u G u| − ½ (N + ν) log(ν + Q)

G and Q are inner products under V⁻¹ with X taken out. Coefficients with a bound count by the probability that they lie
within it, after over before. Sizes, kind and size of the discrepancy are summed over their grids: singles over all of
them, larger sets about the best, one member after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.judgement.discrepancy import Discrepancy
from stiffcal.judgement.priors import DISCREPANCIES, NO_DISCREPANCY

SWEEPS = 3
"""Times that each member's size is sought again while the others stay."""
ROUNDING = 1e-10


@dataclass(frozen=True)
class MemberColumns:
    """Whitened columns of one member, in units of their typical size."""

    rows: Floats
    """(q, r)."""
    bounded: Booleans
    """(q,) True where the coefficient cannot be negative."""
    sizes: Floats
    """(s,) grid of the common size of its coefficients."""
    weights: Floats
    """(s,) prior probability of each."""
    present: Floats = field(default_factory=lambda: np.zeros(0))
    """(q,) coefficients that the model about which this is has already; empty: none."""


@dataclass(frozen=True)
class NoiseScale:
    """How well the rows' scale is known."""

    dof: float
    """Of the readings, what every hypothesis has taken out."""
    known: float
    """Degrees of freedom about the stated scale; 0: it is not known, infinite: exactly."""

    def log_density(self, square: Floats) -> Floats:
        """Return the log density of residuals of these sums of squares, constants left out."""
        square = np.maximum(square, 1e-300)
        if self.known == 0.0:
            return np.asarray(-0.5 * self.dof * np.log(square))
        if np.isinf(self.known):
            return np.asarray(-0.5 * square)
        return np.asarray(-0.5 * (self.dof + self.known) * np.log1p(square / self.known))

    def scale(self, square: Floats) -> Floats:
        """Return the noise's scale that residuals of these sums of squares show, in units of the rows."""
        if np.isinf(self.known):
            return np.ones_like(square)
        return np.asarray(np.sqrt((square + self.known) / (self.dof + self.known)))


@dataclass(frozen=True)
class Inner:
    """Inner products of columns and residual at t discrepancies, the common columns taken out."""

    constant: Floats
    """(t,) what no set changes."""
    gram: Floats
    """(t, k, k) of all members' columns."""
    target: Floats
    """(t, k) of them with the residual."""
    square: Floats
    """(t,) of the residual."""

    def at(self, number: int) -> Inner:
        """Return one of the discrepancies alone."""
        one = slice(number, number + 1)
        return Inner(self.constant[one], self.gram[one], self.target[one], self.square[one])

    def given(self, where: Integers, scale: Floats) -> Inner:
        """Return them with the columns at ``where`` taken out, as far as priors of these scales (k,) allow."""
        own = self.gram[:, where[:, None], where] + np.diag(1.0 / scale**2)
        across = self.gram[:, where]
        part = np.linalg.solve(own, np.concatenate([across, self.target[:, where, None]], axis=2))
        gram = self.gram - np.swapaxes(across, 1, 2) @ part[:, :, :-1]
        target = self.target - np.einsum("twk,tw->tk", across, part[:, :, -1])
        square = self.square - np.einsum("tw,tw->t", self.target[:, where], part[:, :, -1])
        return Inner(self.constant, gram, target, square)


@dataclass(frozen=True)
class SetEvidence:
    """SetEvidence of any set of members about one model."""

    members: Sequence[MemberColumns]
    """All of them."""
    inner: Inner
    """Of their columns, per discrepancy of the grid."""
    noise: NoiseScale
    """Of the rows."""

    @classmethod
    def of(
        cls,
        common: Floats,
        prior: Floats,
        residual: Floats,
        members: Sequence[MemberColumns],
        kinds: Sequence[tuple[Discrepancy, float]],
        noise: NoiseScale,
    ) -> SetEvidence:
        """Prepare.

        Parameters
        ----------
        common : (p, r) whitened columns of what every hypothesis has.
        prior : (o, p + 1) rows of what is known of these before; last what they should be.
        residual : (r,) whitened.
        kinds : of discrepancies, each with how probable it is.
        noise : how well its scale is known.
        """
        whole = np.concatenate([common, *(member.rows for member in members), residual[None]])
        plain = whole @ whole.T
        p = len(common)
        known = np.zeros((len(prior), len(whole)))
        known[:, :p], known[:, -1] = prior[:, :p], prior[:, -1]
        plain += known.T @ known
        found = [_without_common(plain, p, float(np.log(NO_DISCREPANCY)))]
        for discrepancy, probability in kinds:
            along, share = discrepancy.along(whole), float(np.log(probability / len(DISCREPANCIES)))
            for size in DISCREPANCIES:
                inner = plain - (along * discrepancy.weights(size)) @ along.T
                found.append(_without_common(inner, p, share - 0.5 * discrepancy.log_determinant(size)))
        inner = Inner(
            np.array([one[0] for one in found]),
            np.array([one[1][:-1, :-1] for one in found]),
            np.array([one[1][:-1, -1] for one in found]),
            np.array([one[1][-1, -1] for one in found]),
        )
        return cls(members, inner, noise)

    @cached_property
    def place(self) -> list[Integers]:
        """Of each member the positions of its columns."""
        ends = np.cumsum([0, *(len(member.rows) for member in self.members)])
        return [np.arange(a, b) for a, b in pairwise(ends)]

    @cached_property
    def log_weights(self) -> list[Floats]:
        """Per member the logarithms of its sizes' probabilities."""
        return [np.log(member.weights / member.weights.sum()) for member in self.members]

    def of_set(self, chosen: Sequence[int]) -> float:
        """Return the log evidence of a set, members by number."""
        return float(np.logaddexp.reduce(self.by_discrepancy(chosen)))

    def by_discrepancy(self, chosen: Sequence[int]) -> Floats:
        """Return (t,) the log evidence of a set for each discrepancy."""
        return self.best_sizes(chosen)[0]

    def best_sizes(self, chosen: Sequence[int], inner: Inner | None = None) -> tuple[Floats, Integers]:
        """Return (t,) the log evidence of a set for each discrepancy, and (t, c) the best size of each member.

        Parameters
        ----------
        inner : what is left of the inner products once other members are taken out; None: all.
        """
        inner = inner or self.inner
        t = len(inner.constant)
        if not len(chosen):
            return inner.constant + self.noise.log_density(inner.square), np.zeros((t, 0), dtype=np.int64)
        where = np.concatenate([self.place[i] for i in chosen])
        own = Inner(inner.constant, inner.gram[:, where[:, None], where], inner.target[:, where], inner.square)
        bounded = np.concatenate([self.members[i].bounded for i in chosen])
        sizes = np.array([[len(self.members[i].sizes) // 2 for i in chosen]] * t)
        value = np.zeros(t)
        for sweep in range(SWEEPS if len(chosen) > 1 else 1):
            before, spread = sizes.copy(), np.zeros(t)
            for j, i in enumerate(chosen):
                line = self._line(own, chosen, sizes, j, bounded) + self.log_weights[i]
                sizes[:, j] = np.argmax(line, axis=1)
                value = line.max(axis=1)
                spread += np.logaddexp.reduce(line - value[:, None], axis=1)
            if sweep and np.array_equal(sizes, before):
                break
        others = np.zeros(t)
        for j, i in enumerate(chosen[:-1]):
            others += self.log_weights[i][sizes[:, j]]
        return inner.constant + value + others + spread, sizes

    def _line(self, inner: Inner, chosen: Sequence[int], sizes: Integers, varied: int, bounded: Booleans) -> Floats:
        """Return (t, s) the log evidence for each size of one member, the others' (t, c) as they are."""
        grid = self.members[chosen[varied]].sizes
        scale = np.concatenate(
            [
                np.broadcast_to(
                    grid[None, :, None] if j == varied else self.members[i].sizes[sizes[:, j], None, None],
                    (len(sizes), len(grid), len(self.place[i])),
                )
                for j, i in enumerate(chosen)
            ],
            axis=2,
        )
        gram = inner.gram[:, None] * scale[..., :, None] * scale[..., None, :]
        k = gram.shape[-1]
        gram[..., range(k), range(k)] += 1.0
        factor = np.linalg.cholesky(gram)
        unit = np.broadcast_to(np.eye(k)[:, bounded], (*scale.shape, int(bounded.sum())))
        parts = np.linalg.solve(factor, np.concatenate([(inner.target[:, None] * scale)[..., None], unit], axis=-1))
        half = parts[..., 0]
        square = inner.square[:, None] - np.sum(half**2, axis=2)
        value = self.noise.log_density(square) - np.sum(np.log(np.diagonal(factor, axis1=2, axis2=3)), axis=2)
        if bounded.any():
            value = value + self._within(parts, square)
        return np.asarray(value)

    def _within(self, parts: Floats, square: Floats) -> Floats:
        """Return the log of how probable it is that bounded coefficients are positive, over half of each before.

        Parameters
        ----------
        parts : (t, s, k, 1 + b) L⁻¹ times target and unit vectors of b bounded coefficients, L Lᵀ their precision.
        square : (t, s) of the residual.
        """
        from scipy.special import log_ndtr

        mean = np.einsum("...kb,...k->...b", parts[..., 1:], parts[..., 0])
        deviation = np.sqrt(np.sum(parts[..., 1:] ** 2, axis=-2))
        noise = self.noise.scale(np.maximum(square, 0.0))[..., None]
        return np.asarray(np.sum(log_ndtr(mean / (noise * deviation)) + np.log(2.0), axis=-1))


def _without_common(inner: Floats, p: int, constant: float) -> tuple[float, Floats]:
    """Return the constant and inner products (p + k + 1)² with the first p columns taken out."""
    size = np.sqrt(np.maximum(np.diag(inner)[:p], 1e-300))
    own = inner[:p, :p] / np.outer(size, size)
    own[np.diag_indices(p)] += ROUNDING
    factor = np.linalg.cholesky(own)
    part = np.linalg.solve(factor, inner[:p, p:] / size[:, None])
    determinant = float(np.sum(np.log(np.diag(factor))) + np.sum(np.log(size)))
    return constant - determinant, inner[p:, p:] - part.T @ part

"""The evidence of sets of members: how probable the readings are, all sizes and the noise integrated.

Rows of unit variance, with the columns X of what every hypothesis has (joint springs and what else the user asked for),
and the columns Z of a set's members. For a discrepancy τ and sizes u of its members, coefficients are normal about 0
with variances u², and the noise's scale is integrated with ν degrees of freedom about the one that the rows have:

    log p = −½ log|V| − ½ log|XᵀV⁻¹X + Λ| − ½ log|I + u G u| − ½ (N + ν) log(ν + Q)

G and Q are inner products under V⁻¹ with X taken out. Coefficients with a bound count by the probability that they lie
within it, after over before. Sizes, kind and size of the discrepancy are summed along splines through their grids
(`stiffcal.judgement.size_grids`): singles over all of them, larger sets about the best, one member after the other.
What the tails of the noise add to that is in `stiffcal.judgement.tails`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.judgement.inner_products import Inner, InnerProducts
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import LARGE_FACTOR, NUMBERS_AT_ONCE, SWEEPS
from stiffcal.judgement.size_grids import log_sum, over_cells
from stiffcal.judgement.tails import Readings

Key = tuple[int, ...]
"""A set, its members by number."""


@dataclass(frozen=True)
class MemberColumns:
    """Whitened columns of one member, in units of their typical size."""

    rows: Floats
    """(q, r); or (q, p) at ``place`` alone."""
    bounded: Booleans
    """(q,) True where the coefficient cannot be negative."""
    sizes: Floats
    """(s,) grid of the size of its coefficients."""
    weights: Floats
    """(s,) prior probability of each."""
    alone: float = 0.0
    """Probability that one of the coefficients stands alone, each alike; else they have a common size."""
    present: Floats = field(default_factory=lambda: np.zeros(0))
    """(q,) coefficients that the model about which this is has already; empty: none."""
    any_of_them: bool = False
    """Whether coefficients that do not stand alone are any of them, as of a frame that is off along some of its axes;
    else all.
    """

    place: Integers | None = None
    """(p,) positions of the rows where they are not 0, as of what happened in one run; None: all."""

    @cached_property
    def patterns(self) -> Floats:
        """(g, q) which coefficients there are: several (all, or any two and more), then each alone."""
        count = len(self.rows)
        several = np.ones((1, count))
        if self.any_of_them:
            several = np.array([row for row in product((1.0, 0.0), repeat=count) if sum(row) > 1.0])
        return np.concatenate([several, np.eye(count if self.alone else 0, count)])

    @cached_property
    def scales(self) -> Floats:
        """(g · s, q) sizes of the coefficients: the grid of each pattern."""
        return np.asarray((self.patterns[:, None] * self.sizes[:, None]).reshape(-1, len(self.rows)))

    @cached_property
    def log_weights(self) -> Floats:
        """(g · s,) logarithms of their probabilities."""
        n_alone = len(self.rows) if self.alone else 0
        n_several = len(self.patterns) - n_alone
        share = np.full(len(self.patterns), self.alone / max(n_alone, 1))
        share[:n_several] = (1.0 - self.alone * bool(n_alone)) / n_several
        log_weights = np.log(self.weights)
        return np.asarray((np.log(share)[:, None] + log_weights - log_sum(log_weights[None])).ravel())


@dataclass(frozen=True)
class SetEvidence:
    """Evidence of any set of members about one model."""

    members: Sequence[MemberColumns]
    """All of them."""
    inner: InnerProducts
    """Of their columns, per discrepancy of the grid."""
    noise: NoiseScale
    """Of the rows."""
    readings: Readings
    """As single readings are left by sets."""
    known: dict[Key, Integers] = field(default_factory=dict)
    """Best sizes (t, c) of sets that were weighed, for these sizes and priors or others near them: where to begin."""
    found: dict[Key, tuple[Floats, Integers]] = field(default_factory=dict, init=False)
    """What `best_sizes` returned of sets."""

    @classmethod
    def of(cls, readings: Readings, members: Sequence[MemberColumns], noise: NoiseScale, jobs: int = 1) -> SetEvidence:
        """Prepare.

        Parameters
        ----------
        readings : with all that members have in them.
        noise : how well its scale is known.
        jobs : stacks of columns whose inner products are made at once.
        """
        columns = [(one.rows, one.place) for one in members]
        inner = InnerProducts.of(readings.shared, columns, readings.residual, jobs)
        return cls(members, inner, noise, readings)

    def normal(self, chosen: Sequence[int]) -> float:
        """Return the log evidence of a set for normal noise: between shapes of one law tails make no difference."""
        return float(np.logaddexp.reduce(self.over_cells(self.best_sizes(chosen)[0])))

    def of_set(self, chosen: Sequence[int]) -> float:
        """Return the log evidence of a set, members by number."""
        return float(np.logaddexp.reduce(self.by_discrepancy(chosen)))

    def by_discrepancy(self, chosen: Sequence[int]) -> Floats:
        """Return (t,) the log evidence of a set for each discrepancy and the sizes for which it stands."""
        value, sizes = self.best_sizes(chosen)
        return self.over_cells(value + self.tails(chosen, value, sizes))

    def over_cells(self, value: Floats) -> Floats:
        """Return (t,) the same from the log evidence at each discrepancy of the grid."""
        return over_cells(value, self.inner.shared.at)

    def tails(self, chosen: Sequence[int], value: Floats, sizes: Integers) -> Floats:
        """Return (t,) what the tails of the noise add to the log evidence of a set, that and its sizes as found."""
        scale = [self.members[i].scales[sizes[:, j]] for j, i in enumerate(chosen)]
        sizes_of_columns = np.concatenate([np.zeros((len(value), 0)), *scale], axis=1)
        return self.readings.gains(self.inner, chosen, sizes_of_columns, value, self.noise.known)

    def best_sizes(self, chosen: Sequence[int]) -> tuple[Floats, Integers]:
        """Return (t,) the log evidence of a set for each discrepancy, and (t, c) the best size of each member."""
        key = tuple(chosen)
        if key not in self.found:
            if len(key) == 1:
                self._weigh_alone(self.alike[key[0]])
            else:
                self.found[key] = self.sizes_next_to(key, self.inner.of_set(key))
                self.known[key] = self.found[key][1]
        return self.found[key]

    def sizes_next_to(self, chosen: Sequence[int], inner: Inner) -> tuple[Floats, Integers]:
        """Return the same as `best_sizes`.

        Parameters
        ----------
        inner : what is left of the set's inner products once other members are taken out.
        """
        t = len(inner.constant)
        if not len(chosen):
            return inner.constant + self.noise.log_density(inner.square), np.zeros((t, 0), dtype=np.int64)
        members = [self.members[i] for i in chosen]
        bounded, sizes = np.concatenate([one.bounded for one in members]), self._first_sizes(tuple(chosen), t)
        lines = [np.empty((t, len(one.log_weights))) for one in members]
        old = np.ones((len(chosen), t), dtype=np.bool_)
        for _ in range(SWEEPS):
            for j, one in enumerate(members):
                at = np.flatnonzero(old[j])
                if not len(at):
                    continue
                those = inner if len(at) == t else inner.at(at)
                lines[j][at] = self._line(those, chosen, sizes[at], j, bounded) + one.log_weights
                best = np.argmax(lines[j][at], axis=1)
                old[:, at[best != sizes[at, j]]] = True
                old[j, at], sizes[at, j] = False, best
            if not old.any():
                break
        each = zip(lines, members, strict=True)
        spread = [log_sum(line.reshape(t, -1, len(one.sizes))) - line.max(axis=1) for line, one in each]
        before = [one.log_weights[sizes[:, j]] for j, one in enumerate(members[:-1])]
        whole = inner.constant + lines[-1].max(axis=1) + np.sum(spread, axis=0)
        return whole + np.sum(before, axis=0) if before else whole, sizes

    def _weigh_alone(self, same: Sequence[int]) -> None:
        """Find `best_sizes` of members alone that are alike in all but their columns."""
        own, target = (np.concatenate([part[i] for i in same]) for part in (self.inner.own, self.inner.target))
        constant, square = (np.tile(part, len(same)) for part in (self.inner.constant, self.inner.square))
        found = self.sizes_next_to(same[:1], Inner(constant, own, target, square))
        for i, value, sizes in zip(same, *(np.split(part, len(same)) for part in found), strict=True):
            self.found[i,], self.known[i,] = (value, sizes), sizes

    @cached_property
    def alike(self) -> list[list[int]]:
        """Of each member the numbers of those that are weighed together: alike in all but their columns."""
        together: dict[tuple[bytes, ...], list[int]] = {}
        found = []
        for i, one in enumerate(self.members):
            key = tuple(part.tobytes() for part in (one.bounded, one.sizes, one.log_weights, one.patterns))
            same = together.setdefault(key, [])
            if same and (len(same) + 1) * one.scales.size * len(self.inner.constant) > NUMBERS_AT_ONCE:
                same = together[key] = []
            same.append(i)
            found.append(same)
        return found

    def _first_sizes(self, chosen: Key, count: int) -> Integers:
        """Return (t, c) the sizes from which those of a set are sought: its own, of all but one member, of each."""
        known = {key: sizes for key, sizes in self._nearest(chosen) if len(sizes) == count}
        if chosen in known:
            return known[chosen].copy()
        sizes = np.empty((count, len(chosen)), dtype=np.int64)
        for j, i in enumerate(chosen):
            sizes[:, j] = known[i,][:, 0] if (i,) in known else len(self.members[i].sizes) // 2
        others = next((key for key in known if len(key) == len(chosen) - 1 and key), None)
        if others is not None:
            sizes[:, np.isin(chosen, others)] = known[others]
        return sizes

    def _nearest(self, chosen: Key) -> Iterator[tuple[Key, Integers]]:
        """Give sizes that are known of a set, of it without one member, and of its members alone."""
        without = (chosen[:j] + chosen[j + 1 :] for j in range(len(chosen)))
        for key in (chosen, *without, *((i,) for i in chosen)):
            if key in self.known:
                yield key, self.known[key]

    def at_best(self, chosen: Sequence[int]) -> tuple[int, Floats]:
        """Return the best discrepancy of a set, and the sizes (w,) of its columns about it."""
        by_discrepancy, sizes = self.best_sizes(chosen)
        best = int(np.argmax(by_discrepancy))
        scale = [self.members[i].scales[k] for i, k in zip(chosen, sizes[best], strict=True)]
        return best, np.concatenate([np.zeros(0), *scale])

    def left_by(self, chosen: Sequence[int]) -> list[Inner]:
        """Return each member's own inner products at the best discrepancy of a set, the set taken out at its sizes."""
        best, scale = self.at_best(chosen)
        return self.inner.given(chosen, scale, best)

    def next_to(self, chosen: Sequence[int], able: Sequence[int]) -> dict[int, float]:
        """Return by number what single members add to the log evidence of a set, its own at their best sizes.

        Members alike in all but their columns are weighed at once.
        """
        left = self.left_by(chosen)
        alike: dict[int, list[int]] = defaultdict(list)
        for i in able:
            alike[self.alike[i][0]].append(i)
        found = dict[int, float]()
        for same in alike.values():
            inner = Inner(
                np.concatenate([left[i].constant for i in same]),
                np.concatenate([left[i].gram for i in same]),
                np.concatenate([left[i].target for i in same]),
                np.concatenate([left[i].square for i in same]),
            )
            more = self.sizes_next_to(same[:1], inner)[0] - self.sizes_next_to((), inner)[0]
            found |= dict(zip(same, more.tolist(), strict=True))
        return found

    def coefficients(self, chosen: Sequence[int]) -> tuple[int, Floats]:
        """Return the best discrepancy of a set, and the coefficients (w,) of its columns about it."""
        best, scale = self.at_best(chosen)
        inner = self.inner.of_set(chosen)
        gram = inner.gram[best] * np.outer(scale, scale) + np.eye(len(scale))
        return best, np.asarray(scale * np.linalg.solve(gram, scale * inner.target[best]))

    def _line(self, inner: Inner, chosen: Sequence[int], sizes: Integers, varied: int, bounded: Booleans) -> Floats:
        """Return (t, g · s) the log evidence for each size of one member, the others' (t, c) as they are.

        The others are taken out at their sizes; along the eigenvectors of what is left of the member's own inner
        products every size is a division.
        """
        ends = np.cumsum([0, *(len(self.members[i].rows) for i in chosen)])
        own = slice(int(ends[varied]), int(ends[varied + 1]))
        scale = [self.members[i].scales[sizes[:, j]] for j, i in enumerate(chosen) if j != varied]
        others = _taken_out(inner, own, np.concatenate([np.zeros((len(sizes), 0)), *scale], axis=1))
        value = _along(inner, own, bounded, others, self.members[chosen[varied]], self.noise)
        return value.reshape(len(value), -1)


TakenOut = tuple[Floats, Floats, Floats]
"""L⁻¹ (t, o, o), L Lᵀ of what is not one's own; L⁻¹ times that with one's own (t, o, q), with the residual (t, o)."""


def _along(
    inner: Inner, own: slice, bounded: Booleans, others: TakenOut, member: MemberColumns, noise: NoiseScale
) -> Floats:
    """Return (t, g, s) the log evidence for each pattern and size of a member's coefficients."""
    inverse, across, half = others
    left = inner.gram[:, own, own] - np.swapaxes(across, 1, 2) @ across
    target = inner.target[:, own] - (half[:, None] @ across)[:, 0]
    before = inner.square - np.sum(half**2, axis=1)
    determinant = np.sum(np.log(np.diagonal(inverse, axis1=1, axis2=2)), axis=1)
    grid, found = member.sizes[:, None] ** 2, []
    for values, turned in _axes(left, member.patterns):
        along = target[:, None, None] @ turned
        share = grid / (1.0 + grid * values)
        square = before[:, None, None] - np.sum(share * along**2, axis=3)
        value = noise.log_density(square) + determinant[:, None, None] - 0.5 * np.sum(np.log1p(grid * values), axis=3)
        if bounded.any():
            mean, variance = _of_coefficients(bounded, own, turned, share, along, inverse, across, half)
            scale = noise.scale(np.maximum(square, 0.0))[..., None]
            value = value + _within(mean / (scale * np.sqrt(np.maximum(variance, 1e-300))))
        found.append(value)
    return np.concatenate(found, axis=1)


def _axes(gram: Floats, patterns: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Give variances (t, g, 1, j) of inner products (t, q, q) along their axes (t, g, q, j), patterns in their order.

    Of several coefficients there are as many axes; one alone is its own.
    """
    several = patterns[patterns.sum(axis=1) > 1.0]
    if len(several):
        values, vectors = np.linalg.eigh(gram[:, None] * several[:, :, None] * several[:, None, :])
        yield np.maximum(values, 0.0)[:, :, None], several[:, :, None] * vectors
    alone = patterns[len(several) :]
    if len(alone):
        values = np.diagonal(gram, axis1=1, axis2=2)[:, np.argmax(alone, axis=1)]
        turned = np.broadcast_to(alone[:, :, None], (len(gram), *alone.shape, 1))
        yield np.maximum(values, 0.0)[:, :, None, None], turned


def _taken_out(inner: Inner, own: slice, scale: Floats) -> TakenOut:
    """Take all out that is not one's own, as far as priors of these sizes allow.

    Parameters
    ----------
    own : of the k columns. scale : (t, o) sizes of the others.
    """
    of_others = np.delete(np.arange(inner.gram.shape[1]), own)
    gram = inner.gram[:, of_others]
    others = gram[:, :, of_others] * scale[:, :, None] * scale[:, None, :]
    others[:, range(scale.shape[1]), range(scale.shape[1])] += 1.0
    inverse = _inverse_of_lower(np.asarray(np.linalg.cholesky(others), dtype=np.float64))
    right = np.concatenate([gram[:, :, own], inner.target[:, of_others, None]], axis=2) * scale[:, :, None]
    parts = inverse @ right
    return inverse, parts[..., :-1], parts[..., -1]


def _inverse_of_lower(factors: Floats) -> Floats:
    """Return the inverses of lower triangular matrices (t, o, o), of large ones one by one: half is zero."""
    from scipy.linalg.lapack import dtrtri

    if factors.shape[1] < LARGE_FACTOR:
        return np.asarray(np.linalg.inv(factors))
    found = np.empty_like(factors)
    for factor, inverse in zip(factors, found, strict=True):
        inverse[...] = dtrtri(factor.T)[0].T
    return found


def _of_coefficients(
    bounded: Booleans,
    own: slice,
    turned: Floats,
    share: Floats,
    along: Floats,
    inverse: Floats,
    across: Floats,
    half: Floats,
) -> tuple[Floats, Floats]:
    """Return means and variances (t, g, s, b) of the bounded coefficients, of any scale, the noise's left out.

    Parameters
    ----------
    turned : (t, g, q, q) eigenvectors of each pattern. share, along : (t, g, s, q) and (t, g, 1, q) of these.
    """
    mine = np.swapaxes(turned[:, :, bounded[own]], 2, 3)
    mean = [(share * along) @ mine]
    variance = [share @ mine**2]
    others = np.delete(bounded, own)
    if others.any():
        rows = np.swapaxes(inverse[:, :, others], 1, 2)
        theirs = np.swapaxes((rows @ across)[:, None] @ turned, 2, 3)
        mean.append((rows @ half[..., None])[:, None, None, :, 0] - (share * along) @ theirs)
        variance.append(np.sum(rows**2, axis=2)[:, None, None] + share @ theirs**2)
    return np.concatenate(mean, axis=3), np.concatenate(variance, axis=3)


def _within(deviations: Floats) -> Floats:
    """Return (t, g, s) the log of how probable it is that coefficients are positive, over half of each before.

    Parameters
    ----------
    deviations : (t, g, s, b) their means in standard deviations.
    """
    from scipy.special import log_ndtr

    return np.asarray(np.sum(log_ndtr(deviations) + np.log(2.0), axis=-1))

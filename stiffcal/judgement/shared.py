"""What every hypothesis has, columns and discrepancies, and what these can make of rows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.judgement.covariance_kind import CovarianceKind
from stiffcal.judgement.discrepancy import Discrepancy
from stiffcal.judgement.numbers import NO_DISCREPANCY, ROUNDING


@dataclass(frozen=True)
class Shared:
    """What all sets have about one model: columns, what is known of these before, and the discrepancies."""

    columns: Floats
    """(p, r) whitened."""
    prior: Floats
    """(o, p + 1) rows of what is known of them before; last what they should be."""
    kinds: Sequence[tuple[CovarianceKind, float]]
    """Of discrepancies, each with how probable it is."""
    lasting: Discrepancy | None = None
    """What is in every run whatever the discrepancy, of one noise; None: nothing."""

    @cached_property
    def along(self) -> list[Floats]:
        """Per kind the parts (p, d) of the columns along its directions."""
        return [discrepancy.along(self.columns) for discrepancy, _ in self.kinds]

    @cached_property
    def grid(self) -> list[tuple[int, Floats, float]]:
        """Per discrepancy its kind, its weights (w,), and a logarithm: its share, and −½ log |V|.

        The first is none; its kind is −1.
        """
        found = [(-1, np.zeros(0), float(np.log(NO_DISCREPANCY)))]
        for number, (discrepancy, probability) in enumerate(self.kinds):
            share = float(np.log(probability / len(discrepancy.sizes)))
            for size in discrepancy.sizes:
                density = share - 0.5 * discrepancy.log_determinant(size)
                found.append((number, discrepancy.weights(size), density))
        return found

    @cached_property
    def at(self) -> list[slice]:
        """Per kind of discrepancy the positions of its sizes in the grid."""
        ends = np.cumsum([1, *(len(one.sizes) for one, _ in self.kinds)]).tolist()
        return [slice(a, b) for a, b in pairwise(ends)]

    @cached_property
    def own(self) -> list[tuple[Floats, float]]:
        """Per discrepancy L⁻¹ (p, p), L Lᵀ the columns' inner products, and log |L|."""
        known = self.prior[:, :-1]
        lasting = self.columns_along_lasting
        plain = self.columns @ self.columns.T - (lasting * self.of_lasting) @ lasting.T
        found = []
        for inner in self.products(self.columns, self.along, self.columns, self.along, plain) + known.T @ known:
            size = np.sqrt(np.maximum(np.diag(inner), 1e-300))
            unit = inner / np.outer(size, size)
            unit[np.diag_indices(len(unit))] += ROUNDING
            factor = np.linalg.cholesky(unit)
            determinant = float(np.sum(np.log(np.diag(factor))) + np.sum(np.log(size)))
            found.append((np.linalg.inv(factor) / size, determinant))
        return found

    @cached_property
    def inverses(self) -> Floats:
        """(t, p, p) of `own`."""
        return np.array([inverse for inverse, _ in self.own])

    def products(
        self,
        rows: Floats,
        along: Sequence[Floats],
        others: Floats,
        along_others: Sequence[Floats],
        plain: Floats,
    ) -> Floats:
        """Return (t, k, l) inner products of rows under V⁻¹; parameters as of `CovarianceKind.products`."""
        found = np.repeat(plain[None], len(self.grid), axis=0)
        for (kind, _), at, mine, theirs in zip(self.kinds, self.at, along, along_others, strict=True):
            found[at] -= kind.products(rows, mine, others, theirs, plain)
        return found

    @cached_property
    def of_lasting(self) -> Floats:
        """(d,) weights of the directions of what lasts."""
        return np.zeros(0) if self.lasting is None else self.lasting.weights(1.0)

    @cached_property
    def columns_along_lasting(self) -> Floats:
        """(p, d) parts of the columns along what lasts in runs."""
        return self.along_lasting(self.columns)

    def along_lasting(self, rows: Floats) -> Floats:
        """Return (k, d) the parts of whitened rows (k, r) along what lasts in runs."""
        return np.zeros((len(rows), 0)) if self.lasting is None else self.lasting.along(rows)

    def numbers_of(self, discrepancy: CovarianceKind | None) -> list[int]:
        """Return the positions in the grid of a kind of discrepancy, one for each of its sizes; none of none."""
        of_kinds = zip(self.kinds, self.at, strict=True)
        return [t for (one, _), at in of_kinds if one is discrepancy for t in range(at.start, at.stop)]

    @cached_property
    def bases(self) -> dict[int, Floats]:
        """By discrepancy V⁻¹ X, orthonormal (p, r), of those asked for."""
        return {}

    def basis(self, number: int) -> Floats:
        """Return V⁻¹ X of a discrepancy of the grid, orthonormal (p, r)."""
        if number not in self.bases:
            self.bases[number] = self.own[number][0] @ self.inverse(self.columns, number)
        return self.bases[number]

    def inverse(self, rows: Floats, number: int) -> Floats:
        """Return V⁻¹ times rows (k, r), V of a discrepancy of the grid."""
        kind, weights, _ = self.grid[number]
        found = None if self.lasting is None else self.lasting.taken_out(rows, self.of_lasting)
        if kind < 0:
            return rows if found is None else found
        return self.kinds[kind][0].taken_out(rows, weights, found)

    def reduced(self, rows: Floats, number: int) -> Floats:
        """Return P times rows (k, r), P = V⁻¹ − V⁻¹X (XᵀV⁻¹X + Λ)⁻¹XᵀV⁻¹ of a discrepancy of the grid."""
        basis = self.basis(number)
        return np.asarray(self.inverse(rows, number) - (rows @ basis.T) @ basis)

    def variance_of_noise(self, number: int) -> Floats:
        """Return (r,) the variance of each row's noise at a discrepancy of the grid."""
        kind, weights, _ = self.grid[number]
        return np.ones(self.columns.shape[1]) if kind < 0 else self.kinds[kind][0].variance_of_noise(weights)

    def leverage(self, number: int) -> Floats:
        """Return (r,) the share of each reading that a discrepancy of the grid takes."""
        kind, weights, _ = self.grid[number]
        found = np.zeros(self.columns.shape[1]) if kind < 0 else self.kinds[kind][0].leverage(weights)
        return found if self.lasting is None else found + self.lasting.leverage(self.of_lasting)


@dataclass(frozen=True)
class SplitRows:
    """Whitened rows (k, r), split into what discrepancies and shared columns can make of them."""

    rows: Floats
    """(k, r) themselves."""
    along: Sequence[Floats]
    """Per kind of discrepancy the parts (k, d) along its directions."""
    lasting: Floats
    """(k, d) the same of what lasts in runs."""
    common: Floats
    """(t, p, k) along the shared columns."""

    @property
    def size(self) -> int:
        """Numbers beyond those of the rows."""
        return sum(one.size for one in (*self.along, self.lasting, self.common))

    @classmethod
    def of(cls, rows: Floats, shared: Shared, wanted: bool = False) -> SplitRows:
        """Split rows.

        Parameters
        ----------
        wanted : whether they are the readings: what shared columns should be counts then too.
        """
        lasting = shared.along_lasting(rows)
        plain = shared.columns @ rows.T - (shared.columns_along_lasting * shared.of_lasting) @ lasting.T
        along = [discrepancy.along(rows) for discrepancy, _ in shared.kinds]
        across = shared.products(shared.columns, shared.along, rows, along, plain)
        if wanted:
            across += (shared.prior[:, :-1].T @ shared.prior[:, -1])[:, None]
        return cls(rows, along, lasting, shared.inverses @ across)

    def split(self, at: Sequence[int]) -> Iterator[SplitRows]:
        """Give the parts of the rows between each two positions."""
        for a, b in pairwise(at):
            along = [one[a:b] for one in self.along]
            yield SplitRows(self.rows[a:b], along, self.lasting[a:b], self.common[:, :, a:b])

    def times(self, other: SplitRows, shared: Shared) -> Floats:
        """Return (t, k, l) inner products with other rows."""
        plain = self.rows @ other.rows.T - (self.lasting * shared.of_lasting) @ other.lasting.T
        found = shared.products(self.rows, self.along, other.rows, other.along, plain)
        return found - np.swapaxes(self.common, 1, 2) @ other.common

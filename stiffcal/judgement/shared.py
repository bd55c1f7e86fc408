"""What every hypothesis has: columns, discrepancies, and the inner products of all else with these taken out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.judgement.discrepancy import Discrepancy, LouderRun
from stiffcal.judgement.priors import NO_DISCREPANCY

ROUNDING = 1e-10


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
        own = self.gram[:, where[:, None], where] * np.outer(scale, scale) + np.eye(len(scale))
        across = self.gram[:, where]
        right = np.concatenate([across, self.target[:, where, None]], axis=2) * scale[:, None]
        part = scale[:, None] * np.linalg.solve(own, right)
        gram = self.gram - np.swapaxes(across, 1, 2) @ part[:, :, :-1]
        target = self.target - np.einsum("twk,tw->tk", across, part[:, :, -1])
        square = self.square - np.einsum("tw,tw->t", self.target[:, where], part[:, :, -1])
        return Inner(self.constant, gram, target, square)


@dataclass(frozen=True)
class Shared:
    """What all sets have about one model: columns, what is known of these before, and the discrepancies."""

    columns: Floats
    """(p, r) whitened."""
    prior: Floats
    """(o, p + 1) rows of what is known of them before; last what they should be."""
    kinds: Sequence[tuple[Discrepancy | LouderRun, float]]
    """Of discrepancies, each with how probable it is."""

    @cached_property
    def along(self) -> list[Floats]:
        """Per kind the parts (p, d) of the columns along its directions."""
        return [discrepancy.along(self.columns) for discrepancy, _ in self.kinds]

    @cached_property
    def grid(self) -> list[tuple[int, Floats, float]]:
        """Per discrepancy its kind, the weights (d,) of its directions, and a logarithm: its share, and −½ log |V|.

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
    def own(self) -> list[tuple[Floats, float]]:
        """Per discrepancy L⁻¹ (p, p), L Lᵀ the columns' inner products, and log |L|."""
        known = self.prior[:, :-1]
        plain = self.columns @ self.columns.T + known.T @ known
        found = []
        for kind, weights, _ in self.grid:
            inner = plain if kind < 0 else plain - (self.along[kind] * weights) @ self.along[kind].T
            size = np.sqrt(np.maximum(np.diag(inner), 1e-300))
            unit = inner / np.outer(size, size)
            unit[np.diag_indices(len(unit))] += ROUNDING
            factor = np.linalg.cholesky(unit)
            determinant = float(np.sum(np.log(np.diag(factor))) + np.sum(np.log(size)))
            found.append((np.linalg.inv(factor) / size, determinant))
        return found

    def numbers_of(self, discrepancy: Discrepancy | LouderRun | None) -> list[int]:
        """Return the positions in the grid of a kind of discrepancy, one for each of its sizes; none of none."""
        return [t for t, (kind, *_) in enumerate(self.grid) if kind >= 0 and self.kinds[kind][0] is discrepancy]

    def inverse(self, rows: Floats, number: int) -> Floats:
        """Return V⁻¹ times rows (k, r), V of a discrepancy of the grid."""
        kind, weights, _ = self.grid[number]
        return rows if kind < 0 else self.kinds[kind][0].taken_out(rows, weights)

    def variance_of_noise(self, number: int) -> Floats:
        """Return (r,) the variance of each row's noise at a discrepancy of the grid."""
        kind, weights, _ = self.grid[number]
        return np.ones(self.columns.shape[1]) if kind < 0 else self.kinds[kind][0].variance_of_noise(weights)

    def leverage(self, number: int) -> Floats:
        """Return (r,) the share of each reading that a discrepancy of the grid takes."""
        kind, weights, _ = self.grid[number]
        return np.zeros(self.columns.shape[1]) if kind < 0 else self.kinds[kind][0].leverage(weights)

    def inner(self, rows: Floats) -> Inner:
        """Return inner products of whitened rows (k + 1, r), last the residual."""
        plain, across = rows @ rows.T, self.columns @ rows.T
        known, wanted = self.prior[:, :-1], self.prior[:, -1]
        across[:, -1] += known.T @ wanted
        plain[-1, -1] += wanted @ wanted
        along = [discrepancy.along(rows) for discrepancy, _ in self.kinds]
        gram = np.empty((len(self.grid), len(rows), len(rows)))
        constant = np.empty(len(self.grid))
        for t, ((kind, weights, density), (inverse, determinant)) in enumerate(zip(self.grid, self.own, strict=True)):
            inner, cross = plain, across
            if kind >= 0:
                grown = along[kind] * weights
                inner, cross = plain - grown @ along[kind].T, across - self.along[kind] @ grown.T
            part = inverse @ cross
            gram[t] = inner - part.T @ part
            constant[t] = density - determinant
        return Inner(constant, gram[:, :-1, :-1], gram[:, :-1, -1], gram[:, -1, -1])

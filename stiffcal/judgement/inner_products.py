"""Inner products of members' columns, with what every hypothesis has taken out.

Thousands of columns have millions of inner products, of which sets of a few members need few. Made at once are those of
each member with itself and with the residual, at every discrepancy; those of two members when a set has both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.judgement.numbers import MOST_KEPT, MOST_SPLIT, NUMBERS_AT_ONCE
from stiffcal.judgement.shared import Shared, SplitRows
from stiffcal.judgement.threads import in_order

Columns = tuple[Floats, Integers | None]
"""Whitened columns (q, r) of a member; or (q, p) at positions (p,) where alone they are not 0."""


@dataclass(frozen=True)
class Inner:
    """Inner products of columns and residual at t discrepancies, the common columns taken out."""

    constant: Floats
    """(t,) what no set changes."""
    gram: Floats
    """(t, k, k) of the columns."""
    target: Floats
    """(t, k) of them with the residual."""
    square: Floats
    """(t,) of the residual."""

    def at(self, numbers: Integers) -> Inner:
        """Return those at some discrepancies."""
        return Inner(self.constant[numbers], self.gram[numbers], self.target[numbers], self.square[numbers])


@dataclass(frozen=True)
class InnerProducts:
    """Inner products of all members' columns, made as sets need them."""

    shared: Shared
    """What every set has."""
    columns: Sequence[Columns]
    """Of each member."""
    residual: Floats
    """(r,) whitened."""
    constant: Floats
    """(t,) what no set changes."""
    square: Floats
    """(t,) of the residual."""
    own: Sequence[Floats]
    """Of each member (t, q, q)."""
    target: Sequence[Floats]
    """Of each member (t, q) with the residual."""
    parts: dict[int, SplitRows] = field(default_factory=dict)
    """Of members that are in sets with others, as long as there is room."""
    pairs: dict[tuple[int, int], Floats] = field(default_factory=dict)
    """(t, q, s) of two members, the first before the second."""
    kept: dict[tuple[int, int], Floats] = field(default_factory=dict)
    """P times the columns (q, r) of a member at a discrepancy, as long as there is room."""
    with_all: dict[tuple[int, int], list[Floats]] = field(default_factory=dict)
    """Of each member (s, q) with the columns of one member at one discrepancy."""

    @classmethod
    def of(cls, shared: Shared, columns: Sequence[Columns], residual: Floats, jobs: int = 1) -> InnerProducts:
        """Prepare.

        Parameters
        ----------
        columns : of each member. residual : (r,) with all that members have in it. jobs : stacks of columns at once.
        """
        left = SplitRows.of(residual[None], shared, wanted=True)
        wanted = float(shared.prior[:, -1] @ shared.prior[:, -1])
        square = left.times(left, shared)[:, 0, 0] + wanted
        constant = np.array([density - own for (_, _, density), (_, own) in zip(shared.grid, shared.own, strict=True)])

        def products(members: Sequence[int]) -> list[tuple[Floats, Floats]]:
            stack = np.concatenate([_all_rows(columns[i], len(residual)) for i in members])
            ends = np.cumsum([0, *(len(columns[i][0]) for i in members)])
            parts = SplitRows.of(stack, shared).split(ends.tolist())
            return [(part.times(part, shared), part.times(left, shared)[:, :, 0]) for part in parts]

        found = [*chain.from_iterable(in_order(products, _together(columns, len(residual)), jobs))]
        own, target = [part for part, _ in found], [part for _, part in found]
        return cls(shared, columns, residual, constant, square, own, target)

    def of_set(self, chosen: Sequence[int]) -> Inner:
        """Return those of a set of members, their columns one after the other."""
        blocks = [[self._pair(i, j) for j in chosen] for i in chosen]
        if not blocks:
            t = len(self.constant)
            return Inner(self.constant, np.zeros((t, 0, 0)), np.zeros((t, 0)), self.square)
        gram = np.concatenate([np.concatenate(row, axis=2) for row in blocks], axis=1)
        return Inner(self.constant, gram, np.concatenate([self.target[i] for i in chosen], axis=1), self.square)

    def _pair(self, i: int, j: int) -> Floats:
        if i == j:
            return self.own[i]
        if i > j:
            return np.swapaxes(self._pair(j, i), 1, 2)
        if (i, j) not in self.pairs:
            self.pairs[i, j] = self._parts(i).times(self._parts(j), self.shared)
        return self.pairs[i, j]

    def _parts(self, number: int) -> SplitRows:
        found = self.parts.pop(number, None)
        if found is None:
            found = SplitRows.of(_all_rows(self.columns[number], len(self.residual)), self.shared)
        self.parts[number] = found
        # those that were asked for last stay, as long as there is room
        while len(self.parts) > 1 and sum(one.size for one in self.parts.values()) > MOST_SPLIT:
            del self.parts[next(iter(self.parts))]
        return found

    def reduced(self, number: int, discrepancy: int) -> Floats:
        """Return P times the columns (q, r) of a member at a discrepancy of the grid."""
        found = self.kept.get((number, discrepancy))
        if found is None:
            found = self.shared.reduced(_all_rows(self.columns[number], len(self.residual)), discrepancy)
            # of a member that stands alone in sets they are asked for once
            if number in self.parts and found.size + sum(one.size for one in self.kept.values()) <= MOST_KEPT:
                self.kept[number, discrepancy] = found
        return found

    def across(self, number: int, discrepancy: int) -> list[Floats]:
        """Return of each member the inner products (s, q) with the columns of one, at a discrepancy of the grid."""
        self._prepare([number], discrepancy)
        return self.with_all[number, discrepancy]

    def _prepare(self, chosen: Sequence[int], discrepancy: int) -> None:
        """Find the inner products of all members with some of them, each member's columns read once."""
        new = [i for i in chosen if (i, discrepancy) not in self.with_all]
        if not new:
            return
        reduced = np.concatenate([self.reduced(i, discrepancy) for i in new]).T
        ends = np.cumsum([len(self.columns[i][0]) for i in new])[:-1]
        whole = [rows @ (reduced if place is None else reduced[place]) for rows, place in self.columns]
        found = [np.split(one, ends, axis=1) for one in whole]
        for k, i in enumerate(new):
            self.with_all[i, discrepancy] = [one[k] for one in found]

    def given(self, chosen: Sequence[int], scale: Floats, discrepancy: int) -> list[Inner]:
        """Return of each member its own at one discrepancy, next to a set of which it says what that leaves.

        Parameters
        ----------
        chosen : the set. scale : (w,) of its columns: they are taken out as far as priors of these sizes allow.
        """
        t = slice(discrepancy, discrepancy + 1)
        inner = self.of_set(chosen)
        gram, target = inner.gram[discrepancy] * np.outer(scale, scale) + np.eye(len(scale)), inner.target[discrepancy]
        inverse = scale[:, None] * np.linalg.inv(np.linalg.cholesky(gram)).T
        half = target @ inverse
        square = self.square[t] - half @ half
        self._prepare(chosen, discrepancy)
        across = [self.with_all[i, discrepancy] for i in chosen]
        found = []
        for j, (own, aim) in enumerate(zip(self.own, self.target, strict=True)):
            moved = np.concatenate([np.zeros((own.shape[1], 0)), *(one[j] for one in across)], axis=1) @ inverse
            found.append(Inner(self.constant[t], own[t] - moved @ moved.T, aim[t] - moved @ half, square))
        return found


def _all_rows(columns: Columns, count: int) -> Floats:
    """Return whitened columns (q, r) with the rows where they are 0."""
    rows, place = columns
    if place is None:
        return rows
    found = np.zeros((len(rows), count))
    found[:, place] = rows
    return found


def _together(columns: Sequence[Columns], count: int) -> Iterator[list[int]]:
    """Give the numbers of members whose columns, of so many rows, are reduced together."""
    members, size = list[int](), 0
    for number, (rows, _) in enumerate(columns):
        if members and size + len(rows) * count > NUMBERS_AT_ONCE:
            yield members
            members, size = [], 0
        members.append(number)
        size += len(rows) * count
    if members:
        yield members

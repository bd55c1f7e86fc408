"""How far each run is from what all the others predict, and whether some stand apart together.

The problem is linear about a fit, so that leaving runs out is a matter of their own small matrices: with A the whitened
columns of a run, b its whitened residual, N the sum of AᵀA over the runs that stay, the deleted residual is
e = b − A x, x from the others alone, and its covariance I + A N⁻¹ Aᵀ holds what the others do not know of x (Cook and
Weisberg, Residuals and Influence in Regression, 1982, ch. 3). All pairs are left out as well as single runs, because
two faulty runs pull the fit towards themselves and hide each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.thresholds import RUNS_FOR_PAIRS, RUNS_FOR_TWO

# Of these runs, those that single deletion changes most, all pairs are left out: 1770 small systems at most.
MOST_IN_PAIRS = 60
LEAST_RUNS = 4
# Directions of the parameters that the runs know less than this share of the best known one are left out.
KNOWN_DIRECTION = 1e-7
# What the others know of a direction, as a share of what all know: below it the run alone determines the parameter.
KNOWN_BY_OTHERS = 1e-6
RIDGE = 1e-10
RUNS_AT_ONCE = 512  # of forty parameters 7 MB


@dataclass(frozen=True)
class Basis:
    """Combinations of the parameters in which all runs together know each direction equally well."""

    combination: Floats
    """(p, q) of the p columns."""

    @classmethod
    def of(cls, rows: Floats) -> Basis:
        """Return the basis of whitened columns (p, k)."""
        size = np.linalg.norm(rows, axis=1)
        scale = np.where(size > 0.0, 1.0 / np.where(size > 0.0, size, 1.0), 0.0)
        if not len(rows):
            return cls(np.zeros((0, 0)))
        _, value, vector = np.linalg.svd((rows * scale[:, None]).T, full_matrices=False)
        determined = value > KNOWN_DIRECTION * value.max(initial=0.0)
        return cls(scale[:, None] * vector[determined].T / value[determined])


@dataclass(frozen=True)
class RunBlocks:
    """The contribution of each of R runs to q combinations of parameters."""

    gram: Floats
    """(R, q, q) AᵀA of each run's rows A."""
    right: Floats
    """(R, q) Aᵀb, b the run's residual."""
    square: Floats
    """(R,) bᵀb."""
    dof: Integers
    """(R,) readings less what the run's own offset takes."""

    @classmethod
    def of(cls, rows: Floats, basis: Basis, members: Sequence[Integers], dof: Integers) -> RunBlocks:
        """Sum whitened rows (p + 1, m, n), columns and then the residual, over each run's states."""
        combined = np.einsum("pq,pmn->qmn", basis.combination, rows[:-1])
        own = [combined[:, :, states].reshape(len(combined), combined.shape[1] * len(states)) for states in members]
        run_residuals = [rows[-1][:, states].ravel() for states in members]
        q = len(combined)
        n = len(own)
        return cls(
            np.array([run_rows @ run_rows.T for run_rows in own]).reshape(n, q, q),
            np.array([run_rows @ end for run_rows, end in zip(own, run_residuals, strict=True)]).reshape(n, q),
            np.array([end @ end for end in run_residuals]),
            dof,
        )

    @cached_property
    def total(self) -> tuple[Floats, Floats]:
        """N (q, q) and Aᵀb (q,) of all runs."""
        return self.gram.sum(axis=0) + RIDGE * np.eye(self.gram.shape[1]), self.right.sum(axis=0)

    def without(self, left_out: Sequence[int]) -> tuple[Floats, Floats]:
        """Return N (q, q) and x (q,) of all runs but these."""
        total, right = self._sums_without(left_out)
        return total, np.asarray(np.linalg.solve(total, right))

    def _sums_without(self, left_out: Sequence[int]) -> tuple[Floats, Floats]:
        left_out_runs, (total, right) = list(left_out), self.total
        return total - self.gram[left_out_runs].sum(axis=0), right - self.right[left_out_runs].sum(axis=0)

    def _deletions(self, left_out: Sequence[int]) -> Iterator[tuple[slice, Floats, Floats]]:
        """Yield N (k, q, q) and Aᵀb (k, q) without ``left_out`` and one run more, for one slice of k runs at a time."""
        total, right = self._sums_without(left_out)
        present = np.ones(len(self.square))
        present[list(left_out)] = 0.0
        for start in range(0, len(present), RUNS_AT_ONCE):
            batch = slice(start, start + RUNS_AT_ONCE)
            gram = self.gram[batch] * present[batch, None, None]
            yield batch, total - gram, right - self.right[batch] * present[batch, None]

    def deleted(self, left_out: Sequence[int]) -> Floats:
        """Return (R,) the squared deleted residual of each run, in units of its covariance.

        Every run is compared with all the others but those left out.
        """
        result = np.empty(len(self.square))
        for batch, total, right in self._deletions(left_out):
            x = np.linalg.solve(total, right[:, :, None])[:, :, 0]
            gram, run_right = self.gram[batch], self.right[batch]
            toward = run_right - np.einsum("kqr,kr->kq", gram, x)
            remaining = self.square[batch] - np.einsum("kq,kq->k", run_right + toward, x)
            weighed = np.linalg.solve(total + gram, toward[:, :, None])[:, :, 0]
            result[batch] = np.maximum(remaining - np.einsum("kq,kq->k", toward, weighed), 0.0)
        return result

    def with_run(self, run: int, readings: RunBlocks, number: int, left_out: Sequence[int]) -> float:
        """Return the squared misfit of other readings in the place of a run's own.

        Parameters
        ----------
        run : the run that they stand for. readings, number : whose run ``number`` they are.
        left_out : runs that, with ``run``, are left out of the parameters.
        """
        total, x = self.without(sorted({*left_out, run}))
        gram, right = readings.gram[number], readings.right[number]
        remaining = readings.square[number] - 2.0 * right @ x + x @ gram @ x
        toward = right - gram @ x
        return float(max(remaining - toward @ np.linalg.solve(total + gram, toward), 0.0))

    def freedom(self, left_out: Sequence[int]) -> Integers:
        """Return (R,) the degrees of freedom of the deleted residuals, at least 0."""
        freedom = np.empty(len(self.square), dtype=np.int64)
        for batch, total, _ in self._deletions(left_out):
            freedom[batch] = self.dof[batch] - np.sum(np.linalg.eigvalsh(total) < KNOWN_BY_OTHERS, axis=1)
        return np.maximum(freedom, 0)

    def best_pair(self) -> tuple[int, ...]:
        """Return the two runs without which the rest agrees best; one or none where there are few runs."""
        count = len(self.square)
        if count < RUNS_FOR_PAIRS:
            return ()
        gain = self.deleted(())
        chosen = np.sort(np.argsort(gain)[::-1][:MOST_IN_PAIRS])
        pairs = np.array(list(combinations(chosen.tolist(), 2)))
        total, total_right = self.total
        gram = total - self.gram[pairs[:, 0]] - self.gram[pairs[:, 1]]
        right = total_right - self.right[pairs[:, 0]] - self.right[pairs[:, 1]]
        solved = np.linalg.solve(gram, right[:, :, None])[:, :, 0]
        cost = -self.square[pairs].sum(axis=1) - np.einsum("kq,kq->k", right, solved)
        return tuple(pairs[int(np.argmin(cost))].tolist())


def standing_apart(scores: Floats, level: float, gap: float, most: int) -> tuple[int, ...]:
    """Return the runs whose scores stand clear of all the others'.

    Parameters
    ----------
    scores : (R,) not negative.
    level : no score below it stands apart.
    gap : the smallest of those apart is so many times the largest of the others.
    most : how many may stand apart: what many runs have in common is no fault of one.

    Examples
    --------
    >>> standing_apart(np.array([1.0, 9.0, 0.8, 1.2, 7.0]), level=4.0, gap=2.0, most=2)
    (1, 4)
    >>> standing_apart(np.array([1.0, 9.0, 6.0, 5.0, 3.5]), level=4.0, gap=2.0, most=2)
    ()
    """
    order = np.argsort(scores)[::-1]
    for count in range(min(most, len(scores) - 1), 0, -1):
        least, next_one = scores[order[count - 1]], scores[order[count]]
        if least >= level and least >= gap * next_one:
            return tuple(sorted(order[:count].tolist()))
    return ()


def most_suspects(n_runs: int) -> int:
    """Return how many of so many runs may be faulty: a sixth, two of eight, one of four, and none of fewer."""
    return 0 if n_runs < LEAST_RUNS else max(1 if n_runs < RUNS_FOR_TWO else 2, n_runs // 6)

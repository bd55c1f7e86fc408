"""Designs for several goals at once, in a stated mix: weighted means of the logarithms of their losses.

With weights that sum to one, the mixed loss is the product of the losses, each to the power of its weight, as in
compound optimum designs (A. C. Atkinson, A. N. Donev, R. D. Tobias, Optimum Experimental Designs, with SAS, 2007,
ch. 21). What no design undercuts in each goal alone, to the power of its weight, is a bound of the mix; no design need
come near it, where goals ask for different runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.planning.criterion import LEAST_GAIN, Criterion, inverse, losses_after
from stiffcal.planning.design import (
    EXCHANGED,
    MOST_PASSES,
    Design,
    compressed,
    relaxed_optimum,
    rounded,
    start_of,
    sum_of,
    value_of,
    wanted_rows,
)
from stiffcal.planning.repeats import Repeats


@dataclass(frozen=True)
class Goal:
    """What runs are chosen for."""

    factors: Floats
    """(N, r, p) of the candidates."""
    criterion: Criterion
    """What is minimised."""
    known: Floats | None
    """(p, p) information that there is already; None: next to none."""
    wanted: Floats | None
    """(q, p) as `design.best_design` has it."""
    weight: float = 1.0
    """Of this goal in the mix."""


@dataclass(frozen=True)
class MixedDesign:
    """A choice of candidates for several goals."""

    design: Design
    """Covariance and course are of the first goal, loss and efficiency of the mix."""
    efficiencies: tuple[float, ...]
    """Of each goal: what no design undercuts in it alone over this design, as a ratio of variances."""


def mixed_design(
    goals: Sequence[Goal], n_runs: int, limit: Repeats | int | None = None, first: Integers | None = None
) -> MixedDesign:
    """Return the design of n runs that exchange finds for a mix of goals.

    Parameters
    ----------
    goals : of the same candidates.
    n_runs : how many runs.
    limit : how often one candidate, or those that are alike, may be measured.
    first : (n_runs,) the design that exchange starts from; None: from the relaxed optima of the goals.
    """
    shares = np.array([goal.weight for goal in goals])
    shares = shares / shares.sum()
    prepared = [_Prepared(goal, n_runs) for goal in goals]
    picked = np.unique(np.concatenate([entry.serving(EXCHANGED // len(goals)) for entry in prepared]))
    picked = picked if first is None else np.union1d(picked, first)
    for entry in prepared:
        entry.keep(picked)
    most = Repeats.of(limit, n_runs).subset(picked)
    if first is None:
        mean = sum(share * entry.weights for share, entry in zip(shares, prepared, strict=True))
        starts = [rounded(weights, n_runs, most.most) for weights in (mean, *(entry.weights for entry in prepared))]
        starts = [most.kept(design, n_runs, np.argsort(-mean, kind="stable")) for design in starts]
    else:
        starts = [np.searchsorted(picked, first)]
    mix = _Mix(prepared, shares)
    designs = [mix.exchanged(start, most) for start in starts]
    best = min(designs, key=mix.loss)
    order = mix.ordered(best)
    losses = np.array([entry.loss(best) for entry in prepared])
    efficiencies = np.minimum(1.0, (np.array([entry.bound for entry in prepared]) / losses) ** 2)
    own = prepared[0]
    course = np.empty((n_runs, own.factors.shape[2]))
    matrix = own.start.copy()
    for place, candidate in enumerate(order):
        matrix = matrix + own.factors[candidate].T @ own.factors[candidate]
        course[place] = np.sqrt(np.diagonal(inverse(matrix)))
    efficiency = float(np.exp(shares @ np.log(efficiencies)))
    design = Design(picked[order], inverse(matrix), course, float(np.exp(mix.loss(best))), efficiency)
    return MixedDesign(design, tuple(efficiencies.tolist()))


class _Prepared:
    """A goal with its relaxed optimum."""

    def __init__(self, goal: Goal, n_runs: int) -> None:
        p = goal.factors.shape[2]
        self.criterion = goal.criterion
        self.rows = wanted_rows(goal.criterion, p, goal.wanted)
        self.start = start_of(p, goal.known)
        self.factors = compressed(goal.factors)
        self.weights, self._gains, self.bound = relaxed_optimum(
            self.factors, n_runs, goal.criterion, self.start, self.rows
        )

    def serving(self, most: int) -> Integers:
        """Return the candidates that gain most at the goal's own optimum."""
        return np.union1d(np.argsort(self._gains, kind="stable")[-most:], np.flatnonzero(self.weights))

    def keep(self, picked: Integers) -> None:
        """Leave the other candidates out."""
        self.factors, self.weights = self.factors[picked], self.weights[picked]

    def loss(self, chosen: Integers) -> float:
        """Return the goal's loss of a design."""
        return value_of(inverse(self.start + sum_of(self.factors, chosen)), self.criterion, self.rows)

    def after(self, others: Integers) -> Floats:
        """Return (N,) the logarithm of the loss after each candidate joins others."""
        covariance = inverse(self.start + sum_of(self.factors, others))
        return losses_after(self.factors, covariance, self.criterion, self.rows)


class _Mix:
    """Goals with their shares."""

    def __init__(self, goals: Sequence[_Prepared], shares: Floats) -> None:
        self._goals, self._shares = goals, shares

    def loss(self, chosen: Integers) -> float:
        """Return the logarithm of the mixed loss."""
        return float(self._shares @ [np.log(goal.loss(chosen)) for goal in self._goals])

    def after(self, others: Integers) -> Floats:
        """Return (N,) the logarithm of the mixed loss after each candidate joins others."""
        return np.asarray(self._shares @ np.stack([goal.after(others) for goal in self._goals]))

    def exchanged(self, chosen: Integers, most: Repeats) -> Integers:
        """Return the design after Fedorov's exchanges."""
        design = chosen.copy()
        for _ in range(MOST_PASSES):
            changed = False
            for place in range(len(design)):
                others = np.delete(design, place)
                losses = self.after(others)
                present = losses[design[place]]
                losses[most.exhausted(others, len(losses))] = np.inf
                better = int(np.argmin(losses))
                if losses[better] < present - LEAST_GAIN:
                    design[place], changed = better, True
            if not changed:
                break
        return design

    def ordered(self, chosen: Integers) -> Integers:
        """Return the chosen candidates in the order in which they bring most."""
        left, order = list(chosen), np.zeros(0, dtype=np.int64)
        while left:
            losses = self.after(order)[left]
            order = np.append(order, left.pop(int(np.argmin(losses))))
        return order

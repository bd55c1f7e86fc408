"""Which candidates to measure: exact designs by exchange, and the bound that no design exceeds.

A candidate is one run (a pose with its load steps) and has a factor A (r, p): its information on the p parameters is
AᵀA. A design measures n candidates, repeats allowed; its information is M = M₀ + Σ AᵀA, with M₀ what is known before.

Sources: V. V. Fedorov, Theory of Optimal Experiments, 1972, ch. 3 (exchange); A. C. Atkinson, A. N. Donev, R. D.
Tobias, Optimum Experimental Designs, with SAS, 2007, ch. 9 to 12 (criteria, exchange); J. Kiefer, J. Wolfowitz, "The
equivalence of two extremum problems", Canadian J. Math. 12, 1960 (bound); S. D. Silvey, D. M. Titterington, B. Torsney,
"An algorithm for optimal designs on a finite design space", Comm. Statist. A7, 1978 (multiplicative weights).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.planning.criterion import LEAST_GAIN, Criterion, inverse, losses_after, variances_of, volume
from stiffcal.planning.repeats import Repeats

# Passes over the whole design; a handful settles.
MOST_PASSES = 12
# The relaxed optimum is accepted at this ratio of its value to its bound.
RELAXED_ENOUGH = 0.995
MOST_ROUNDS = 40
WEIGHT_STEPS = 60
# Candidates that join the relaxed design's support in one round.
JOINING = 20
# Candidates that take part in the exchange: those that gain most at the relaxed optimum. A bound is of all of them.
EXCHANGED = 400
# Candidates whose factors are turned together: memory for it stays small whatever their number.
COMPRESSED_AT_ONCE = 500
# What is known before any measurement: the start of M, so that few runs already have a finite covariance. Standard
# deviation of each parameter in units of its own value: far beyond any use.
VAGUE = 1e2


@dataclass(frozen=True)
class Design:
    """A choice of candidates."""

    chosen: Integers
    """(n,) indices of candidates, the most informative first; a candidate may occur several times."""
    covariance: Floats
    """(p, p) of the parameters after all n runs, in units of the factors' columns."""
    course: Floats
    """(n, p) standard uncertainty of each parameter after the first 1 … n runs, in the same units."""
    loss: float
    """The criterion's value: det(C)^(1/2p) of the p parameters that count, the largest standard uncertainty, or the rms
    error of prediction."""
    efficiency: float
    """Bound of the relaxed optimum over this design, as a ratio of variances, 0 to 1: 0.9 wants a ninth more runs."""


def information(factors: Floats) -> Floats:
    """Return (N, p, p) the information matrices AᵀA of factors (N, r, p)."""
    return np.asarray(np.swapaxes(factors, 1, 2) @ factors)


def compressed(factors: Floats) -> Floats:
    """Return factors with as many rows as the information has rank, rounding aside.

    Parameters
    ----------
    factors : (N, r, p).
    """
    parts = [
        _turned(factors[first : first + COMPRESSED_AT_ONCE]) for first in range(0, len(factors), COMPRESSED_AT_ONCE)
    ]
    whole = np.zeros((len(factors), max(part.shape[1] for part in parts), factors.shape[2]))
    for number, part in enumerate(parts):
        whole[number * COMPRESSED_AT_ONCE :][: len(part), : part.shape[1]] = part
    return whole


def _turned(factors: Floats) -> Floats:
    gram = factors @ np.swapaxes(factors, 1, 2)
    values, vectors = np.linalg.eigh(gram)
    values, vectors = values[:, ::-1], vectors[:, :, ::-1]
    largest = values[:, :1].clip(min=np.finfo(float).tiny)
    rank = int(np.max(np.count_nonzero(values > 1e-12 * largest, axis=1), initial=1))
    return np.asarray(np.swapaxes(vectors[:, :, :rank], 1, 2) @ factors)


def best_design(
    factors: Floats,
    n_runs: int,
    criterion: Criterion,
    known: Floats | None = None,
    wanted: Floats | None = None,
    limit: Repeats | int | None = None,
    bears_losses: bool = False,
    first: Integers | None = None,
) -> Design:
    """Return the best design of n runs that exchange finds from the relaxed optimum's and the greedy start.

    Parameters
    ----------
    factors : (N, r, p) of the candidates; the columns' units are the parameters' values (relative uncertainty).
    n_runs : how many runs.
    criterion : what is minimised.
    known : (p, p) information that there is already; None: next to none.
    wanted : (q, p) rows whose variances count for `Criterion.PREDICTION`; for `Criterion.WORST` those whose largest
        counts, for `Criterion.DETERMINANT` rows of the identity, of the parameters that count; None: all do.
    limit : how often one candidate, or those that are alike, may be measured; None: any number of times.
    first : (n,) the design that exchange starts from; None: from the relaxed optimum and from a greedy choice.
    bears_losses : for `Criterion.WORST`, no uncertainty rests on one run more than it has to (`planning.lost_runs`).

    Raises
    ------
    ValueError : there is no candidate, no run, or no row of predictions where they are needed.
    TooAlikeError : too few candidates differ.
    """
    if len(factors) == 0 or n_runs < 1:
        raise ValueError("a design needs candidates and at least one run")
    rows = wanted_rows(criterion, factors.shape[2], wanted)
    start = start_of(factors.shape[2], known)
    factors = compressed(factors)
    weights, gains, bound = relaxed_optimum(factors, n_runs, criterion, start, rows)
    picked = np.union1d(np.argsort(gains, kind="stable")[-EXCHANGED:], np.flatnonzero(weights))
    picked = picked if first is None else np.union1d(picked, first)
    factors, weights = factors[picked], weights[picked]
    most = Repeats.of(limit, n_runs).subset(picked)
    if first is None:
        order = np.argsort(-gains[picked], kind="stable")
        found = rounded(weights, n_runs, most.most), _greedy(factors, n_runs, criterion, start, rows, most)
        starts = [most.kept(design, n_runs, order) for design in found]
    else:
        starts = [np.searchsorted(picked, first)]
    best: Integers | None = None
    least = np.inf
    for chosen in starts:
        improved = _exchange(factors, chosen, criterion, start, rows, most)
        loss = value_of(inverse(start + sum_of(factors, improved)), criterion, rows)
        if loss < least:
            best, least = improved, loss
    assert best is not None
    if criterion is Criterion.WORST and bears_losses:
        from stiffcal.planning.lost_runs import bearing_losses

        best = bearing_losses(factors, best, start, rows, most)
        least = value_of(inverse(start + sum_of(factors, best)), criterion, rows)
    order = _ordered(factors, best, start, rows, criterion)
    course = np.empty((n_runs, factors.shape[2]))
    matrix = start.copy()
    for place, candidate in enumerate(order):
        matrix = matrix + factors[candidate].T @ factors[candidate]
        course[place] = np.sqrt(np.diagonal(inverse(matrix)))
    covariance = inverse(matrix)
    return Design(picked[order], covariance, course, least, min(1.0, (bound / least) ** 2))


def loss_of(covariance: Floats, criterion: Criterion, wanted: Floats | None = None) -> float:
    """Return the criterion's value of a covariance (p, p); see `Design.loss`."""
    return value_of(covariance, criterion, wanted_rows(criterion, len(covariance), wanted))


def wanted_rows(criterion: Criterion, p: int, wanted: Floats | None) -> Floats:
    """Return (q, p) the rows whose variances count; of a mean variance at most p of them.

    Raises
    ------
    ValueError : there is no row of predictions where they are needed.
    """
    if criterion is not Criterion.PREDICTION:
        return np.eye(p) if wanted is None else wanted
    if wanted is None or len(wanted) == 0:
        raise ValueError("a design for predictions needs their rows")
    # The mean variance tr(W C) needs W alone: its factor has at most p rows.
    triangle = np.linalg.qr(wanted, mode="r")
    return np.asarray(triangle / np.sqrt(len(wanted)))


def start_of(p: int, known: Floats | None) -> Floats:
    """Return (p, p) the information before any run: what is known, and next to none beyond."""
    vague = np.eye(p) / VAGUE**2
    return vague if known is None else known + vague


def sum_of(factors: Floats, chosen: Integers) -> Floats:
    """Return (p, p) the information of chosen candidates."""
    stacked = factors[chosen].reshape(-1, factors.shape[2])
    return np.asarray(stacked.T @ stacked)


def value_of(covariance: Floats, criterion: Criterion, rows: Floats) -> float:
    """Return the criterion's value of a covariance (p, p), of rows as `wanted_rows` makes them."""
    if criterion is Criterion.DETERMINANT:
        return float(np.exp(volume(covariance, rows) / (2 * len(rows))))
    if criterion is Criterion.WORST:
        return float(np.sqrt(np.max(variances_of(covariance, rows))))
    return float(np.sqrt(np.sum(variances_of(covariance, rows))))


def _rule(covariance: Floats, criterion: Criterion, rows: Floats) -> tuple[Criterion, Floats]:
    """Return the criterion, and its rows, by which the next candidate is taken.

    While the largest variance is of something not known yet, the determinant of all parameters leads there faster.
    """
    if criterion is Criterion.WORST and bool(np.max(variances_of(covariance, rows)) > 1.0):
        return Criterion.DETERMINANT, np.eye(len(covariance))
    return criterion, rows


def _greedy(factors: Floats, n_runs: int, criterion: Criterion, start: Floats, rows: Floats, most: Repeats) -> Integers:
    """Return candidates taken one after the other: by determinant until all parameters are known, then as wished.

    Fewer than there are runs, where the others are like those that are taken.
    """
    chosen: list[int] = []
    matrix = start.copy()
    for _ in range(n_runs):
        covariance = inverse(matrix)
        losses = losses_after(factors, covariance, *_rule(covariance, criterion, rows))
        exhausted = most.exhausted(np.array(chosen, dtype=np.int64), len(factors))
        if exhausted.all():
            break
        losses[exhausted] = np.inf
        candidate = int(np.argmin(losses))
        chosen.append(candidate)
        matrix = matrix + factors[candidate].T @ factors[candidate]
    return np.array(chosen)


def _exchange(
    factors: Floats, chosen: Integers, criterion: Criterion, start: Floats, rows: Floats, most: Repeats
) -> Integers:
    """Return the design after Fedorov's exchanges: each run in turn gives way to the candidate that serves best."""
    design = chosen.copy()
    for _ in range(MOST_PASSES):
        changed = False
        for place in range(len(design)):
            without = start + sum_of(factors, np.delete(design, place))
            losses = losses_after(factors, inverse(without), criterion, rows)
            present = losses[design[place]]
            losses[most.exhausted(np.delete(design, place), len(factors))] = np.inf
            better = int(np.argmin(losses))
            if losses[better] < present - LEAST_GAIN:
                design[place], changed = better, True
        if not changed:
            break
    return design


def _ordered(factors: Floats, chosen: Integers, start: Floats, rows: Floats, criterion: Criterion) -> Integers:
    """Return the chosen candidates in the order in which they bring most."""
    left, order, matrix = list(chosen), [], start.copy()
    while left:
        covariance = inverse(matrix)
        rule = _rule(covariance, criterion, rows)
        candidate = left.pop(int(np.argmin(losses_after(factors[left], covariance, *rule))))
        order.append(candidate)
        matrix = matrix + factors[candidate].T @ factors[candidate]
    return np.array(order)


def rounded(weights: Floats, n_runs: int, most: int) -> Integers:
    """Return n runs close to the relaxed weights, by largest remainders."""
    shares = np.minimum(weights * n_runs, most)
    count = np.floor(shares).astype(np.int64)
    while count.sum() < n_runs:
        remainder = np.where(count < most, shares - count, -np.inf)
        count[int(np.argmax(remainder))] += 1
    return np.repeat(np.arange(len(weights)), count)[:n_runs]


def relaxed_optimum(
    factors: Floats, n_runs: int, criterion: Criterion, start: Floats, rows: Floats
) -> tuple[Floats, Floats, float]:
    """Return weights (N,) of the relaxed optimum, gains (N,) there, and a loss that no design of n runs undercuts.

    Weights sum to one; a gain is the derivative of the loss by a candidate's weight, negative, in arbitrary units.

    Weights are found on a growing support (the candidates that violate the equivalence theorem most join). The bound
    holds for any weights: with M = M₀ + n Σ wᵢ Fᵢ, C = M⁻¹ and a matrix W, every other design M* has
    tr(M* C W C) ≤ t = tr(M₀ C W C) + n maxᵢ tr(Fᵢ C W C), so tr(W C*) ≥ tr(W C)² / t (Cauchy-Schwarz). Of q rows R with
    S = R C Rᵀ and W = Rᵀ S⁻¹ R it is t ≥ tr(S S*⁻¹) (the same of matrices), so det(S*)^(1/q) ≥ det(S)^(1/q) q / t
    (arithmetic and geometric mean). The largest variance is bounded by the mean variance under any weights of the
    parameters.
    """
    p = factors.shape[2]
    shares = np.full(len(rows), 1.0 / len(rows))
    support = np.unique(
        _greedy(
            factors, min(max(2 * p // factors.shape[1], 8), 40), Criterion.DETERMINANT, start, np.eye(p), Repeats(1)
        )
        if len(factors) > 40
        else np.arange(len(factors))
    )
    inside = np.full(len(support), 1.0 / len(support))
    best_bound, best_loss, best_weights = 0.0, np.inf, np.zeros(len(factors))
    best_gains = best_weights
    for _ in range(MOST_ROUNDS):
        used = factors[support]
        for _ in range(WEIGHT_STEPS):
            covariance, target = _relaxed_state(used, inside, n_runs, start, criterion, rows, shares)
            gains = np.sum((used @ target) * used, axis=(1, 2))
            # the exponents that make the step monotone: 1 for the determinant, 1/2 for traces
            moved = inside * (gains if criterion is Criterion.DETERMINANT else np.sqrt(gains))
            # where no candidate brings anything all weights are as good
            inside = moved / moved.sum() if moved.any() else inside
            if criterion is Criterion.WORST:
                variances = variances_of(covariance, rows)
                shares = shares * np.sqrt(variances / np.max(variances))
                shares = np.maximum(shares / shares.sum(), 1e-12)
                shares = shares / shares.sum()
        covariance, target = _relaxed_state(used, inside, n_runs, start, criterion, rows, shares)
        gains = np.sum((factors @ target) * factors, axis=(1, 2))
        bound = _bound(covariance, target, gains, n_runs, start, criterion, rows, shares)
        loss = value_of(covariance, criterion, rows)
        best_bound = max(best_bound, bound)
        if loss < best_loss:
            best_loss, best_gains = loss, gains
            best_weights = np.zeros(len(factors))
            best_weights[support] = inside
        if best_bound >= RELAXED_ENOUGH * best_loss:
            break
        keep = inside > 1e-6 * inside.max()
        support, inside = support[keep], inside[keep]
        joining = np.setdiff1d(np.argsort(gains)[::-1][:JOINING], support)
        support = np.concatenate([support, joining])
        inside = np.concatenate([0.9 * inside / inside.sum(), np.full(len(joining), 0.1 / max(1, len(joining)))])
        inside = inside / inside.sum()
    return best_weights, best_gains, best_bound


def _relaxed_state(
    used: Floats, inside: Floats, n_runs: int, start: Floats, criterion: Criterion, rows: Floats, shares: Floats
) -> tuple[Floats, Floats]:
    """Return the covariance of relaxed weights, and C W C, by which candidates gain."""
    stacked = (used * np.sqrt(n_runs * inside)[:, None, None]).reshape(-1, used.shape[2])
    covariance = inverse(start + stacked.T @ stacked)
    if criterion is Criterion.DETERMINANT and len(rows) == len(covariance):
        return covariance, covariance
    moved = covariance @ rows.T
    if criterion is Criterion.DETERMINANT:
        return covariance, moved @ np.linalg.solve(rows @ moved, moved.T)
    if criterion is Criterion.WORST:
        return covariance, (moved * shares) @ moved.T
    return covariance, moved @ moved.T


def _bound(
    covariance: Floats,
    target: Floats,
    gains: Floats,
    n_runs: int,
    start: Floats,
    criterion: Criterion,
    rows: Floats,
    shares: Floats,
) -> float:
    most = float(np.sum(start * target) + n_runs * np.max(gains))
    if criterion is Criterion.DETERMINANT:
        return value_of(covariance, criterion, rows) * float(np.sqrt(len(rows) / most))
    if criterion is Criterion.WORST:
        return float(np.sum(shares * variances_of(covariance, rows)) / np.sqrt(most))
    return float(np.sum(variances_of(covariance, rows)) / np.sqrt(most))

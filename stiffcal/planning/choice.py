"""From possible runs to a plan: which parameters can be identified, which runs to measure, in which order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.planning.design import VAGUE, Criterion, Design, best_design, information, loss_of

# A parameter whose relative standard uncertainty stays above this with all candidates measured cannot be identified.
LARGEST_RELATIVE = 1.0


@dataclass(frozen=True)
class Choice:
    """The runs to measure, and what they bring."""

    design: Design
    """Of the parameters in ``free`` alone."""
    free: Booleans
    """(p,) the parameters that the fit of such a campaign would determine."""
    identified: Booleans
    """(p,) of these, the ones that are known by themselves, not only in combination with others."""


def choose_runs(
    factors: Floats,
    n_runs: int,
    criterion: Criterion,
    known: Floats | None = None,
    wanted: Floats | None = None,
    limit: int | None = None,
) -> Choice | None:
    """Return the best choice of runs; None where no parameter can be identified.

    Parameters
    ----------
    factors : (N, r, p) of the candidates, relative to the parameters' values.
    n_runs : how many runs.
    criterion : what is minimised.
    known : (p, p) information that there is already, relative to the values; None: none.
    wanted : (q, p) rows of predictions, for `Criterion.PREDICTION`.
    limit : how often one candidate may be measured.
    """
    free, identified = identifiable(factors, known)
    if not free.any():
        return None
    own = factors[:, :, free]
    known = None if known is None else known[np.ix_(free, free)]
    wanted = None if wanted is None else wanted[:, free]
    if criterion is Criterion.WORST:
        # What so few runs cannot show at all would alone decide on the largest uncertainty. It stays in the fit.
        first = best_design(own, n_runs, Criterion.DETERMINANT, known, None, limit)
        aimed = identified[free] & (np.diagonal(first.covariance) <= LARGEST_RELATIVE**2)
        wanted = np.eye(int(np.count_nonzero(free)))[aimed] if aimed.any() else None
    return Choice(best_design(own, n_runs, criterion, known, wanted, limit), free, identified)


def identifiable(factors: Floats, known: Floats | None) -> tuple[Booleans, Booleans]:
    """Return (p,) which parameters a fit to all candidates determines, and (p,) which of them by themselves.

    As in the fit, parameters leave one after the other, the least certain first, until those that are left are certain.
    Of parameters that make up for each other some leave and some stay; none of them is identified by itself.
    """
    p = factors.shape[2]
    total = np.sum(information(factors), axis=0) + np.eye(p) / VAGUE**2
    if known is not None:
        total = total + known
    alone = np.sqrt(np.diagonal(np.linalg.inv(total))) <= LARGEST_RELATIVE
    free = np.ones(p, dtype=np.bool_)
    while free.any():
        places = np.flatnonzero(free)
        relative = np.sqrt(np.diagonal(np.linalg.inv(total[np.ix_(places, places)])))
        if relative.max() <= LARGEST_RELATIVE:
            break
        free[places[int(np.argmax(relative))]] = False
    return free, free & alone


def efficiency_of(factors: Floats, chosen: Integers, criterion: Criterion, other: Design) -> float:
    """Return the ratio of variances of a design to those of some other choice of candidates: above 1 it is better.

    Parameters
    ----------
    factors : (N, r, p) of the candidates.
    chosen : indices of the other choice.
    criterion : what is compared.
    other : the design.
    """
    matrix = np.sum(information(factors[chosen]), axis=0) + np.eye(factors.shape[2]) / VAGUE**2
    return float((loss_of(np.linalg.inv(matrix), criterion) / other.loss) ** 2)


def short_order(joints: Floats) -> Integers:
    """Return an order of poses with short moves: each time the nearest by its largest joint move, from the first on.

    Parameters
    ----------
    joints : (n, L) rad.
    """
    left, order = list(range(1, len(joints))), [0]
    while left:
        moves = np.max(np.abs(joints[left] - joints[order[-1]]), axis=1)
        order.append(left.pop(int(np.argmin(moves))))
    return np.array(order)

"""From possible runs to a plan: which parameters can be identified, which runs to measure, in which order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.estimation.identifiability import check_identifiability
from stiffcal.estimation.unknowns import Unknowns
from stiffcal.planning.criterion import Criterion, inverse, losses_after
from stiffcal.planning.design import Design, best_design, compressed, start_of, sum_of
from stiffcal.planning.goals import Goal
from stiffcal.planning.repeats import Repeats

# Runs whose rows are triangulated together.
RUNS_AT_ONCE = 500
# A parameter whose relative standard uncertainty stays above this with all candidates measured cannot be identified.
LARGEST_RELATIVE = 1.0


@dataclass(frozen=True)
class Choice:
    """The runs to measure, and what they bring."""

    design: Design
    """Of the parameters in ``free`` alone, or of rival models."""
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
    limit: Repeats | int | None = None,
    nonlinear: Booleans | None = None,
    first: Integers | None = None,
    named: Booleans | None = None,
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
    nonlinear : (p,) True for nonlinear parameters; None: none is.
    first : (n_runs,) a choice to begin with; None: none is known.
    named : (p,) the parameters that count for `Criterion.WORST` and `Criterion.DETERMINANT`; None: all.
    """
    prepared = goal_of_parameters(factors, n_runs, criterion, known, wanted, limit, nonlinear, named)
    if prepared is None:
        return None
    goal, free, identified = prepared
    design = best_design(
        goal.factors, n_runs, criterion, goal.known, goal.wanted, limit, bears_losses=True, first=first
    )
    # what all candidates together distinguish, these runs may not
    return Choice(design, free, identified & identifiable(factors[design.chosen], known, nonlinear)[1])


def goal_of_parameters(
    factors: Floats,
    n_runs: int,
    criterion: Criterion,
    known: Floats | None,
    wanted: Floats | None,
    limit: Repeats | int | None,
    nonlinear: Booleans | None,
    named: Booleans | None = None,
    weight: float = 1.0,
) -> tuple[Goal, Booleans, Booleans] | None:
    """Return the goal with the parameters that can be identified, (p,) which these are, and (p,) which by themselves.

    Parameters
    ----------
    factors, n_runs, criterion, known, wanted, limit, nonlinear, named : as in `choose_runs`.
    weight : of the goal in a mix.
    """
    free, identified = identifiable(factors, known, nonlinear)
    if not free.any():
        return None
    own = factors[:, :, free]
    known = None if known is None else known[np.ix_(free, free)]
    wanted = None if wanted is None else wanted[:, free]
    if criterion is Criterion.WORST:
        # What so few runs cannot show at all would alone decide on the largest uncertainty. It stays in the fit.
        certain = best_design(own, n_runs, Criterion.DETERMINANT, known, None, limit)
        aimed = identified[free] & (np.diagonal(certain.covariance) <= LARGEST_RELATIVE**2)
    elif criterion is Criterion.DETERMINANT:
        aimed = np.ones(own.shape[2], dtype=np.bool_)
    if criterion is not Criterion.PREDICTION:
        if named is not None and (aimed & named[free]).any():
            aimed = aimed & named[free]
        wanted = np.eye(own.shape[2])[aimed] if aimed.any() else None
    return Goal(own, criterion, known, wanted, weight), free, identified


def choice_of_design(
    design: Design, factors: Floats, known: Floats | None, nonlinear: Booleans | None = None
) -> Choice:
    """Return runs that were chosen for something else, with the parameters that they identify.

    Parameters
    ----------
    design : of the same candidates.
    factors, known, nonlinear : as in `choose_runs`.
    """
    free, identified = identifiable(factors, known, nonlinear)
    return Choice(design, free, identified & identifiable(factors[design.chosen], known, nonlinear)[1])


def identifiable(factors: Floats, known: Floats | None, nonlinear: Booleans | None = None) -> tuple[Booleans, Booleans]:
    """Return (p,) which parameters a fit to runs determines, and (p,) which of them by themselves.

    By the rules of the fit (`estimation.identifiability`): of parameters that make up for each other some are left
    at their neutral value and some stay; none of them is identified by itself.

    Parameters
    ----------
    factors : (N, r, p) of the runs, relative to the parameters' values.
    known : (p, p) information that there is already, likewise; None: none.
    nonlinear : (p,) True for nonlinear parameters; None: none is.
    """
    p = factors.shape[2]
    rows = np.zeros((0, p))
    if known is not None:
        values, vectors = np.linalg.eigh(known)
        rows = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    # the triangle of some runs after the other: memory does not grow with their number
    for first in range(0, len(factors), RUNS_AT_ONCE):
        more = factors[first : first + RUNS_AT_ONCE].reshape(-1, p)
        rows = np.asarray(np.linalg.qr(np.concatenate([rows, more]), mode="r"))
    rows = np.concatenate([rows, np.zeros((max(0, p - len(rows)), p))])
    largest = np.full(p, LARGEST_RELATIVE)
    unknowns = Unknowns.plain([f"{column}" for column in range(p)], -largest, largest, nonlinear)
    checked = check_identifiability(rows, unknowns)
    return ~checked.left_at_neutral, checked.identifiable


def further_runs(factors: Floats, chosen: Integers, count: int, known: Floats | None, counted: Booleans) -> Integers:
    """Return the candidates that one would measure next, one after the other.

    Parameters
    ----------
    factors : (N, r, p) of the candidates.
    chosen : the runs before.
    count : how many more.
    known : (p, p) information that there is already; None: none.
    counted : (p,) the parameters whose largest uncertainty is to become smaller.
    """
    rows = np.eye(factors.shape[2])[counted]
    matrix = start_of(factors.shape[2], known) + sum_of(factors, chosen)
    factors = compressed(factors)
    further = []
    for _ in range(count):
        further.append(int(np.argmin(losses_after(factors, inverse(matrix), Criterion.WORST, rows))))
        matrix = matrix + factors[further[-1]].T @ factors[further[-1]]
    return np.array(further, dtype=np.int64)


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

"""Gauss–Newton on rows that any kind of experiment makes, until a step is small against the standard uncertainties.

The estimate is the least weighted sum of squares, of readings and of what is known before, within bounds and under the
weights of the model where it ends. What the equations do not distinguish is held (`step`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Progress
from stiffcal.estimation.identifiability import Identifiability
from stiffcal.estimation.shortened_step import TakenStep
from stiffcal.estimation.step import solve_step
from stiffcal.estimation.triangular import Reduced
from stiffcal.estimation.unknowns import Unknowns
from stiffcal.model.balance.no_balance import NoBalanceError

# A step below this share of the standard uncertainty changes nothing of any use.
SMALL_STEP = 1e-3
# Laws with corners (friction, play) make steps vary at this level, and in large campaigns, whose steps are expensive
# and whose uncertainties are small against what any model leaves out, such a step changes nothing of any use either.
ROUGH_STEP = 1e-2
MAX_STEPS = 30
# Standard uncertainties by which corrections of readings still move in the last step, rms.
SMALL_CORRECTION = 0.02
# A step of less, in standard uncertainties, is near the solution.
NEAR = 1.0
# Steps that are taken whole: on the way through a curved valley the sum of squares may rise and the next step be right.
# Where they end higher than the fit began, it goes back to the lowest place (the watchdog of Chamberlain, Powell,
# Lemarechal and Pedersen 1982).
WHOLE_STEPS = 8
# A share of the noise may follow the unknowns: each of the first steps has its own weights, and a fit ends on weights
# of its last step, or on such from which it moved by less than `ROUGH_STEP`.
REWEIGHTED_STEPS = 3


class Weighed(Protocol):
    """Readings with their weights: what a sum of squares is of."""

    def sums_as(self, other: Any) -> bool:
        """Return whether a sum of squares compares with that of others, of the same kind."""


W = TypeVar("W", bound=Weighed)


class RowSource(Protocol[W]):
    """Readings and a model of them: what makes the rows of a fit about values of its unknowns."""

    @property
    def unknowns(self) -> Unknowns:
        """The p unknowns."""

    @property
    def curved(self) -> bool:
        """Whether the rows, or their weights, change with the unknowns: one step is not enough."""

    @property
    def lasting_weights(self) -> bool:
        """Whether weights have to settle with the unknowns, as those that bear wild readings do."""

    def reduced(self, values: Floats, weights: W | None, renew: bool) -> tuple[Reduced, W]:
        """Return the rows about values (p,) in triangular form, what is known before among them, and their weights.

        Parameters
        ----------
        values : (p,).
        weights : of the last rows; None: there were none.
        renew : whether the weights are made again.

        Raises
        ------
        NoBalanceError : the model has no equilibrium there.
        """

    def squares(self, values: Floats, reduced: Reduced, weights: W) -> float:
        """Return the sum of squares of rows about values (p,) under other weights than their own."""

    def corrected(self, values: Floats, reduced: Reduced, weights: W) -> tuple[RowSource[W], float]:
        """Return the readings corrected near the solution, and by how many standard uncertainties they moved."""


@dataclass(frozen=True)
class Settled(Generic[W]):
    """Where Gauss–Newton ended."""

    values: Floats
    """(p,) the estimates."""
    weights: W
    """Of the last rows."""
    reduced: Reduced
    """The last rows that were solved, about where the last step began."""
    checked: Identifiability
    """What they determine."""
    iterations: int
    """Steps taken."""
    moved: float
    """How far the estimates are from where `reduced` was made, in standard uncertainties per parameter."""
    contraction: float = 1.0
    """The next step is expected to be that share of the last one: what that was of the one before."""
    last_step: float | None = None
    """Length of the last step where the fit did not settle; None where it did."""


@dataclass(frozen=True)
class _Met:
    """Where a step ended, with its sum of squares."""

    cost: float
    values: Floats
    reduced: Reduced
    checked: Identifiability
    """What was held in the step."""


def settle(
    source: RowSource[W], start: Floats, begun: Settled[W] | None, progress: Progress, near: bool = False
) -> Settled[W]:
    """Take steps until one is negligible, at most `MAX_STEPS`.

    One that does not settle, as where two sets of what is held take turns, ends at the least sum that it has met. With
    ``begun``, where a part of the data ended, the noise is known, steps contract as they did there, and what is held is
    held again as long as as much has to be.

    With ``near`` the steps end where the next one is expected below `NEAR`. A step that goes too far is shortened
    (`TakenStep`) where it is near the solution or `WHOLE_STEPS` were taken; where that leaves nothing of it, the fit
    stays where the step began. Where whole steps have led nowhere, those that follow begin at the lowest place met. A
    step to where the model has no equilibrium is shortened too, at any iteration.

    Parameters
    ----------
    source : makes the rows.
    start : (p,) values at which the fit begins.
    begun : where a part of the data ended; None: nothing has been fitted.
    progress : called with what is being done.
    near : see above.

    Raises
    ------
    NoBalanceError : the model has no equilibrium where the fit begins, or the fit does not converge short of where it
        has none.
    """
    unknowns = source.unknowns
    values, iterations, last = start, 0, np.inf
    contraction = 1.0 if begun is None else begun.contraction
    shaped, iterates = bool(unknowns.nonlinear.any()), source.curved
    small = ROUGH_STEP if begun is not None or shaped else SMALL_STEP
    weights: W | None = None
    under: W | None = None
    # sums of squares are compared step by step, each under its own weights: of the one where the fit began
    moved, weighed_at, level, lowest = 0.0, values, 1.0, (1.0, values)
    taken: TakenStep | None = None
    beyond: NoBalanceError | None = None
    least: _Met | None = None
    n_beyond, stale = 0, False
    while True:
        progress("fit in equilibrium", min(0.9, 0.3 + 0.2 * iterations))
        renew = iterations - n_beyond <= REWEIGHTED_STEPS or moved > SMALL_CORRECTION or stale
        weighed_at, stale = values if renew else weighed_at, False
        iterations += 1
        try:
            reduced, weights = source.reduced(values, weights, renew)
        except NoBalanceError as error:
            beyond, n_beyond = beyond or error, n_beyond + 1
            if taken is None or iterations >= MAX_STEPS or taken.left < small:
                raise beyond from None
            taken, last = taken.shortest(), 0.0
            values = taken.reached
            continue
        if taken is not None:
            met = _Met(reduced.cost(np.zeros_like(values)), values, reduced, taken.checked)
            least = met if least is None or renew or met.cost < least.cost else least
        shorter, reached = None, level
        if taken is not None:
            alike, far = under is None or weights.sums_as(under), taken.left >= NEAR
            # near the solution sums under other weights, or of corrected readings, do not compare
            if alike or (far and iterations <= WHOLE_STEPS + 1):
                zero = np.zeros_like(values)
                squares = reduced.cost(zero) if alike or under is None else source.squares(values, reduced, under)
                reached = level * squares / taken.began if taken.began > 0.0 else level
                lowest = (reached, values) if reached < lowest[0] else lowest
            if far and iterations == WHOLE_STEPS + 1 and reached > 1.0:
                (level, values), taken, last, stale = lowest, None, 0.0, True
                continue
            if alike and not (far and iterations <= WHOLE_STEPS):
                shorter = taken.shortened(squares)
        if shorter is not None:
            if shorter.left < small or iterations >= MAX_STEPS:
                values, left = shorter.start, shorter.left
                stale = shorter.distance(weighed_at) > ROUGH_STEP
                if stale and iterations < MAX_STEPS:
                    taken, last = None, 0.0
                    continue
                if beyond is not None and left >= small:
                    raise beyond
                ended = Settled(values, weights, shorter.reduced, shorter.checked, iterations, 0.0)
                return ended if left < small else replace(ended, last_step=left)
            # The next step cannot be predicted from a shortened one.
            taken, last, values = shorter, 0.0, shorter.reached
            continue
        level = reached
        held = None if begun is None else begun.checked
        if taken is not None:
            held = taken.checked if begun is not None or taken.left < NEAR else None
        # what shapes do comes and goes on the way, and with it what can be distinguished
        updated, checked = solve_step(reduced, unknowns, values, None if shaped else held)
        taken, under = TakenStep.of(values, updated, reduced, checked), weights
        change, values = taken.left, updated
        # Steps contract evenly: the next one is predicted by this one and the ratio to the last. Next to a corner they
        # do not: the steps of a law with shape parameters have to be small themselves.
        if iterations > 1:
            contraction = min(1.0, change / last) if last > 0.0 else 1.0
        next_step = change * contraction
        # Far from the solution a residual is the model's, not the readings'.
        corrected, moved = source.corrected(values, reduced, weights) if next_step < NEAR else (source, 0.0)
        settled = moved < SMALL_CORRECTION and (
            change < small or (next_step < small and not (source.lasting_weights or shaped))
        )
        stale = settled and not renew and taken.distance(weighed_at) > ROUGH_STEP
        settled = (settled and not stale) or (near and next_step < NEAR)
        if settled or not iterates or iterations >= MAX_STEPS:
            last_step = change if iterates and not settled else None
            if last_step is None:
                return Settled(values, weights, reduced, checked, iterations, change, contraction)
            if beyond is not None:
                raise beyond
            if least is None:
                return Settled(values, weights, reduced, checked, iterations, change, contraction, last_step)
            return Settled(least.values, weights, least.reduced, least.checked, iterations, 0.0, 1.0, last_step)
        last, source = change, corrected

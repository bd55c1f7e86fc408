"""One step of Gauss–Newton: the least squares within bounds, and what its equations do not distinguish held."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.estimation.identifiability import Identifiability, check_identifiability
from stiffcal.estimation.triangular import Reduced
from stiffcal.estimation.unknowns import Unknowns

# Holding one of a set may cost this factor in squares, as the set's regressors agree to a per mille only.
WORSE_WITHOUT = 1.01


def solve_step(
    reduced: Reduced, unknowns: Unknowns, start: Floats, last: Identifiability | None = None
) -> tuple[Floats, Identifiability]:
    """Solve for the new values; those that cannot be distinguished stay neutral, or where they are (`keep_values`).

    Where sets of indistinguishable parameters overlap, it matters which of them are held, because compliances cannot be
    negative: the solution with all of them free decides. Near the solution what is held stays as long as as much has to
    be: of choices that are nearly as good each would make the next step choose another one, without end.

    Parameters
    ----------
    reduced : the problem linearised about ``start``.
    unknowns : of p parameters.
    start : (p,) where the step begins.
    last : what the last step held, where this one is near the solution, else None.
    """
    checked = check_identifiability(reduced.factor, unknowns)
    stays = last is not None and np.sum(last.left_at_neutral) == np.sum(checked.left_at_neutral)
    checked = last if last is not None and stays else checked
    # A law bends with its shape: no step beyond a factor of two. Shapes of either sign have no such scale.
    scaled = unknowns.nonlinear & (unknowns.lower >= 0.0)
    lower = np.where(scaled, np.maximum(unknowns.lower, start / 2), unknowns.lower)
    upper = np.where(scaled, np.minimum(unknowns.upper, start * 2), unknowns.upper)
    # The reduced target is for the step; bounds hold for the sum.
    target = reduced.target + reduced.factor @ start
    system = Reduced(reduced.factor, target, reduced.remainder, reduced.dof)
    result = _solve_free(system, checked, unknowns.keep_values, start, lower, upper)
    if stays or not checked.left_at_neutral.any():
        return result, checked
    every, at_bound = system.solve_bounded(lower, upper)
    # Parameters at a bound are held: those at one with all free, else those at one with the others held.
    at_bound_of_free = ~checked.left_at_neutral & ((result <= lower) | (result >= upper))
    for useless in (at_bound, at_bound_of_free):
        if system.cost(result) <= WORSE_WITHOUT * system.cost(every):
            break
        without_useless = check_identifiability(reduced.factor, unknowns, ~useless)
        better = _solve_free(system, without_useless, unknowns.keep_values, start, lower, upper)
        if system.cost(better) < system.cost(result):
            result, checked = better, without_useless
    return result, checked


def _solve_free(
    system: Reduced, checked: Identifiability, keeps: Booleans, start: Floats, lower: Floats, upper: Floats
) -> Floats:
    """Return the best amplitudes with the others held, at zero or (``keeps``) where they are."""
    free = ~checked.left_at_neutral
    result = np.where(free | keeps, start, 0.0)
    if free.any():
        target = system.target - system.factor[:, ~free & keeps] @ start[~free & keeps]
        of_free = Reduced(system.factor[:, free], target, 0.0, 0)
        result[free], _ = of_free.solve_bounded(lower[free], upper[free], independent=True)
    return result

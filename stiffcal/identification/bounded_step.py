"""One step of Gauss–Newton: the least squares within bounds, and what its equations do not distinguish held."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.identification.identifiability import GivenBefore, Identifiability, check_identifiability
from stiffcal.identification.least_squares import Reduced
from stiffcal.identification.observation import ParameterColumn
from stiffcal.identification.reported import bounds_of
from stiffcal.identification.settings import Settings
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import ParameterRole

# Holding one of a set may cost this factor in squares, as the set's regressors agree to a per mille only.
WORSE_WITHOUT = 1.01


def _check_identifiability(
    reduced: Reduced,
    robot: CompliantRobot,
    columns: Sequence[ParameterColumn],
    settings: Settings,
    needed: Booleans | None = None,
) -> Identifiability:
    names = tuple(robot.placed[c.placed].parameter_name(c.symbol) for c in columns)
    lower, upper = bounds_of(robot, columns)
    widest = np.where(np.isfinite(upper), np.maximum(np.abs(upper), np.abs(lower)), np.inf)
    under, undriven, scaling, same_motion, one_orientation, tilt_loaded = (
        np.array([name in chosen for name in names], dtype=np.bool_)
        for chosen in (
            settings.noise_dominated, settings.undriven, settings.redundant, settings.same_motion,
            settings.one_orientation, settings.tilt_loaded,
        )
    )  # fmt: skip
    specs = [robot.placed[c.placed].effect.spec(c.symbol) for c in columns]
    tolerance = np.array([np.inf if spec.tolerance is None else spec.tolerance for spec in specs])
    prior = np.array([np.inf if spec.prior is None else spec.prior for spec in specs])
    numbers = {name: number for number, name in enumerate(names)}
    scale = tuple(numbers[name] for name in settings.common_scale if name in numbers)
    given = GivenBefore(tolerance, same_motion, undriven, prior, tilt_loaded, one_orientation, scale)
    return check_identifiability(reduced.factor, names, widest, _are_nonlinear(columns), needed, under, scaling, given)


def _are_nonlinear(columns: Sequence[ParameterColumn]) -> Booleans:
    return np.array([column.role is ParameterRole.NONLINEAR for column in columns], dtype=np.bool_)


def solve_step(
    reduced: Reduced,
    robot: CompliantRobot,
    columns: Sequence[ParameterColumn],
    start: Floats,
    settings: Settings,
    last: Identifiability | None = None,
) -> tuple[Floats, Identifiability]:
    """Solve for the new amplitudes; those that cannot be distinguished stay neutral: at zero, shapes where they are.

    Where sets of indistinguishable parameters overlap, it matters which of them are held, because compliances cannot be
    negative: the solution with all of them free decides. Near the solution what is held stays as long as as much has to
    be: of choices that are nearly as good each would make the next step choose another one, without end.

    Parameters
    ----------
    start : (p,) where the step begins. last : what the last step held, where this one is near the solution, else None.
    """
    checked = _check_identifiability(reduced, robot, columns, settings)
    stays = last is not None and np.sum(last.left_at_neutral) == np.sum(checked.left_at_neutral)
    checked = last if last is not None and stays else checked
    lower, upper = bounds_of(robot, columns)
    shapes = _are_nonlinear(columns)
    # A law bends with its shape: no step beyond a factor of two. Shapes of either sign have no such scale.
    scaled = shapes & (lower >= 0.0)
    lower = np.where(scaled, np.maximum(lower, start / 2), lower)
    upper = np.where(scaled, np.minimum(upper, start * 2), upper)
    # The reduced target is for the step; bounds hold for the sum.
    target = reduced.target + reduced.factor @ start
    system = Reduced(reduced.factor, target, reduced.remainder, reduced.dof)
    names = [robot.placed[column.placed].parameter_name(column.symbol) for column in columns]
    scaled_alike = settings.common_scale[:1]
    keeps = shapes | np.array([name in settings.redundant or name in scaled_alike for name in names], dtype=np.bool_)
    result = _solve_free(system, checked, keeps, start, lower, upper)
    if stays or not checked.left_at_neutral.any():
        return result, checked
    every, at_bound = system.solve_bounded(lower, upper)
    # Parameters at a bound are held: those at one with all free, else those at one with the others held.
    at_bound_of_free = ~checked.left_at_neutral & ((result <= lower) | (result >= upper))
    for useless in (at_bound, at_bound_of_free):
        if system.cost(result) <= WORSE_WITHOUT * system.cost(every):
            break
        without_useless = _check_identifiability(reduced, robot, columns, settings, ~useless)
        better = _solve_free(system, without_useless, keeps, start, lower, upper)
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
        result[free], _ = Reduced(system.factor[:, free], target, 0.0, 0).solve_bounded(lower[free], upper[free])
    return result

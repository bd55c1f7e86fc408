"""Gauss–Newton on the finite balance, until a step is small against the standard uncertainties."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Progress
from stiffcal.identification.bounded_step import solve_step
from stiffcal.identification.corrected_wrenches import corrected_wrenches
from stiffcal.identification.identifiability import Identifiability
from stiffcal.identification.least_squares import Reduced, reduce_blocks
from stiffcal.identification.observation import Evaluation, Observations, ParameterColumn, evaluate, free_columns
from stiffcal.identification.priors import with_prior
from stiffcal.identification.problem import Problem
from stiffcal.identification.reported import amplitudes
from stiffcal.identification.settings import Settings
from stiffcal.identification.shortened_step import TakenStep
from stiffcal.identification.weights import (
    Weights,
    estimate_weights,
    huber_whitening,
    needs_wrench_sensitivity,
    weighed_alike,
)
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import ParameterRole
from stiffcal.model.no_balance import NoBalanceError

# A step below this share of the standard uncertainty changes nothing of any use.
SMALL_STEP = 1e-3
# Laws with corners (friction, play) make steps vary at this level, and in large campaigns, whose steps are expensive
# and whose uncertainties are small against what any model leaves out, such a step changes nothing of any use either.
ROUGH_STEP = 1e-2
MAX_STEPS = 30
# Standard uncertainties of the wrench by which corrections of clamped states still move in the last step, rms.
SMALL_CORRECTION = 0.02
# A step of less, in standard uncertainties, is near the solution.
NEAR = 1.0
# Steps that are taken whole: on the way through a curved valley the sum of squares may rise and the next step be right.
WHOLE_STEPS = 8
# The wrench's share of the noise follows the compliances: each of the first steps has its own weights, and a fit ends
# on weights from which it moved by less than `ROUGH_STEP`.
REWEIGHTED_STEPS = 2


@dataclass(frozen=True)
class Settled:
    """Where Gauss–Newton ended; ``last_step`` is the last one, in standard uncertainties, where it did not."""

    robot: CompliantRobot
    weights: Weights
    columns: list[ParameterColumn]
    reduced: Reduced
    checked: Identifiability
    iterations: int
    data: Observations
    last_step: float | None = None


@dataclass(frozen=True)
class _Met:
    """Where a step ended, with its sum of squares."""

    cost: float
    robot: CompliantRobot
    reduced: Reduced
    checked: Identifiability
    """What was held in the step."""


def settle(
    problem: Problem,
    robot: CompliantRobot,
    settings: Settings,
    begun: Settled | None,
    progress: Progress,
    near: bool = False,
) -> Settled:
    """Take steps until one is negligible, at most `MAX_STEPS`.

    One that does not settle, as where two sets of what is held take turns, ends at the least sum that it has met. With
    ``begun``, where a part of the data ended, the noise is known, and what is held is held again as long as as
    much has to be.

    The estimate is the least weighted sum of squares under the weights of the model where it ends. With ``near`` the
    steps end where the next one is expected below `NEAR`. A step that goes too far is shortened (`TakenStep`) where it
    is near the solution or `WHOLE_STEPS` were taken; where that leaves nothing of it, the fit stays where the step
    began. A step to where the robot has no equilibrium is shortened too, at any iteration.

    Raises
    ------
    NoBalanceError : the robot has none where the fit begins, or the fit does not converge short of where it has none.
    """
    data, columns = problem.data, free_columns(robot, settings.fixed)
    amplitude = amplitudes(robot, columns)
    iterations, last, robust = 0, np.inf, settings.loss == "huber"
    shaped = any(c.role is ParameterRole.NONLINEAR for c in columns)
    stated = None if begun is None else begun.weights
    small = ROUGH_STEP if stated is not None or shaped else SMALL_STEP
    weights, lowered, moved, weighed_at = stated, None, 0.0, amplitude
    taken: TakenStep | None = None
    beyond: NoBalanceError | None = None
    least: _Met | None = None
    n_beyond, stale = 0, False
    while True:
        progress("fit in equilibrium", min(0.9, 0.3 + 0.2 * iterations))
        renew = iterations - n_beyond <= REWEIGHTED_STEPS or moved > SMALL_CORRECTION or stale
        weighed_at, stale = amplitude if renew else weighed_at, False
        iterations += 1
        try:
            weights, blocks = _weighed(problem, data, (robot, columns), settings, (stated, weights), renew)
            if robust:
                predicted = np.concatenate([block.predicted for block in blocks], axis=1)
                lowered = huber_whitening(weights.whitening, lowered or weights.whitening, data, predicted)
            under = (lowered or weights.whitening, data)
            reduced = with_prior(reduce_blocks(blocks, data, under[0]), robot, columns, data)
        except NoBalanceError as error:
            beyond, n_beyond = beyond or error, n_beyond + 1
            if taken is None or iterations >= MAX_STEPS or taken.left < small:
                raise beyond from None
            taken, last = taken.shortest(), 0.0
            amplitude = taken.reached
            robot = with_estimates(robot, columns, amplitude)
            continue
        if taken is not None:
            met = _Met(reduced.cost(np.zeros_like(amplitude)), robot, reduced, taken.checked)
            least = met if least is None or renew or met.cost < least.cost else least
        far = taken is None or (iterations <= WHOLE_STEPS and taken.left >= NEAR)
        shorter = None if far or taken is None else taken.shortened(reduced, under)
        if shorter is not None:
            if shorter.left < small or iterations >= MAX_STEPS:
                robot, left = with_estimates(robot, columns, shorter.start), shorter.left
                stale = shorter.distance(weighed_at) > ROUGH_STEP
                if stale and iterations < MAX_STEPS:
                    taken, last, amplitude = None, np.inf, shorter.start
                    continue
                if beyond is not None and left >= small:
                    raise beyond
                ended = Settled(robot, weights, columns, shorter.reduced, shorter.checked, iterations, data)
                return ended if left < small else replace(ended, last_step=left)
            # The next step cannot be predicted from a shortened one.
            taken, last, amplitude = shorter, 0.0, shorter.reached
            robot = with_estimates(robot, columns, amplitude)
            continue
        held = None if begun is None else begun.checked
        if taken is not None:
            held = taken.checked if stated is not None or taken.left < NEAR else None
        # what shapes do comes and goes on the way, and with it what can be distinguished
        updated, checked = solve_step(reduced, robot, columns, amplitude, settings, None if shaped else held)
        taken = TakenStep.of(amplitude, updated, reduced, checked, under)
        change, amplitude = taken.left, updated
        robot = with_estimates(robot, columns, amplitude)
        # Steps contract evenly: the next one is predicted by this one and the ratio to the last. Next to a corner they
        # do not: the steps of a law with shape parameters have to be small themselves.
        next_step = change * min(1.0, change / last) if iterations > 1 and last > 0.0 else change
        # Far from the solution a residual is the model's, not the wrench's.
        corrected, moved = corrected_wrenches(robot, data, reduced, weights) if next_step < NEAR else (data, 0.0)
        settled = moved < SMALL_CORRECTION and (change < small or (next_step < small and not (robust or shaped)))
        stale = settled and taken.distance(weighed_at) > ROUGH_STEP
        settled = (settled and not stale) or (near and next_step < NEAR)
        if settled or not (robot.deformed or robust) or iterations >= MAX_STEPS:
            last_step = change if (robot.deformed or robust) and not settled else None
            if last_step is None:
                return Settled(robot, weights, columns, reduced, checked, iterations, data)
            if beyond is not None:
                raise beyond
            met = least or _Met(np.inf, robot, reduced, checked)
            return Settled(met.robot, weights, columns, met.reduced, met.checked, iterations, data, last_step)
        last, data = change, corrected


def _weighed(
    problem: Problem,
    data: Observations,
    model: tuple[CompliantRobot, Sequence[ParameterColumn]],
    settings: Settings,
    known: tuple[Weights | None, Weights | None],
    renew: bool,
) -> tuple[Weights, Iterable[Evaluation]]:
    """Return weights and the model's rows.

    Parameters
    ----------
    problem, settings : as in `settle`.
    data : the observations with their present correction.
    model : robot and free columns.
    known : the weights that were stated, and those of the last step; None where there are none.
    renew : whether the weights are made again.
    """
    (robot, columns), (stated, weights) = model, known
    if stated is not None and settings.loss != "huber":
        blocks: Iterable[Evaluation] = evaluate(robot, data, columns, with_sensitivity=stated.carried and renew)
        return weighed_alike(stated, data, blocks) if renew or weights is None else (weights, blocks)
    rows = list(evaluate(robot, data, columns, with_sensitivity=renew and needs_wrench_sensitivity(settings.noise)))
    if renew or weights is None:
        weights = estimate_weights(data, rows, problem.groups, problem.stated, settings.noise, settings.equal_weights)
    return weights, rows


def with_estimates(robot: CompliantRobot, columns: Sequence[ParameterColumn], amplitude: Floats) -> CompliantRobot:
    """Return the robot with amplitudes (p,) of its free columns."""
    values: dict[str, float] = {}
    for column, a in zip(columns, amplitude, strict=True):
        placed_effect = robot.placed[column.placed]
        spec = placed_effect.effect.spec(column.symbol)
        values[placed_effect.parameter_name(column.symbol)] = spec.value_of(float(a))
    return robot.with_values(values)

"""The choice of runs: among drawn poses, then with joint angles refined around the chosen ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.workflow.plan_candidates import Candidates, refined_around
from stiffcal.workflow.plan_model import (
    PlanModel,
    checked_balance,
    fixed_names,
    known_information,
    prior_scenarios,
    with_rotation,
)

if TYPE_CHECKING:
    from stiffcal.planning.choice import Choice
    from stiffcal.planning.design import Criterion
    from stiffcal.planning.information import RunInformation
    from stiffcal.planning.rivals import PairInformation

# Standard deviations of the joint angles about the chosen poses, one after the other, rad.
SPREADS = (np.radians(10.0), np.radians(4.0), np.radians(1.5))


@dataclass(frozen=True)
class Purpose:
    """What runs are chosen for."""

    criterion: Criterion
    """Without rivals."""
    n_runs: int
    """How many runs."""
    rivals: list[PlanModel]
    """Models to separate; empty: the model's own parameters count."""
    wanted: Callable[[Floats], Floats] | None
    """Returns (q, p) rows of predictions from the parameters' scale; None: none are wanted."""


@dataclass(frozen=True)
class ChosenRuns:
    """The choice, and what it was made from."""

    candidates: Candidates
    """All runs that could be chosen, refined ones among them."""
    information: RunInformation
    """Of these, on the model's own parameters."""
    known: Floats | None
    """(p, p) what a fit knows already."""
    wanted: Floats | None
    """(q, p) rows of predictions."""
    choice: Choice
    """Indices into the candidates, and what is identified."""
    pairs: list[PairInformation]
    """Of the rivals; empty where there are none."""


def chosen_runs(
    campaign: Campaign, plan: PlanFile, model: PlanModel, candidates: Candidates, purpose: Purpose
) -> ChosenRuns:
    """Return the best runs that were found.

    Raises
    ------
    InputError : no possible load turns any parameter's joint, or a load is more than the springs hold.
    """
    around = _chosen(campaign, plan, model, candidates, purpose)
    for spread in SPREADS:
        places, first = np.unique(around.choice.design.chosen, return_inverse=True)
        pool = refined_around(campaign, plan, model, around.candidates.subset(places), spread)
        around = _chosen(campaign, plan, model, pool, purpose, first.ravel())
    # all candidates once more: the bound is of these, and a drawn pose may serve next to the refined ones
    chosen = around.candidates.subset(around.choice.design.chosen)
    whole, first = candidates.with_others(chosen)
    return _chosen(campaign, plan, model, whole, purpose, first)


def _chosen(
    campaign: Campaign,
    plan: PlanFile,
    model: PlanModel,
    candidates: Candidates,
    purpose: Purpose,
    first: Integers | None = None,
) -> ChosenRuns:
    from stiffcal.planning.choice import choice_of_design
    from stiffcal.planning.information import information_of_runs
    from stiffcal.planning.rivals import RivalModel, pairs_of_rivals, separating_design

    means = (model.setup, model.noise, with_rotation(campaign), fixed_names(campaign))
    information = checked_balance(
        lambda: information_of_runs(model.robot, candidates.joints, candidates.wrench, *means)
    )
    known = known_information(model, information)
    wanted = None if purpose.wanted is None else purpose.wanted(information.scale)
    pairs: list[PairInformation] = []
    choice: Choice | None
    if purpose.rivals:
        rivals = [RivalModel.of_covariance(entry.robot, entry.covariance) for entry in purpose.rivals]
        pairs = checked_balance(lambda: pairs_of_rivals(rivals, candidates.joints, candidates.wrench, *means))
        design = separating_design(pairs, purpose.n_runs, plan.repeats, first)
        choice = choice_of_design(design, information.factors, known, information.nonlinear)
    else:
        choice = _choice_for_ranges(campaign, plan, model, candidates, purpose, (information, known, wanted), first)
    if choice is None or not choice.identified.any():
        reason = "no possible load turns any parameter of the model enough to identify it"
        mend = "allow other directions, a larger force, or a load point with a lever arm"
        raise InputError.at(FaultCode.DATA_MISSING, PLAN_FILE, "load", reason, mend)
    return ChosenRuns(candidates, information, known, wanted, choice, pairs)


def _choice_for_ranges(
    campaign: Campaign,
    plan: PlanFile,
    model: PlanModel,
    candidates: Candidates,
    purpose: Purpose,
    nominal: tuple[RunInformation, Floats | None, Floats | None],
    first: Integers | None,
) -> Choice | None:
    """Return the choice that serves the model and both ends of the prior ranges of its unknown nonlinear parameters.

    The parameters of each of these count as parameters of their own: what is worst or mean is that over all of them.
    """
    from stiffcal.planning.choice import Choice, choose_runs
    from stiffcal.planning.information import information_of_runs

    information, known, wanted = nominal
    means = (model.setup, model.noise, with_rotation(campaign), fixed_names(campaign))
    p = len(information.names)
    factors = [information.factors]
    robots = prior_scenarios(plan, model)
    for robot in robots[1:]:
        runs = checked_balance(partial(information_of_runs, robot, candidates.joints, candidates.wrench, *means))
        factors.append(runs.factors * (information.scale / runs.scale))
    count = len(robots)
    blocks = np.zeros((len(candidates.joints), count * factors[0].shape[1], count * p))
    for number, block in enumerate(factors):
        rows = slice(number * block.shape[1], (number + 1) * block.shape[1])
        blocks[:, rows, number * p : (number + 1) * p] = block
    choice = choose_runs(
        blocks, purpose.n_runs, purpose.criterion, _repeated(known, count), _repeated(wanted, count), plan.repeats,
        np.tile(information.nonlinear, count), first,
    )  # fmt: skip
    return None if choice is None else Choice(choice.design, choice.free[:p], choice.identified[:p])


def _repeated(matrix: Floats | None, count: int) -> Floats | None:
    """Return a matrix as often along the diagonal."""
    return None if matrix is None else np.asarray(np.kron(np.eye(count), matrix), dtype=np.float64)

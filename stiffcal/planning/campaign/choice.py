"""The choice of runs: among drawn poses, then with joint angles refined around the chosen ones."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.errors import Fault, InputError
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.planning.campaign.candidates import refined_around
from stiffcal.planning.campaign.goals import LOOK_ALIKES, STIFFNESS, PredictedArea, WantedGoal
from stiffcal.planning.campaign.model import PlanModel, checked_balance
from stiffcal.planning.campaign.pairs import Candidates
from stiffcal.planning.campaign.scenarios import known_information, prior_scenarios

if TYPE_CHECKING:
    from stiffcal.planning.choice import Choice
    from stiffcal.planning.criterion import Criterion
    from stiffcal.planning.information import RunInformation
    from stiffcal.planning.repeats import Repeats
    from stiffcal.planning.rivals import PairInformation

# Standard deviations of the joint angles about the chosen poses, one after the other, rad.
SPREADS = (np.radians(10.0), np.radians(4.0), np.radians(1.5))
# Poses that differ by no more in any joint are the same run under the same load: so far refinement moves a pose first.
ALIKE = SPREADS[0]


@dataclass(frozen=True)
class Purpose:
    """What runs are chosen for."""

    goals: list[WantedGoal]
    """At least one, with weights."""
    criterion: Criterion
    """Of the goal "stiffness"."""
    n_runs: int
    """How many runs."""
    rivals: list[PlanModel]
    """Models to separate; empty: none."""
    area: PredictedArea
    """Where predictions are to be good, if that is a goal."""


@dataclass(frozen=True)
class ChosenRuns:
    """The choice, and what it was made from."""

    candidates: Candidates
    """All runs that could be chosen, refined ones among them."""
    information: RunInformation
    """Of these, on the model's own parameters."""
    known: Floats | None
    """(p, p) what a fit knows already."""
    choice: Choice
    """Indices into the candidates, and what is identified."""
    pairs: list[PairInformation]
    """Of the rivals; empty where there are none."""
    efficiencies: tuple[float, ...] = ()
    """Of each goal alone; empty where there is one goal."""


def chosen_runs(
    campaign: Campaign, plan: PlanFile, model: PlanModel, candidates: Candidates, purpose: Purpose
) -> ChosenRuns:
    """Return the best runs that were found.

    Raises
    ------
    InputError : no possible load turns any parameter's joint, a load is more than the springs hold, or too few possible
        runs differ.
    """
    from stiffcal.planning.repeats import TooAlikeError

    try:
        return _refined(campaign, plan, model, candidates, purpose)
    except TooAlikeError as error:
        reason = (
            f"of {purpose.n_runs} runs only {error.found} would differ: the others repeat a pose within "
            f"{np.degrees(ALIKE):.0f}° of each joint under the same load, and show nothing new"
        )
        # of those that differ each as often as all of the runs need
        repeats = plan.repeats * -(-purpose.n_runs // error.found)
        mend = f"plan {error.found} runs, widen limits_deg, allow more directions, or write repeats = {repeats}"
        changes = (
            InputChange("runs", sizes=(float(error.found),)),
            InputChange("repeats", sizes=(float(repeats),)),
        )
        raise InputError(Fault(FaultCode.POSE_UNREACHABLE, PLAN_FILE, "runs", reason, mend, changes=changes)) from None


def _refined(
    campaign: Campaign, plan: PlanFile, model: PlanModel, candidates: Candidates, purpose: Purpose
) -> ChosenRuns:
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
    from stiffcal.planning.choice import choice_of_design, identifiable
    from stiffcal.planning.rivals import separating_design

    repeats = repeats_of(plan, candidates)
    information = model.information(candidates)
    known = known_information(model, information)
    pairs = _pairs(model, candidates, purpose)
    choice: Choice | None
    efficiencies: tuple[float, ...] = ()
    if not identifiable(information.factors, known, information.nonlinear)[1].any():
        choice = None
    elif len(purpose.goals) > 1:
        choice, efficiencies = _choice_for_mix(
            plan, model, candidates, purpose, (information, known), pairs, repeats, first
        )
    elif purpose.goals[0].name == LOOK_ALIKES:
        design = separating_design(pairs, purpose.n_runs, repeats, first)
        choice = choice_of_design(design, information.factors, known, information.nonlinear)
    else:
        choice = _choice_for_ranges(plan, model, candidates, purpose, (information, known), repeats, first)
    if choice is None or not choice.identified.any():
        reason = "no possible load excites any parameter of the model enough to identify it"
        mend = "allow other directions, a larger force, or a load point with a lever arm"
        raise InputError.at(FaultCode.DATA_MISSING, PLAN_FILE, "load", reason, mend)
    return ChosenRuns(candidates, information, known, choice, pairs, efficiencies)


def _pairs(model: PlanModel, candidates: Candidates, purpose: Purpose) -> list[PairInformation]:
    """Return what the candidates bring on every ordered pair of rivals."""
    from stiffcal.planning.rivals import RivalModel, pairs_of_rivals

    if not purpose.rivals:
        return []
    rivals = [RivalModel.of_covariance(entry.robot, entry.covariance, entry.noise) for entry in purpose.rivals]
    return checked_balance(
        lambda: pairs_of_rivals(
            rivals, candidates.joints, candidates.wrench, model.setup, model.noise, model.with_rotation, model.fixed,
            model.kind, candidates.turn,
        )
    )  # fmt: skip


def _choice_for_mix(
    plan: PlanFile,
    model: PlanModel,
    candidates: Candidates,
    purpose: Purpose,
    nominal: tuple[RunInformation, Floats | None],
    pairs: list[PairInformation],
    repeats: Repeats,
    first: Integers | None,
) -> tuple[Choice | None, tuple[float, ...]]:
    """Return the choice for several goals, and the efficiency in each goal alone."""
    from stiffcal.planning.choice import choice_of_design, goal_of_parameters
    from stiffcal.planning.criterion import Criterion
    from stiffcal.planning.goals import mixed_design
    from stiffcal.planning.rivals import goal_of_pairs

    information, known = nominal
    goals = []
    for goal in purpose.goals:
        if goal.name == LOOK_ALIKES:
            goals.append(goal_of_pairs(pairs, goal.weight))
            continue
        criterion = purpose.criterion if goal.name == STIFFNESS else Criterion.PREDICTION
        prepared = goal_of_parameters(
            information.factors, purpose.n_runs, criterion, known, _wanted(model, purpose, information), repeats,
            information.nonlinear, named_parameters(plan, information), goal.weight,
        )  # fmt: skip
        if prepared is None:
            return None, ()
        goals.append(prepared[0])
    mixed = mixed_design(goals, purpose.n_runs, repeats, first)
    return choice_of_design(mixed.design, information.factors, known, information.nonlinear), mixed.efficiencies


def _choice_for_ranges(
    plan: PlanFile,
    model: PlanModel,
    candidates: Candidates,
    purpose: Purpose,
    nominal: tuple[RunInformation, Floats | None],
    repeats: Repeats,
    first: Integers | None,
) -> Choice | None:
    """Return the choice that serves the model and both ends of the prior ranges of its unknown nonlinear parameters.

    The parameters of each of these count as parameters of their own: what is worst or mean is that over all of them.
    """
    from stiffcal.planning.choice import choose_runs
    from stiffcal.planning.criterion import Criterion

    information, known = nominal
    p = len(information.names)
    factors = [information.factors]
    robots = prior_scenarios(plan, model)
    for robot in robots[1:]:
        runs = model.information(candidates, robot)
        factors.append(runs.factors * (information.scale / runs.scale))
    count = len(robots)
    blocks = factors[0] if count == 1 else _side_by_side(factors)
    is_prediction = purpose.goals[0].is_prediction
    wanted = _wanted(model, purpose, information) if is_prediction else None
    choice = choose_runs(
        blocks, purpose.n_runs, Criterion.PREDICTION if is_prediction else purpose.criterion, _repeated(known, count),
        _repeated(wanted, count), repeats, np.tile(information.nonlinear, count), first,
        np.tile(named_parameters(plan, information), count),
    )  # fmt: skip
    return None if choice is None else replace(choice, free=choice.free[:p], identified=choice.identified[:p])


def repeats_of(plan: PlanFile, candidates: Candidates) -> Repeats:
    """Return how often runs may be repeated: what refinement could turn into each other is the same run."""
    from stiffcal.planning.repeats import Repeats

    others = np.concatenate([table.reshape(len(table), -1) for table in candidates.tables[1:]], axis=1)
    _, load = np.unique(others, axis=0, return_inverse=True)
    return Repeats(plan.repeats, candidates.joints, load.ravel(), ALIKE)


def _side_by_side(factors: list[Floats]) -> Floats:
    """Return (N, k r, k p) k factors (N, r, p) of the same runs, each on parameters of its own."""
    n_runs, r, p = factors[0].shape
    blocks = np.zeros((n_runs, len(factors) * r, len(factors) * p))
    for number, block in enumerate(factors):
        blocks[:, number * r : (number + 1) * r, number * p : (number + 1) * p] = block
    return blocks


def _wanted(model: PlanModel, purpose: Purpose, information: RunInformation) -> Floats:
    return model.predictions(purpose.area.joints, purpose.area.wrench, information.scale)


def named_parameters(plan: PlanFile, information: RunInformation) -> Booleans:
    """Return (p,) True for the parameters that plan.toml names; where it names none all but nonlinear ones.

    A knee or a band is often poorly known however much is measured: it alone would decide on every run.

    Raises
    ------
    InputError : the model has no free parameter of such a name.
    """
    names = information.names
    for name in plan.parameters:
        if name not in names:
            reason = f"the model has no free parameter {name}"
            mend = f"free parameters: {', '.join(names)}"
            raise InputError.at(FaultCode.PARAMETER_UNKNOWN, PLAN_FILE, "parameters", reason, mend)
    if not plan.parameters:
        return ~information.nonlinear
    return np.array([name in plan.parameters for name in names], dtype=np.bool_)


def _repeated(matrix: Floats | None, count: int) -> Floats | None:
    """Return a matrix as often along the diagonal."""
    return None if matrix is None else np.asarray(np.kron(np.eye(count), matrix), dtype=np.float64)

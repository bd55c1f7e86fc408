"""Which runs a plan chooses, and what they would determine."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.planning.campaign.answer import answer_of, separations_of
from stiffcal.planning.campaign.candidates import candidates_of
from stiffcal.planning.campaign.choice import Purpose, chosen_runs
from stiffcal.planning.campaign.goals import WantedGoal, area_of
from stiffcal.planning.campaign.model import PlanModel
from stiffcal.planning.campaign.pairs import Candidates
from stiffcal.planning.campaign.remedies import remedies_of
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.planning.campaign.rivals import NamedRival
from stiffcal.planning.campaign.scenarios import has_nonlinear_laws
from stiffcal.stages.plans.model import rival_models
from stiffcal.stages.steps import RunContext

if TYPE_CHECKING:
    from stiffcal.planning.results import PlanResult

DEFAULT_RUNS = 12
MOST_PREDICTED = 10
"""Pairs of pose and load that show whether the loads are in newtons."""


def planned_runs(
    campaign: Campaign,
    plan: PlanFile,
    model: PlanModel,
    goals: list[WantedGoal],
    request: PlanRequest,
    named: list[NamedRival],
    context: RunContext,
) -> tuple[PlanResult, Candidates]:
    """Return the plan without ways between its runs, and the runs that could have been chosen.

    Parameters
    ----------
    campaign, plan, model : as they are planned for. goals, request : what is wanted.
    named : effects that the runs are to distinguish. context : progress and so on.

    Raises
    ------
    InputError : no pose is possible, or no possible load turns any parameter's joint.
    """
    from stiffcal.planning.criterion import Criterion
    from stiffcal.planning.information import UNLOADED_READINGS

    rivals = rival_models(named, campaign, plan, context)
    context.progress("possible poses", 0.1)
    two_sided = any(has_nonlinear_laws(entry.robot) for entry in (model, *rivals))
    candidates = candidates_of(campaign, plan, model, two_sided=two_sided)
    area = area_of(goals, campaign, plan, model, candidates)
    unloaded = sum(UNLOADED_READINGS[model.kind])
    minutes_per_run = plan.minutes_per_run + plan.minutes_per_step * (candidates.wrench.shape[1] + unloaded)
    n_runs = _number_of_runs(plan, request, minutes_per_run, model)
    criterion = Criterion(request.criterion or ("determinant" if model.absolute else "worst"))
    context.progress("choosing runs", 0.3)
    purpose = Purpose(goals, criterion, n_runs, rivals, area)
    chosen = chosen_runs(campaign, plan, model, candidates, purpose)
    context.progress("expected uncertainties", 0.8)
    result = answer_of(campaign, plan, model, chosen, purpose, minutes_per_run)
    warnings = [*area.doubts, *_load_doubts(model, candidates), *result.warnings]
    result = replace(result, candidates=len(candidates.joints), warnings=warnings)
    if rivals:
        planned = n_runs * (candidates.wrench.shape[1] + unloaded) * model.readings_per_state
        readings = max(rival.readings for rival in rivals) + planned
        result = separations_of(result, chosen.pairs, chosen.choice, named, readings)
    if result.not_identified:
        context.progress("how to identify the others", 0.85)
        remedies = remedies_of(campaign, plan, model, result.not_identified, n_runs, two_sided)
        result = replace(result, remedies=remedies)
    return result, chosen.candidates


def _load_doubts(model: PlanModel, candidates: Candidates) -> list[str]:
    """Return a warning where the loads deflect the robot as no loads of a campaign do: they are in another unit."""
    if model.kind != "load":
        return []
    from stiffcal.compensation.prediction import predict_states
    from stiffcal.compensation.table_doubts import deflection_doubts

    loads = candidates.wrench[:MOST_PREDICTED]
    largest = np.argmax(np.linalg.norm(loads[:, :, :3], axis=2), axis=1)
    wrench = loads[np.arange(len(loads)), largest]
    deflection = predict_states(model.robot, candidates.joints[:MOST_PREDICTED], wrench, model.setup).deflection
    return deflection_doubts(deflection, wrench, "the planned loads", "they are in N")


def _number_of_runs(plan: PlanFile, request: PlanRequest, minutes_per_run: float, model: PlanModel) -> int:
    if request.runs is not None:
        return request.runs
    if plan.minutes is not None:
        allowed = int((plan.minutes - plan.warm_up_minutes) / minutes_per_run)
        if allowed < 1:
            reason = f"{plan.minutes:g} min do not suffice for the warm-up and one run of {minutes_per_run:g} min"
            raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, "minutes", reason, "allow more time")
        return min(allowed, plan.runs) if plan.runs is not None else allowed
    if plan.runs is not None:
        return plan.runs
    if not model.absolute:
        return DEFAULT_RUNS
    # a place has three numbers: twice as many as there are parameters
    n_parameters = sum(len(placed_effect.effect.parameters) for placed_effect in model.robot.placed)
    return max(DEFAULT_RUNS, -(-2 * (n_parameters - len(model.fixed)) // 3))

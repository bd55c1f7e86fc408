"""Plan which poses and loads to measure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile, load_plan
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.planning.campaign.answer import answer_of, separations_of
from stiffcal.planning.campaign.candidates import candidates_of, with_ways
from stiffcal.planning.campaign.choice import Purpose, chosen_runs
from stiffcal.planning.campaign.goals import LOOK_ALIKES, WantedGoal, area_of, wanted_goals
from stiffcal.planning.campaign.means import cell_of
from stiffcal.planning.campaign.model import PlanModel, as_planned, kind_of, refuse_lifts, with_force
from stiffcal.planning.campaign.pairs import Candidates
from stiffcal.planning.campaign.program import check_program, write_program
from stiffcal.planning.campaign.remedies import remedies_of
from stiffcal.planning.campaign.rivals import NamedRival, named_rival, rivals_of_diagnosis
from stiffcal.planning.campaign.scenarios import has_nonlinear_laws
from stiffcal.report.run_sheet_files import write_sheet
from stiffcal.stages.plans.model import planned_model, rival_models
from stiffcal.stages.steps import RunContext, with_trial_model
from stiffcal.trust.output_kinds import PROGRAM, RUN_SHEET
from stiffcal.trust.outputs import check_output

if TYPE_CHECKING:
    from stiffcal.planning.results import PlanResult

DEFAULT_RUNS = 12
RUN_SHEETS = ("runs.csv", "runs.pdf")
"""Of a planned campaign folder."""
MOST_PREDICTED = 10
"""Pairs of pose and load that show whether the loads are in newtons."""


@dataclass(frozen=True)
class PlanRequest:
    """What a plan is for."""

    purpose: str = "stiffness"
    """"stiffness", "look-alikes" (of the last diagnosis), "region" (of plan.toml), a CSV of poses and loads to predict
    deflection at, or several of these with weights, as "stiffness=2, path.csv=1".
    """
    criterion: Literal["determinant", "worst"] | None = None
    """What counts for "stiffness"; None: "determinant" of absolute places, else "worst"."""
    runs: int | None = None
    """Number of runs; None: as plan.toml has it."""
    force: float | None = None
    """Largest force, N; None: as plan.toml has it."""
    sheet: Path | None = None
    """CSV, workbook or PDF file to write the run sheet to; None: nothing is written."""
    rivals: tuple[str, ...] = ()
    """Effects with their places that the runs are to distinguish, as "backlash j4"; empty: as ``purpose`` has it."""
    program: Path | None = None
    """Robot program to write, its ending states the language (`robot_programs`); None: none is written."""
    campaign: Path | None = None
    """Campaign folder to make ready for the logs; None: none is made."""


def plan_campaign(folder: Path, context: RunContext | None = None, request: PlanRequest | None = None) -> PlanResult:
    """Plan which poses and loads to measure with the means of plan.toml.

    Parameters
    ----------
    folder : a campaign folder; its logs need not exist. What was measured already counts.
    context : store, progress and so on.
    request : what the plan is for.

    Returns
    -------
    PlanResult
        The runs in the order of measuring, and the expected uncertainty of every parameter.

    Raises
    ------
    InputError : the input is wrong, no pose is possible, or no possible load turns any parameter's joint.
    """
    context, request = context or RunContext(), request or PlanRequest()
    folder = Path(folder)
    plan = load_plan(folder)
    campaign = as_planned(with_trial_model(load_campaign(folder, check_files=False), context), plan)
    refuse_lifts(campaign)
    plan = with_force(campaign, plan, request.force)
    if request.program is not None:
        check_program(request.program, campaign, kind_of(campaign, plan))
        check_output(request.program, PROGRAM, context.overwrite)
    if request.sheet is not None:
        check_output(request.sheet, RUN_SHEET, context.overwrite)
    goals = wanted_goals(request.purpose, bool(request.rivals))
    model = planned_model(campaign, plan, context)
    result, candidates = _planned(campaign, plan, model, goals, request, context)
    context.progress("moves between the runs", 0.9)
    cell = cell_of(campaign, plan)
    blocked: list[list[str]] = []
    if model.kind != "clamped":  # the way into a fixture is a person's
        runs, blocked = with_ways(campaign, cell, model, np.unique(candidates.joints, axis=0), result.runs)
        result = replace(result, runs=runs, blocked_moves=blocked)
    if blocked:
        moves = ", ".join(f"{before} to {after}" for before, after in blocked)
        text = f"no joint move avoids the boxes and stays above lowest_m: {moves}; move by hand"
        result = replace(result, warnings=[*result.warnings, text])
    if request.program is not None:
        write_program(request.program, campaign, result, cell, overwrite=context.overwrite)
        result = replace(result, program=str(request.program))
    if request.campaign is not None:
        from stiffcal.planning.campaign.folder import write_planned_campaign

        files = write_planned_campaign(request.campaign, campaign, result, request.force)
        for sheet in RUN_SHEETS:
            write_sheet(request.campaign / sheet, campaign, result)
        result = replace(result, folder=str(request.campaign), files=[*files, *RUN_SHEETS])
    if request.sheet is not None:
        write_sheet(request.sheet, campaign, result, overwrite=context.overwrite)
        result = replace(result, file=str(request.sheet))
    return result


def _planned(
    campaign: Campaign,
    plan: PlanFile,
    model: PlanModel,
    goals: list[WantedGoal],
    request: PlanRequest,
    context: RunContext,
) -> tuple[PlanResult, Candidates]:
    """Return the plan without ways between its runs, and the runs that could have been chosen."""
    from stiffcal.planning.criterion import Criterion
    from stiffcal.planning.information import UNLOADED_READINGS

    named = _named_rivals(campaign, goals, request, context)
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


def _named_rivals(
    campaign: Campaign, goals: list[WantedGoal], request: PlanRequest, context: RunContext
) -> list[NamedRival]:
    if request.rivals:
        return [named_rival(text) for text in request.rivals]
    if not any(goal.name == LOOK_ALIKES for goal in goals):
        return []
    from stiffcal.commands.diagnose import diagnose_campaign

    return rivals_of_diagnosis(diagnose_campaign(campaign.folder, context), campaign)


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

"""Plan which poses and loads to measure."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.plan_file import load_plan
from stiffcal.planning.campaign.candidates import with_ways
from stiffcal.planning.campaign.goals import LOOK_ALIKES, WantedGoal, wanted_goals
from stiffcal.planning.campaign.means import cell_of
from stiffcal.planning.campaign.model import as_planned, kind_of, refuse_lifts, with_force
from stiffcal.planning.campaign.program import check_program, write_program
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.planning.campaign.rivals import NamedRival, named_rival, rivals_of_diagnosis
from stiffcal.report.run_sheet_files import write_sheet
from stiffcal.stages.plans.model import planned_model
from stiffcal.stages.plans.runs import planned_runs
from stiffcal.stages.steps import RunContext, with_trial_model
from stiffcal.trust.output_kinds import PROGRAM, RUN_SHEET
from stiffcal.trust.outputs import check_output

if TYPE_CHECKING:
    from stiffcal.planning.results import PlanResult

RUN_SHEETS = ("runs.csv", "runs.pdf")
"""Of a planned campaign folder."""


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
    named = _named_rivals(campaign, goals, request, context)
    result, candidates = planned_runs(campaign, plan, model, goals, request, named, context)
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


def _named_rivals(
    campaign: Campaign, goals: list[WantedGoal], request: PlanRequest, context: RunContext
) -> list[NamedRival]:
    if request.rivals:
        return [named_rival(text) for text in request.rivals]
    if not any(goal.name == LOOK_ALIKES for goal in goals):
        return []
    from stiffcal.commands.diagnose import diagnose_campaign

    return rivals_of_diagnosis(diagnose_campaign(campaign.folder, context), campaign)

"""Plan which poses and loads to measure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile, load_plan
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.uncertainty import NORMAL_95
from stiffcal.workflow.plan_answer import (
    ENOUGH,
    expected_parameters,
    gain_of,
    losses_of_runs,
    runs_to_measure,
    separations_of,
    tolerances,
    warnings_of,
)
from stiffcal.workflow.plan_candidates import candidates_of, with_ways
from stiffcal.workflow.plan_choice import Purpose, chosen_runs
from stiffcal.workflow.plan_means import cell_of
from stiffcal.workflow.plan_model import (
    checked_balance,
    fixed_names,
    has_nonlinear_laws,
    planned_model,
    with_rotation,
)
from stiffcal.workflow.plan_program import check_program, write_program
from stiffcal.workflow.plan_rivals import NamedRival, named_rival, rival_models, rivals_of_diagnosis
from stiffcal.workflow.plan_sheet import check_sheet, write_sheet
from stiffcal.workflow.steps import RunContext, with_trial_model

if TYPE_CHECKING:
    from stiffcal.planning.results import PlanResult

DEFAULT_RUNS = 12
LOOK_ALIKES = "look-alikes"


@dataclass(frozen=True)
class PlanRequest:
    """What a plan is for."""

    purpose: str = "stiffness"
    """"stiffness", "look-alikes" (of the last diagnosis), or a CSV of poses and loads to predict deflection at."""
    criterion: Literal["determinant", "worst"] = "worst"
    """What counts for "stiffness"."""
    runs: int | None = None
    """Number of runs; None: as plan.toml has it."""
    force: float | None = None
    """Largest force, N; None: as plan.toml has it."""
    sheet: Path | None = None
    """CSV or PDF file to write the run sheet to; None: nothing is written."""
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
    from functools import partial

    from stiffcal.identification.geometry import geometry_columns
    from stiffcal.planning.design import Criterion
    from stiffcal.planning.expected import expected_fit
    from stiffcal.planning.information import information_of_runs, prediction_rows
    from stiffcal.planning.results import PlanResult

    context, request = context or RunContext(), request or PlanRequest()
    folder = Path(folder)
    campaign = with_trial_model(load_campaign(folder, check_files=False), context)
    _check_experiments(campaign)
    plan = load_plan(folder)
    if request.force is not None:
        plan = plan.model_copy(update={"load": plan.load.model_copy(update={"force_N": request.force})})
    if request.program is not None:
        check_program(request.program, campaign)
    if request.sheet is not None:
        check_sheet(request.sheet)
    model = planned_model(campaign, plan, context)
    named = _named_rivals(campaign, request, context)
    rivals = rival_models(named, campaign, plan, context)
    context.progress("possible poses", 0.1)
    nonlinear = any(has_nonlinear_laws(entry.robot) for entry in (model, *rivals))
    candidates = candidates_of(campaign, plan, model, two_sided=nonlinear)
    minutes_per_run = plan.minutes_per_run + plan.minutes_per_step * (candidates.wrench.shape[1] + 2)
    n_runs = _number_of_runs(plan, request, minutes_per_run)
    fixed = fixed_names(campaign)
    wanted_of, criterion = None, Criterion(request.criterion)
    if request.purpose not in ("stiffness", LOOK_ALIKES):
        from stiffcal.compensation.load_table import read_load_table

        criterion = Criterion.PREDICTION
        table = read_load_table(Path(request.purpose), campaign.chain.joint_names, joints_needed=True)

        def wanted_of(scale: Floats) -> Floats:
            return checked_balance(
                lambda: prediction_rows(model.robot, table.joints, table.wrench, model.setup, scale, fixed)
            )

    context.progress("choosing runs", 0.3)
    runs_chosen = chosen_runs(campaign, plan, model, candidates, Purpose(criterion, n_runs, rivals, wanted_of))
    choice, information, known = runs_chosen.choice, runs_chosen.information, runs_chosen.known
    n_drawn = len(candidates.joints)
    candidates, wanted = runs_chosen.candidates, runs_chosen.wanted
    separations = separations_of(runs_chosen.pairs, choice, named) if rivals else None
    context.progress("expected uncertainties", 0.8)
    chosen = choice.design.chosen
    of_chosen = information_of_runs(
        model.robot, candidates.joints[chosen], candidates.wrench[chosen], model.setup, model.noise,
        with_rotation(campaign), fixed, further=partial(geometry_columns, model.robot),
    )  # fmt: skip
    free = choice.free
    expected = expected_fit(
        of_chosen.factors[:, :, free], of_chosen.further, tolerances(campaign),
        None if known is None else known[np.ix_(free, free)],
    )  # fmt: skip
    parameters = expected_parameters(model, information, choice, expected)
    not_identified = [parameter.name for parameter in parameters if not parameter.identified]
    warnings = warnings_of(model)
    runs = runs_to_measure(candidates, choice, minutes_per_run)
    context.progress("moves between the runs", 0.9)
    cell = cell_of(campaign, plan)
    runs, blocked = with_ways(campaign, cell, model, np.unique(candidates.joints, axis=0), runs)
    if blocked:
        moves = ", ".join(f"{before} to {after}" for before, after in blocked)
        warnings.append(f"no joint move stays out of the boxes and above lowest_m: {moves}; drive by hand")
    warnings += [
        f"{entry.truth} and {entry.rival} stay alike: χ² of {entry.chi_square:.2g} where {ENOUGH:.0f} are needed"
        for entry in separations or ()
        if not entry.distinguished
    ]
    losses = losses_of_runs(choice, expected, information.names, runs)
    if losses:
        resting = "; ".join(f"{loss.parameter} on {loss.run}" for loss in losses)
        warnings.append(f"rests on one run: {resting}; measure it twice, or plan more runs")
    half_width = None
    if wanted is not None:
        mean_square = float(
            np.sum((wanted[:, choice.free] @ expected.covariance) * wanted[:, choice.free]) / (len(wanted) / 3)
        )
        half_width = NORMAL_95 * float(np.sqrt(mean_square))
    result = PlanResult(
        warnings=warnings,
        criterion="rivals" if rivals else criterion.value,
        efficiency=choice.design.efficiency,
        candidates=n_drawn,
        values_from=model.values_from,
        minutes=plan.warm_up_minutes + n_runs * minutes_per_run,
        runs=runs,
        parameters=parameters,
        blocked_moves=blocked,
        rests_on_one_run=losses,
        gain=gain_of(choice, expected, plan.warm_up_minutes, minutes_per_run),
        not_identified=not_identified,
        prediction_half_width_m=half_width,
        separations=separations,
        joint_names=campaign.chain.joint_names,
    )
    if request.program is not None:
        write_program(request.program, campaign, result, cell)
        result = replace(result, program=str(request.program))
    if request.campaign is not None:
        from stiffcal.workflow.plan_folder import write_planned_campaign

        files = write_planned_campaign(request.campaign, campaign, result)
        result = replace(result, folder=str(request.campaign), files=files)
    if request.sheet is not None:
        write_sheet(request.sheet, campaign, result)
        result = replace(result, file=str(request.sheet))
    return result


def _check_experiments(campaign: Campaign) -> None:
    """Refuse campaigns without load runs: where a fixture clamps the robot or its own weight is the load.

    Raises
    ------
    InputError : the campaign has runs, and none is a load run.
    """
    kinds = {run.experiment for run in campaign.manifest.runs}
    if kinds and "load" not in kinds:
        reason = f"plan chooses poses and loads of load runs, and all runs here are {' or '.join(sorted(kinds))} runs"
        mend = 'plan in a campaign whose runs have experiment = "load", or leave [[runs]] out'
        raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, "campaign.toml", "runs", reason, mend)


def _named_rivals(campaign: Campaign, request: PlanRequest, context: RunContext) -> list[NamedRival]:
    if request.rivals:
        return [named_rival(text) for text in request.rivals]
    if request.purpose != LOOK_ALIKES:
        return []
    from stiffcal.workflow.diagnose import diagnose_campaign

    return rivals_of_diagnosis(diagnose_campaign(campaign.folder, context), campaign)


def _number_of_runs(plan: PlanFile, request: PlanRequest, minutes_per_run: float) -> int:
    if request.runs is not None:
        return request.runs
    if plan.minutes is not None:
        allowed = int((plan.minutes - plan.warm_up_minutes) / minutes_per_run)
        if allowed < 1:
            reason = f"{plan.minutes:g} min do not suffice for the warm-up and one run of {minutes_per_run:g} min"
            raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, "minutes", reason, "allow more time")
        return min(allowed, plan.runs) if plan.runs is not None else allowed
    return plan.runs if plan.runs is not None else DEFAULT_RUNS

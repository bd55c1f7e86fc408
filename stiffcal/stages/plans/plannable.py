"""Whether a plan can be made: asked before it is proposed as the next step."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.plan_file import PlanFile, load_plan
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.planning.campaign.candidates import candidates_of
from stiffcal.planning.campaign.model import PlanModel, as_planned, kind_of, refuse_lifts, with_force
from stiffcal.planning.campaign.scenarios import has_nonlinear_laws
from stiffcal.stages.plans.model import planned_model
from stiffcal.stages.steps import RunContext

# Poses that the question is asked of: what some of them identify, all candidates identify.
ASKED = 30


def plannable_words(folder: Path, force: float, context: RunContext) -> tuple[str, ...] | None:
    """Return the options with which `plan` proposes runs of a campaign; None where it refuses.

    No log is read for it: what was measured counts where it is fitted already.

    Parameters
    ----------
    folder : the campaign folder.
    force : N, the largest that was applied so far, for what plan.toml leaves open.
    context : with the store.

    Raises
    ------
    InputError : the folder holds no campaign.
    """
    from stiffcal.planning.choice import identifiable

    campaign = load_campaign(folder, check_files=False)
    try:
        plan = load_plan(folder)
        words = _force_words(plan, force) if kind_of(campaign, plan) == "load" else ()
        plan = with_force(campaign, plan, float(words[1]) if words else None)
        plan = plan.model_copy(update={"candidates": min(plan.candidates, ASKED)})
        campaign = as_planned(campaign, plan)
        refuse_lifts(campaign)
        model = _planned_model(campaign, plan, replace(context, update=False))
        candidates = candidates_of(campaign, plan, model, two_sided=has_nonlinear_laws(model.robot))
        information = model.information(candidates)
    except InputError:
        return None
    return words if identifiable(information.factors, None, information.nonlinear)[1].any() else None


def _planned_model(campaign: Campaign, plan: PlanFile, context: RunContext) -> PlanModel:
    try:
        return planned_model(campaign, plan, context)
    except InputError as error:
        if error.code is not FaultCode.STORE_OUTDATED:
            raise
    return planned_model(campaign, plan, None)


def _force_words(plan: PlanFile, force: float) -> tuple[str, ...]:
    """Return the option that states the largest force, where plan.toml states no load."""
    load = plan.load
    is_stated = load.force_N is not None or bool(load.dead_weights_kg)
    return () if is_stated or force < 1.0 else ("--force", f"{force:.0f}")

"""The robot that a plan is made for, as its fit knows it, and the same with each rival model."""

from __future__ import annotations

from dataclasses import replace

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.model.model_file import model_of_text
from stiffcal.campaign.plan_file import PlanFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.model.catalogue.campaign_effects import effects_with
from stiffcal.model.editing import model_with
from stiffcal.model.summary import Where
from stiffcal.planning.campaign.model import PlanModel, plan_model_of, robot_to_plan
from stiffcal.planning.campaign.rivals import NamedRival
from stiffcal.stages.plans.measured import measured_so_far
from stiffcal.stages.steps import RunContext, TrialModel, ignore_note, model_text, with_trial_model


def planned_model(campaign: Campaign, plan: PlanFile, context: RunContext | None) -> PlanModel:
    """Return the robot with values: fitted where there are logs, else of model.toml, else typical ones.

    Parameters
    ----------
    context : store, progress and so on; None: as if nothing was measured.

    Raises
    ------
    InputError : the model is empty, its noise is not known, or a frame is not.
    """
    robot = robot_to_plan(campaign)
    measured = None if context is None else measured_so_far(campaign, robot, context)
    return plan_model_of(campaign, plan, robot, measured)


def rival_models(rivals: list[NamedRival], campaign: Campaign, plan: PlanFile, context: RunContext) -> list[PlanModel]:
    """Return the model with each rival in turn, fitted where there are logs.

    Raises
    ------
    InputError : an effect or a place does not exist, or the model holds it already.
    """
    if not rivals:
        return []
    from stiffcal.store.trial import TrialResults

    text = context.trial.text if context.trial is not None else model_text(campaign)
    models = []
    for rival in rivals:
        try:
            with_rival = model_with(campaign, text, rival.effect, where=rival.where, curved=False)
        except InputError as error:
            # the place stands in the words of --tell: the options of `add` that an edit names are none of `plan`
            if error.code is not FaultCode.PLACE_INVALID:
                raise
            effect = effects_with(campaign, rival.effect)[rival.effect]
            places = ", ".join(place.label for place in effect.places(campaign.chain)) or "none on this robot"
            mend = f'write effect and place, as "{rival.effect} {places.partition(",")[0]}"; possible: {places}'
            reason = f"not a place of {rival.effect}" if rival.where != Where() else f"{rival.effect} has no place"
            raise InputError.at(FaultCode.PLACE_INVALID, "--tell", rival.label, reason, mend) from None
        trial = TrialModel(with_rival, model_of_text(with_rival, campaign.chain.n_joints), TrialResults())
        tried = replace(context, trial=trial, notify=ignore_note)
        models.append(planned_model(with_trial_model(campaign, tried), plan, tried))
    return models

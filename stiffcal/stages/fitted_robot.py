"""A campaign's robot with values, for the commands that use the model: predict, map, compensate, plan, export."""

from __future__ import annotations

from stiffcal.campaign.loading import Campaign
from stiffcal.compensation.fitted_robot import FittedRobot, robot_of_fit, robot_of_model_file, robot_with_effects
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states, with_trial_model


def fitted_robot(campaign: Campaign, context: RunContext) -> FittedRobot:
    """Return the fitted robot; where there are no logs, the robot as its model file values it.

    Raises
    ------
    InputError : nothing is measured, and a parameter has no value.
    """
    from stiffcal.ingest.sources import manifest_data_files

    campaign = with_trial_model(campaign, context)
    robot = robot_with_effects(campaign)
    if not all((campaign.folder / file).exists() for file in manifest_data_files(campaign)):
        return robot_of_model_file(campaign, robot)
    data = up_to_date_states(campaign.folder, context)
    return robot_of_fit(campaign, robot, data.states.setup, up_to_date_fit(data, context))

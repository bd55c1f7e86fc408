"""The place of `fitted_robot` in version 0.1."""

from stiffcal.deprecated_names import old_names

__getattr__ = old_names(
    __name__,
    {
        "valued_campaign": "stiffcal.workflow.fitted_robot.fitted_robot",
        "ValuedCampaign": "stiffcal.workflow.fitted_robot.FittedRobot",
    },
)

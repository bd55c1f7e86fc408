"""Friction of the drives: joints driven to and fro in the air, their torque read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.experiments import ExperimentKind

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.experiments.measured import MeasuredRuns
    from stiffcal.experiments.reduction import RunsReduction
    from stiffcal.experiments.results import ExperimentFit, ExperimentValidation


class FrictionKind(ExperimentKind):
    """Friction of each drive over its speed."""

    def reduction(self, campaign: Campaign) -> RunsReduction:
        """Collect the logs of this kind's runs."""
        from stiffcal.experiments.friction.reduction import FrictionRunsReduction

        return FrictionRunsReduction(campaign)

    def fit(self, data: MeasuredRuns) -> ExperimentFit | None:
        """Fit the friction of every drive that the model gives friction and that friction runs have moved."""
        from stiffcal.experiments.friction.parts import friction_experiment_fit

        return friction_experiment_fit(data)

    def validate(self, data: MeasuredRuns) -> ExperimentValidation | None:
        """Judge friction at speeds that the fit does not rest on."""
        from stiffcal.experiments.friction.parts import friction_validation

        return friction_validation(data)


KIND = FrictionKind(
    "friction", default_model=Path(__file__).with_name("default_model.toml"), tables=("friction", "free_motion")
)

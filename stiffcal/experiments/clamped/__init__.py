"""The clamped robot: a fixture holds the flange, one motor after the other is driven, and torque is read over angle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.experiments import ExperimentKind

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.experiments.measured import MeasuredRuns
    from stiffcal.experiments.reduction import RunsReduction
    from stiffcal.experiments.results import ExperimentFit, ExperimentValidation


class ClampedKind(ExperimentKind):
    """Play, friction and torque over angle of each joint that was driven against the fixture."""

    def reduction(self, campaign: Campaign) -> RunsReduction:
        """Collect the logs of this kind's runs."""
        from stiffcal.experiments.clamped.reduction import ClampedReduction

        return ClampedReduction(campaign)

    def fit(self, data: MeasuredRuns) -> ExperimentFit | None:
        """Identify every joint that was driven against the fixture."""
        from stiffcal.experiments.clamped.parts import clamped_experiment_fit

        return clamped_experiment_fit(data)

    def validate(self, data: MeasuredRuns) -> ExperimentValidation | None:
        """Judge each joint in a pose that its law does not rest on."""
        from stiffcal.experiments.clamped.parts import clamped_validation

        return clamped_validation(data)


KIND = ClampedKind("clamped", tables=("clamped",), holds_flange=True)

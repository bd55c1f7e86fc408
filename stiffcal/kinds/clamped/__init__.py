"""The clamped robot: a fixture holds the flange, one motor after the other is driven, and torque is read over angle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.kinds import ExperimentKind
from stiffcal.measurements.state_measures import StateMeasure

if TYPE_CHECKING:
    from collections.abc import Mapping

    from stiffcal.campaign.loading import Campaign
    from stiffcal.identification.readings.state_kinds import StateKind
    from stiffcal.kinds.clamped.answers.results import ClampedSection
    from stiffcal.kinds.clamped.simulated.simulation_settings import Clamping
    from stiffcal.kinds.measured import MeasuredRuns
    from stiffcal.kinds.reduction import RunsReduction
    from stiffcal.kinds.results import ExperimentFit, ExperimentValidation, IdentifiedModel
    from stiffcal.model.assembled.composite import CompliantRobot
    from stiffcal.presentation.values import Overview, Page, Plot, Table
    from stiffcal.simulation.kinds import RunSimulation
    from stiffcal.store.declared_table import DeclaredTable


class ClampedKind(ExperimentKind):
    """Play, friction and torque over angle of each joint that was driven against the fixture."""

    def reduction(self, campaign: Campaign) -> RunsReduction:
        """Collect the logs of this kind's runs."""
        from stiffcal.kinds.clamped.reduction import ClampedReduction

        return ClampedReduction(campaign)

    def declared_tables(self) -> tuple[DeclaredTable, ...]:
        """Return the readings and the averaged branches."""
        from stiffcal.kinds.clamped.tables import TABLES

        return TABLES

    def simulation(self) -> RunSimulation[Clamping]:
        """Simulate the runs of this kind."""
        from stiffcal.kinds.clamped.simulated.simulation import ClampedSimulation

        return ClampedSimulation()

    def fit(self, data: MeasuredRuns) -> ExperimentFit | None:
        """Describe every joint that was driven against the fixture."""
        from stiffcal.kinds.clamped.answers.parts import clamped_experiment_fit

        return clamped_experiment_fit(data)

    def starting_values(self, data: MeasuredRuns, robot: CompliantRobot) -> Mapping[str, float]:
        """Return shapes of curves, from torque over angle."""
        from stiffcal.kinds.clamped.answers.parts import starting_values

        return starting_values(data, robot)

    def section_type(self) -> type[object]:
        """Return the type of the section in ``identify``."""
        from stiffcal.kinds.clamped.answers.results import ClampedSection

        return ClampedSection

    def validate(self, data: MeasuredRuns) -> ExperimentValidation | None:
        """Return why nothing is judged, where nothing is."""
        from stiffcal.kinds.clamped.answers.parts import clamped_validation

        return clamped_validation(data)

    def state_kind(self) -> StateKind:
        """Return motor angles, left out by run or cycle."""
        from stiffcal.kinds.clamped.states.state_kind import ClampedStateKind

        return ClampedStateKind()

    def overview(self, identified: IdentifiedModel) -> Overview | None:
        """Return play, friction and reversal error joint by joint."""
        section = _section(identified)
        if section is None:
            return None
        from stiffcal.kinds.clamped.answers.page import clamped_overview

        return clamped_overview(section)

    def main_table(self, identified: IdentifiedModel) -> Table | None:
        """Return the leading table of the overview."""
        section = _section(identified)
        if section is None:
            return None
        from stiffcal.kinds.clamped.answers.page import clamped_main_table

        return clamped_main_table(section)

    def page(self, data: MeasuredRuns, identified: IdentifiedModel) -> Page | None:
        """Return definitions, tables and pictures."""
        section = _section(identified)
        if section is None:
            return None
        from stiffcal.kinds.clamped.answers.page import clamped_page

        return clamped_page(data, section)

    def plot(self, data: MeasuredRuns, identified: IdentifiedModel, run: str | None, joint: str | None) -> Plot:
        """Return torque over angle."""
        from stiffcal.kinds.clamped.answers.page import clamped_plot

        return clamped_plot(data, _section(identified), run)


def _section(identified: IdentifiedModel) -> ClampedSection | None:
    from stiffcal.kinds.clamped.answers.results import ClampedSection

    section = identified.section("clamped")
    return section if isinstance(section, ClampedSection) else None


KIND = ClampedKind(
    "clamped",
    tables=("clamped",),
    fit_tables=("clamped_branches",),
    measures=StateMeasure.MOTOR_ANGLE,
    run_keys=("moved_joint", "fixture_compliance"),
    why_not_diagnosed="too few readings per run for load states; log at a higher rate",
    plots_runs=True,
)

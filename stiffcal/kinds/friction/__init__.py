"""Friction of the drives: joints driven to and fro in the air, their torque read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.kinds import ExperimentKind

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.kinds.drawn_rows import DrawnRows, DrawnVariable
    from stiffcal.kinds.friction.answers.results import FrictionSection
    from stiffcal.kinds.friction.simulated.simulation_settings import FrictionMotion
    from stiffcal.kinds.measured import MeasuredRuns
    from stiffcal.kinds.reduction import RunsReduction
    from stiffcal.kinds.results import ExperimentFit, ExperimentValidation, IdentifiedModel
    from stiffcal.kinds.row_search import RowProblem
    from stiffcal.model.effect import Effect
    from stiffcal.presentation.values import Overview, Page, Plot
    from stiffcal.simulation.kinds import RunSimulation
    from stiffcal.store.declared_table import DeclaredTable


class FrictionKind(ExperimentKind):
    """Friction of each drive over its speed."""

    def reduction(self, campaign: Campaign) -> RunsReduction:
        """Collect the logs of this kind's runs."""
        from stiffcal.kinds.friction.reduction import FrictionRunsReduction

        return FrictionRunsReduction(campaign)

    def declared_tables(self) -> tuple[DeclaredTable, ...]:
        """Return the passes, the free motion and the fitted rows."""
        from stiffcal.kinds.friction.tables import TABLES

        return TABLES

    def simulation(self) -> RunSimulation[FrictionMotion]:
        """Simulate the runs of this kind."""
        from stiffcal.kinds.friction.simulated.simulation import FrictionSimulation

        return FrictionSimulation()

    def fit(self, data: MeasuredRuns) -> ExperimentFit | None:
        """Fit the friction of every drive that the model gives friction and that friction runs have moved."""
        from stiffcal.kinds.friction.answers.parts import friction_experiment_fit

        return friction_experiment_fit(data)

    def section_type(self) -> type[object]:
        """Return the type of the section in ``identify``."""
        from stiffcal.kinds.friction.answers.results import FrictionSection

        return FrictionSection

    def validate(self, data: MeasuredRuns) -> ExperimentValidation | None:
        """Judge friction at speeds that the fit does not rest on."""
        from stiffcal.kinds.friction.answers.parts import friction_validation

        return friction_validation(data)

    def drawn_rows(self, data: MeasuredRuns, identified: IdentifiedModel) -> DrawnRows | None:
        """Return the torque of each bin of passes, or sample of other motion."""
        from stiffcal.kinds.friction.answers.drawn import drawn_friction

        return drawn_friction(data, identified)

    def driver(self, data: MeasuredRuns, effect: Effect, joint: int) -> DrawnVariable | None:
        """Return what an effect of a moving joint follows; NaN in the rows of other joints."""
        from stiffcal.kinds.friction.answers.drawn import driver_of_rows

        return driver_of_rows(data, effect, joint)

    def problems(self, data: MeasuredRuns) -> tuple[RowProblem, ...]:
        """Return the joints' rows."""
        from stiffcal.kinds.friction.answers.parts import problems_of

        return problems_of(data)

    def overview(self, identified: IdentifiedModel) -> Overview | None:
        """Return coulomb, viscous and Stribeck terms joint by joint."""
        section = _section(identified)
        if section is None:
            return None
        from stiffcal.kinds.friction.answers.page import friction_overview

        return friction_overview(section, identified)

    def page(self, data: MeasuredRuns, identified: IdentifiedModel) -> Page | None:
        """Return the law, its parameters and the curves."""
        section = _section(identified)
        if section is None:
            return None
        from stiffcal.kinds.friction.answers.page import friction_page

        return friction_page(data, section, identified)

    def plot(self, data: MeasuredRuns, identified: IdentifiedModel, run: str | None, joint: str | None) -> Plot:
        """Return friction over speed."""
        from stiffcal.kinds.friction.answers.page import friction_plot

        return friction_plot(data, _section(identified), identified, joint)


def _section(identified: IdentifiedModel) -> FrictionSection | None:
    from stiffcal.kinds.friction.answers.results import FrictionSection

    section = identified.section("friction")
    return section if isinstance(section, FrictionSection) else None


KIND = FrictionKind(
    "friction",
    default_model=Path(__file__).with_name("default_model.toml"),
    tables=("friction", "friction_samples", "free_motion"),
    fit_tables=("friction_fit", "friction_heldout"),
    kept_tables=("friction_fit", "friction_heldout"),
    measures=None,
    run_keys=("moved_joint",),
    plot_axis="velocity",
)

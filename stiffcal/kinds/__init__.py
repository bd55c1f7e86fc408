"""The kinds of experiment, and how they are found.

In a load campaign wrench and joint angles are known and the deflection is measured; of a clamped robot one knows its
(zero) motion and measures the reaction; a drive in free motion shows its friction. A kind is one folder here, named as
in ``experiment = "clamped"`` of a run, with one `ExperimentKind` called ``KIND``. It is found by walking this folder:
nothing else has to be edited for the manifest, its JSON Schema, the default model and every command to know it.

What a kind answers are plain values: results, rows, tables, sentences. Load states have rooms of their own below and
above this one; of them and of absolute places the kind has simulation, folds and words (`state_kind.py`) alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from stiffcal.campaign.found.experiment_kinds import KnownKind, experiment_kind, kind_names
from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.presentation.values import Table

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.identification.readings.state_kinds import StateKind
    from stiffcal.kinds.drawn_rows import DrawnRows, DrawnVariable
    from stiffcal.kinds.measured import MeasuredRuns
    from stiffcal.kinds.reduction import RunsReduction
    from stiffcal.kinds.results import ExperimentFit, ExperimentValidation, IdentifiedModel
    from stiffcal.kinds.row_search import RowProblem
    from stiffcal.model.assembled.composite import CompliantRobot
    from stiffcal.model.effect import Effect
    from stiffcal.presentation.values import Overview, Page, Plot
    from stiffcal.simulation.kinds import RunSimulation
    from stiffcal.store.declared_table import DeclaredTable


@dataclass(frozen=True)
class ExperimentKind:
    """What stiffcal asks of a kind of experiment; a kind with runs of its own overrides the methods.

    Why methods that import what they need: the manifest asks for the name alone, and numpy would cost its start-up.
    """

    name: str
    """The folder's."""
    options: type[TomlTable] | None = None
    """The table of options of a run, under the kind's name; None where a run has no keys of the kind's own."""
    default_model: Path | None = None
    """The model file of campaigns of this kind alone that have none; None: compliant drives."""
    tables: tuple[str, ...] = ()
    """The tables of the store that are made of this kind's logs, none where its runs make load states alone."""
    fit_tables: tuple[str, ...] = ()
    """The tables of the store that `fit` and `validate` make."""
    kept_tables: tuple[str, ...] = ()
    """Those of them that stay in the store for every fit of the history, to be drawn again."""
    measures: StateMeasure | None = StateMeasure.DISPLACEMENT
    """What is measured in the load states of its runs: angles of motors where a fixture holds the flange; None where
    they make no load states."""
    run_keys: tuple[str, ...] = ()
    """Which of the keys of a run that only some kinds read (moved_joint, fixture_compliance, approach) it reads. A kind
    with a moved joint measures torque over its turn."""
    why_not_diagnosed: str = "runs of this kind make neither load states nor rows in which effects are searched for"
    """Why ``diagnose`` has nothing to search in where that is so."""
    plot_axis: str = ""
    """What ``plot --against`` calls this kind's picture, for one joint as in ``velocity:2``; "": nothing."""
    plots_runs: bool = False
    """Whether ``plot --run`` draws one run of this kind."""

    def reduction(self, campaign: Campaign) -> RunsReduction | None:
        """Return the reduction of the logs of this kind's runs; None where they make load states like any other."""
        return None

    def declared_tables(self) -> tuple[DeclaredTable, ...]:
        """Return what the tables of this kind hold; of one that is not declared its writer alone decides."""
        return ()

    def simulation(self) -> RunSimulation[Any] | None:
        """Return the simulation of the runs of this kind; None where these are load cycles."""
        return None

    def state_kind(self) -> StateKind:
        """Return what is to be known of load states that runs of this kind make; those of load runs by default."""
        return cast("StateKind", cast(KnownKind, experiment_kind("load")).state_kind())

    def fit(self, data: MeasuredRuns) -> ExperimentFit | None:
        """Return the part of ``identify`` for the runs of this kind; None where the campaign holds none.

        Raises
        ------
        InputError
            Nothing can be fitted to them.
        """
        return None

    def starting_values(self, data: MeasuredRuns, robot: CompliantRobot) -> Mapping[str, float]:
        """Return values, by full name, from which the fit of load states starts where the model gives none.

        Parameters
        ----------
        data : the campaign, with the tables of logs. robot : the model.
        """
        return {}

    def section_type(self) -> type[object] | None:
        """Return the type of the section that `fit` adds to ``identify``; None where the kind answers nothing."""
        return None

    def validate(self, data: MeasuredRuns) -> ExperimentValidation | None:
        """Return the part of ``validate`` for the runs of this kind; None where there is nothing to judge.

        Raises
        ------
        InputError
            Nothing can be fitted to them.
        """
        return None

    def problems(self, data: MeasuredRuns) -> tuple[RowProblem, ...]:
        """Return the rows in which ``diagnose`` looks for missing effects; none where load states hold all readings."""
        return ()

    def drawn_rows(self, data: MeasuredRuns, identified: IdentifiedModel) -> DrawnRows | None:
        """Return the rows that the page for a browser draws; None where load states hold all readings.

        Parameters
        ----------
        data : the campaign, with the tables of logs and of the fit.
        identified : the result of ``identify``.
        """
        return None

    def driver(self, data: MeasuredRuns, effect: Effect, joint: int) -> DrawnVariable | None:
        """Return what an effect at a joint follows, over the rows of `drawn_rows`; None where it does not act in them.

        Parameters
        ----------
        data : the campaign, with the tables of logs. effect : of the catalogue. joint : from 1.
        """
        return None

    def basic_effects(self) -> tuple[str, ...]:
        """Return the names of the effects that a model of this kind begins with, and that are never superfluous."""
        if self.default_model is None:
            return ()
        from stiffcal.campaign.toml.toml_reading import read_toml

        document = read_toml(self.default_model, self.default_model.name)
        return tuple(effect["type"] for effect in document.get("effects", ()))

    def overview(self, identified: IdentifiedModel) -> Overview | None:
        """Return the overview that ``identify`` prints in the terminal; None where it holds nothing of this kind."""
        return None

    def main_table(self, identified: IdentifiedModel) -> Table | None:
        """Return the leading table of the overview; None where there is none."""
        overview = self.overview(identified)
        tables = [] if overview is None else [block for block in overview.blocks if isinstance(block, Table)]
        return tables[0] if tables else None

    def page(self, data: MeasuredRuns, identified: IdentifiedModel) -> Page | None:
        """Return the page of the report; None where the campaign holds nothing of this kind.

        Parameters
        ----------
        data : the campaign, with the tables of logs and of the fit.
        identified : the result of ``identify``.
        """
        return None

    def plot(self, data: MeasuredRuns, identified: IdentifiedModel, run: str | None, joint: str | None) -> Plot | None:
        """Return the picture that ``plot`` draws; None where this kind has none.

        Parameters
        ----------
        data : the campaign, with the tables of logs and of the fit.
        identified : the result of ``identify``.
        run, joint : the only one to draw, by its name; None: all.

        Raises
        ------
        InputError
            There is nothing to draw.
        """
        return None


def all_kinds() -> tuple[ExperimentKind, ...]:
    """Return all kinds of experiment, sorted by name.

    Examples
    --------
    >>> {"clamped", "free", "friction", "load"} <= {kind.name for kind in all_kinds()}
    True
    """
    return tuple(cast(ExperimentKind, experiment_kind(name)) for name in kind_names())


def section_types() -> dict[str, type[object]]:
    """Return the types of the sections that kinds of experiment add to ``identify``, by the kind's name.

    Examples
    --------
    >>> {"clamped", "friction"} <= set(section_types())
    True
    """
    types = {kind.name: kind.section_type() for kind in all_kinds()}
    return {name: of_kind for name, of_kind in types.items() if of_kind is not None}


def tables_of_logs() -> tuple[str, ...]:
    """Return the names of the tables that kinds of experiment make of their logs.

    Examples
    --------
    >>> {"clamped", "friction", "free_motion"} <= set(tables_of_logs())
    True
    """
    return tuple(name for kind in all_kinds() for name in kind.tables)


def tables_kept() -> tuple[str, ...]:
    """Return the names of the tables that stay in the store for every fit of the history."""
    return tuple(name for kind in all_kinds() for name in kind.kept_tables)


def tables_of_fits() -> tuple[str, ...]:
    """Return the names of the tables that kinds of experiment make of their fits.

    Examples
    --------
    >>> {"clamped_branches", "friction_fit"} <= set(tables_of_fits())
    True
    """
    return tuple(name for kind in all_kinds() for name in kind.fit_tables)

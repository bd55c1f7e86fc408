"""Forecasts: every candidate is tried once about the present fit, and any choice of them is one linear step."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa

from stiffcal.diagnosis.of_rows.row_candidates import row_candidates
from stiffcal.diagnosis.of_rows.row_forecast import forecast_row_residual
from stiffcal.diagnosis.of_rows.row_scan import RowScan, scan_row_candidates
from stiffcal.diagnosis.refits.forecast import forecast_residual
from stiffcal.diagnosis.refits.refits import Refit, RefitSummary
from stiffcal.diagnosis.scans.candidates import Candidate, list_candidates
from stiffcal.diagnosis.scans.load_scan import LoadGround
from stiffcal.diagnosis.scans.scan import Trial, refine_nonlinear, try_candidate
from stiffcal.diagnosis.thresholds import MANY_ROW_SHAPES
from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem
from stiffcal.judgement.row_document import too_few_folds
from stiffcal.kinds import all_kinds
from stiffcal.measurements.columns import table_of
from stiffcal.measurements.rms import Rms
from stiffcal.model.assembled.assembly import fixed_parameters
from stiffcal.model.catalogue.campaign_effects import all_effects
from stiffcal.model.summary import Where
from stiffcal.stages.diagnoses.stored_curves import refit_columns, row_refit_columns
from stiffcal.stages.experiments import robot_to_fit, runs_with_fits
from stiffcal.validation.heldout import validation_folds
from stiffcal.validation.validate import rms_of
from stiffcal.view.content import ViewForecast, ViewModel
from stiffcal.view.gathering.models import tables_of_states
from stiffcal.view.gathering.rows import tables_of_rows

if TYPE_CHECKING:
    from stiffcal.arrays import Floats, Integers
    from stiffcal.diagnosis.scans.base_rows import BaseRows
    from stiffcal.errors import Progress
    from stiffcal.identification.readings.observations import Observations
    from stiffcal.kinds import ExperimentKind
    from stiffcal.kinds.drawn_rows import DrawnRows
    from stiffcal.kinds.row_search import RowProblem
    from stiffcal.live.choice import ModelChoice
    from stiffcal.model.assembled.composite import PlacedEffect
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.stages.steps import Ingested, RunContext
    from stiffcal.view.content import ViewContent


@dataclass(frozen=True, kw_only=True)
class Forecasted(ABC):
    """Readings that share parameters with each other, and the candidates about their fit."""

    candidates: dict[str, Candidate]
    """What can be added, by ``effect place``."""
    placed: dict[str, PlacedEffect]
    """What can be taken out, by ``effect place``."""
    trials: dict[str, Trial | None] = field(default_factory=dict)
    """What was tried; None of a candidate that does not show."""

    def trial(self, name: str) -> Trial | None:
        """Return a candidate in the shape that is best alone, tried now where it was not before."""
        if name not in self.trials:
            tried = self._try_one(self.candidates[name])
            self.trials[name] = None if tried is None else refine_nonlinear(tried, self._rows)
        return self.trials[name]

    @property
    @abstractmethod
    def _rows(self) -> BaseRows:
        """The model's rows."""

    @abstractmethod
    def _try_one(self, candidate: Candidate) -> Trial | None:
        """Try a candidate."""

    @abstractmethod
    def residual(self, added: Sequence[Trial], removed: Collection[PlacedEffect]) -> Floats | None:
        """Return the residuals in held-out data after one step; None where it cannot be one."""

    def is_touched(self, choice: ModelChoice) -> bool:
        """Return whether a choice changes the model of these readings."""
        return not (self.candidates.keys().isdisjoint(choice.added) and self.placed.keys().isdisjoint(choice.removed))

    def of_choice(self, choice: ModelChoice) -> Floats | None:
        """Return the residuals in held-out data after one step, of what a choice changes of these readings."""
        added, removed = choice.added, choice.removed
        trials = [self.trial(name) for name in added if name in self.candidates]
        known = [trial for trial in trials if trial is not None]
        return self.residual(known, [self.placed[name] for name in removed if name in self.placed])


@dataclass(frozen=True, kw_only=True)
class ForecastedStates(Forecasted):
    """All load states: clamped drives too share what holds the robot, and are fitted together."""

    ground: LoadGround
    fold: Integers
    """(n,) what is left out with each state, as `validate` does."""

    @classmethod
    def of(cls, data: Ingested, loss: str, progress: Progress) -> ForecastedStates:
        """Fit the model of model.toml again, with all that a candidate needs."""
        robot = robot_to_fit(data)
        settings = Settings(loss=loss, fixed=fixed_parameters(data.campaign.model))
        fit = fit_observations(fit_problem(data.states, robot), robot, settings, progress)
        progress("preparing forecasts", 0.5)
        catalogue, _ = all_effects(data.campaign)
        listed, _ = list_candidates(fit.robot, data.states, catalogue)
        ground = LoadGround.of(fit)
        free = {column.placed for column in ground.scan.fit.columns}
        placed = {_name(one): one for number, one in enumerate(fit.robot.placed) if number in free}
        _, fold = validation_folds(fit.data)
        candidates = {candidate.name: candidate for candidate in listed}
        return cls(candidates=candidates, placed=placed, ground=ground, fold=fold)

    @property
    def observations(self) -> Observations:
        """The readings."""
        return self.ground.scan.fit.data

    @property
    def _rows(self) -> BaseRows:
        return self.ground.rows

    def _try_one(self, candidate: Candidate) -> Trial | None:
        return self.ground.try_one(candidate)

    def residual(self, added: Sequence[Trial], removed: Collection[PlacedEffect]) -> Floats | None:
        """Return (m, n) m and rad."""
        names = {_name(one) for one in removed}
        numbers = [k for k, one in enumerate(self.ground.scan.fit.robot.placed) if _name(one) in names]
        return forecast_residual(self.ground.scan, added, numbers, self.fold)


@dataclass(frozen=True, kw_only=True)
class ForecastedRows(Forecasted):
    """Rows of one problem: torque over motion of a joint."""

    problem: RowProblem
    scan: RowScan

    @classmethod
    def of(cls, kind: ExperimentKind, problem: RowProblem, data: Ingested) -> ForecastedRows | None:
        """Fit the rows; None where too little can be left out."""
        fit = problem.fit(problem.robot)
        if too_few_folds(problem, fit) is not None:
            return None
        catalogue, _ = all_effects(data.campaign)
        listed, _ = row_candidates(problem, fit.robot, catalogue, kind.basic_effects())
        names = set(fit.names)
        return cls(
            candidates={candidate.name: candidate for candidate in listed},
            placed={
                _name(one): one
                for one in fit.robot.placed
                if not names.isdisjoint(one.parameter_name(spec.symbol) for spec in one.effect.parameters)
            },
            problem=problem,
            scan=scan_row_candidates(fit, []),
        )

    @property
    def _rows(self) -> BaseRows:
        return self.scan.ground

    def _try_one(self, candidate: Candidate) -> Trial | None:
        return try_candidate(candidate, self.scan.ground, MANY_ROW_SHAPES)

    def residual(self, added: Sequence[Trial], removed: Collection[PlacedEffect]) -> Floats | None:
        """Return (k,) SI."""
        return forecast_row_residual(self.scan, added, removed)


@dataclass(frozen=True, kw_only=True)
class _StatesOnPage:
    """Load states as the page draws them."""

    parts: list[ForecastedStates]
    data: Ingested
    width: int
    """Columns of residuals that the page draws."""
    of_motors: bool
    """Whether the page draws the moved motor's angle."""
    pick: Integers
    """States that it draws."""

    def model(self, choice: ModelChoice) -> ViewModel | None:
        (part,) = self.parts
        residual = part.of_choice(choice) if part.is_touched(choice) else None
        if residual is None:
            return None
        columns = refit_columns(self.data.states, part.observations, [_refit(residual)], part.observations.index)
        tables = tables_of_states(self.data, self.width, self.of_motors)
        drawn = tables.of_refit(pa.table(table_of(columns)))[self.pick]
        return _model(choice, Rms.of(rms_of(residual, part.observations)), drawn)


@dataclass(frozen=True, kw_only=True)
class _RowsOnPage:
    """Rows of a kind of experiment as the page draws them."""

    parts: list[ForecastedRows]
    rows: DrawnRows
    present: Floats | None
    """(n, 3) what the present fit leaves of each, on the rows that no step touches; None where it is not stored."""
    pick: Integers
    """Rows that it draws."""

    @classmethod
    def of(cls, data: Ingested, identified: IdentifyResult, pick: Integers) -> _RowsOnPage | None:
        """Prepare the first kind with rows, which the page draws; None where too little can be left out."""
        measured = runs_with_fits(data)
        for kind in all_kinds():
            rows = kind.drawn_rows(measured, identified)
            if rows is None:
                continue
            made = [ForecastedRows.of(kind, problem, data) for problem in kind.problems(measured)]
            parts = [part for part in made if part is not None]
            tables, stored = tables_of_rows(rows), data.store.tables
            present = tables.of_heldout(data.store.read_table(tables.heldout)) if tables.heldout in stored else None
            return cls(parts=parts, rows=rows, present=present, pick=pick) if parts else None
        return None

    def model(self, choice: ModelChoice) -> ViewModel | None:
        touched = [part for part in self.parts if part.is_touched(choice)]
        left = [(part, part.of_choice(choice)) for part in (touched if self.present is not None else self.parts)]
        found = [(part, residual) for part, residual in left if residual is not None]
        if not touched or len(found) < len(left):
            return None
        columns = row_refit_columns(
            [_refit(np.concatenate([residual for _, residual in found])[None])],
            [np.concatenate([part.problem.index for part, _ in found])],
        )
        whole = tables_of_rows(self.rows).of_refit(pa.table(columns))
        whole = whole if self.present is None else np.where(np.isnan(whole), self.present, whole)
        size = float(np.sqrt(np.nanmean(whole[self.rows.judged, 0] ** 2)))
        measure = self.parts[0].problem.measure
        return _model(choice, Rms.of({"translation": None, "rotation": None, measure: size}), whole[self.pick])


@dataclass(frozen=True)
class Forecasts:
    """All readings of a campaign, in the order of the page's parts."""

    pages: list[_StatesOnPage | _RowsOnPage]
    key: str
    """Of the fit about which they are."""

    @classmethod
    def of(cls, data: Ingested, identified: IdentifyResult, content: ViewContent, context: RunContext) -> Forecasts:
        """Prepare forecasts about the fit of model.toml.

        Parameters
        ----------
        data : the campaign. identified : the fit of model.toml. content : what the page draws of it.
        context : progress.

        Raises
        ------
        InputError : the data hold no more readings than the model has values.
        """
        pages: list[_StatesOnPage | _RowsOnPage] = []
        of_rows: ViewContent | None = content
        if len(data.states):
            of_rows = next(iter(content.others), None)
        if len(data.states) and content.states is not None:
            pages.append(
                _StatesOnPage(
                    parts=[ForecastedStates.of(data, identified.loss, context.progress)],
                    data=data,
                    width=content.states.measured.shape[1],
                    of_motors=content.measure == "motor_angle",
                    pick=content.states.index,
                )
            )
        if of_rows is not None and of_rows.states is not None:
            context.progress("preparing forecasts", 0.6)
            page = _RowsOnPage.of(data, identified, of_rows.states.index)
            pages += [] if page is None else [page]
        return cls(pages, identified.key)

    def try_each(self, names: Sequence[str], progress: Progress) -> None:
        """Try candidates, so that their forecasts are there at once; what was tried stays where this is interrupted."""
        for number, name in enumerate(names):
            progress("preparing forecasts", 0.7 + 0.3 * number / max(len(names), 1))
            for part in self._parts:
                if name in part.candidates:
                    part.trial(name)

    def forecast(self, choice: ModelChoice) -> ViewForecast | None:
        """Return what a choice leaves by one linear step; None where it holds what cannot be one."""
        parts = self._parts
        added = all(any(name in part.candidates for part in parts) for name in choice.added)
        removed = all(any(name in part.placed for part in parts) for name in choice.removed)
        if not added or not removed:
            return None
        models = [page.model(choice) for page in self.pages]
        return ViewForecast(models=models) if any(model is not None for model in models) else None

    @property
    def _parts(self) -> list[Forecasted]:
        return [part for page in self.pages for part in page.parts]


def _name(placed: PlacedEffect) -> str:
    return f"{placed.effect.name} {placed.place.label}"


def _refit(residual: Floats) -> Refit:
    summary = RefitSummary(change="with", effect="", where=Where(), heldout_rms=Rms(None, None), values=[])
    return Refit(summary, residual)


def _model(choice: ModelChoice, rms: Rms, drawn: Floats) -> ViewModel:
    return ViewModel(
        id="forecast",
        kind="with",
        label=f"forecast: {choice.label}",
        short="forecast",
        heldout_rms=rms,
        residual_heldout=drawn,
    )

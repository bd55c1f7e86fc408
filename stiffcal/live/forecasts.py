"""Forecasts of load states: every candidate is tried once about the present fit, and any choice of them is one step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa

from stiffcal.diagnosis.drive_parts import drive_parts
from stiffcal.diagnosis.forecast import forecast_residual
from stiffcal.diagnosis.load_search_context import LoadSearchContext
from stiffcal.diagnosis.refits import Refit, RefitSummary
from stiffcal.diagnosis.scan import Trial
from stiffcal.identification.identify import Settings, fit_problem
from stiffcal.measurements.columns import table_of
from stiffcal.measurements.rms import Rms
from stiffcal.model.assembly import fixed_parameters
from stiffcal.model.campaign_effects import all_effects
from stiffcal.model.summary import Where
from stiffcal.validation.heldout import validation_folds
from stiffcal.validation.validate import rms_of
from stiffcal.view.content import ViewModel
from stiffcal.workflow.evidence import refit_columns
from stiffcal.workflow.experiments import robot_to_fit
from stiffcal.workflow.view_models import tables_of_states

if TYPE_CHECKING:
    from stiffcal.arrays import Integers
    from stiffcal.diagnosis.load_scan import LoadScan
    from stiffcal.live.choice import ModelChoice
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.workflow.steps import Ingested, RunContext


@dataclass(frozen=True)
class Forecasts:
    """The candidates about the fit of model.toml."""

    data: Ingested
    """The campaign."""
    scan: LoadScan
    """The candidates."""
    trials: dict[str, Trial]
    """By ``effect place``."""
    fold: Integers
    """(n,) what is left out with each state, as `validate` does."""
    pick: Integers
    """States that the page draws."""

    @classmethod
    def of(cls, data: Ingested, identified: IdentifyResult, pick: Integers, context: RunContext) -> Forecasts | None:
        """Try all candidates; None of campaigns without load states, and where each drive is searched by itself.

        Parameters
        ----------
        data : the campaign. identified : the fit of model.toml. pick : states that the page draws. context : progress.

        Raises
        ------
        InputError : the data hold no more readings than the model has values.
        """
        if len(data.states) == 0:
            return None
        robot = robot_to_fit(data)
        values = {entry.name: entry.value for entry in identified.parameters if entry.value is not None}
        if drive_parts(data.states, robot, values):
            return None
        catalogue, _ = all_effects(data.campaign)
        settings = Settings(loss=identified.loss, fixed=fixed_parameters(data.campaign.model))
        context.progress("testing every effect at every place", 0.1)
        scan = LoadSearchContext(data.states, fit_problem(data.states, robot), catalogue, settings).look(robot)
        trials = {f"{trial.candidate.effect.name} {trial.candidate.place.label}": trial for trial in scan.trials}
        _, fold = validation_folds(scan.fit.data)
        return cls(data, scan, trials, fold, pick)

    def model(self, choice: ModelChoice) -> ViewModel | None:
        """Return what a choice leaves by one linear step; None where it holds what was not tried."""
        placed = [f"{one.effect.name} {one.place.label}" for one in self.scan.fit.robot.placed]
        if not {*choice.added} <= {*self.trials} or not {*choice.removed} <= {*placed}:
            return None
        added = [self.trials[name] for name in choice.added]
        residual = forecast_residual(self.scan, added, [placed.index(name) for name in choice.removed], self.fold)
        if residual is None:
            return None
        observations = self.scan.fit.data
        rms = Rms.of(rms_of(residual, observations))
        refit = Refit(RefitSummary(change="with", effect="", where=Where(), heldout_rms=rms, values=[]), residual)
        columns = refit_columns(self.data.states, observations, [refit], observations.index)
        width = 6 if np.isfinite(self.data.states.rotation).any() else 3
        tables = tables_of_states(self.data, width, False)
        return ViewModel(
            id="forecast",
            kind="with",
            label=f"forecast: {choice.label}",
            short="forecast",
            heldout_rms=rms,
            residual_heldout=tables.of_refit(pa.table(table_of(columns)))[self.pick],
        )

"""What a model of rows would leave with one more effect, or with one fewer: refitted, row by row."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.diagnosis.of_rows.row_errors import left_out_residual, rms_of_rows
from stiffcal.diagnosis.of_rows.row_forecast import forecast_row_residual
from stiffcal.diagnosis.of_rows.row_scan import RowScan
from stiffcal.diagnosis.refits.refit_values import RefitValue, refit_values
from stiffcal.diagnosis.refits.refits import Refit, RefitSummary, refit_with_all, refitted_candidates
from stiffcal.diagnosis.scans.lack_of_fit import fitted_values
from stiffcal.diagnosis.scans.scan import Trial
from stiffcal.kinds.row_search import RowProblem
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.summary import Where


def row_refits_of(
    scan: RowScan, with_all: RowScan | None, problem: RowProblem, diagnosis: DiagnoseResult
) -> Iterator[Refit]:
    """Refit the present model of rows as `refits_of` does that of load states.

    Parameters
    ----------
    scan : of the present model. with_all : of the model with all that is missing; None where nothing is.
    problem : the rows. diagnosis : what is missing.

    Yields
    ------
    Refit
        As `refits_of`; the residual is (1, k).
    """
    if with_all is not None:
        residual = left_out_residual(with_all, None)
        yield Refit(refit_with_all(diagnosis, rms_of_rows(residual, problem)), residual[None])
    leading = refitted_candidates(diagnosis)
    places = [(trial.candidate.effect.name, Where.of(trial.candidate.place)) for trial in scan.trials]
    for trial in (scan.trials[places.index(place)] for place in leading if place in places):
        residual = left_out_residual(scan, trial)
        summary = RefitSummary(
            change="with",
            effect=trial.candidate.effect.name,
            where=Where.of(trial.candidate.place),
            heldout_rms=rms_of_rows(residual, problem),
            values=_values_with(scan, trial),
        )
        yield Refit(summary, residual[None])
    for placed in scan.fit.robot.placed:
        left = forecast_row_residual(scan, removed=[placed])
        if left is not None:
            summary = RefitSummary(
                change="without",
                effect=placed.effect.name,
                where=Where.of(placed.place),
                heldout_rms=rms_of_rows(left, problem),
                values=[],
            )
            yield Refit(summary, left[None])


def _values_with(scan: RowScan, trial: Trial) -> list[RefitValue]:
    """Return the parameters' values, the candidate's among them, as the scan found them with all rows."""
    values = dict(scan.fit.robot.values())
    for name, step in zip(scan.fit.names, trial.score.solution, strict=False):
        values[name] = values[name] + float(step)
    robot = scan.fit.robot.with_values(values)
    added = PlacedEffect(trial.candidate.effect, trial.candidate.place, fitted_values(trial))
    return refit_values(replace(robot, placed=(*robot.placed, added)), scan, trial, scan.fit.names)

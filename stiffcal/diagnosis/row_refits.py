"""What a model of rows would leave with one more effect, or with one fewer: refitted, row by row."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.folds import fold_products
from stiffcal.diagnosis.judge import fitted_values
from stiffcal.diagnosis.normal_equations import solve_within
from stiffcal.diagnosis.refit_values import RefitValue, refit_values
from stiffcal.diagnosis.refits import Refit, RefitSummary, refit_with_all, refitted_candidates
from stiffcal.diagnosis.results import DiagnoseResult
from stiffcal.diagnosis.row_document import RowSearch, free_of_constants, left_out_residual, rms_of_rows
from stiffcal.diagnosis.row_scan import RowScan
from stiffcal.diagnosis.scan import Trial
from stiffcal.experiments.row_search import RowProblem
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import ParameterRole
from stiffcal.model.summary import Where


def row_refits_of(search: RowSearch, problem: RowProblem, diagnosis: DiagnoseResult) -> Iterator[Refit]:
    """Refit the present model of rows as `refits_of` does that of load states.

    Parameters
    ----------
    search : that was made. problem : its rows.
    diagnosis : its result.

    Yields
    ------
    Refit
        As `refits_of`; the residual is (1, k).
    """
    scan = search.first
    if search.found:
        residual = left_out_residual(search.final_scan, None)
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
        left = _without(scan, placed)
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


def _without(scan: RowScan, placed: PlacedEffect) -> Floats | None:
    """Return (k,) residuals with each fold left out, without one of the model's effects; None where it has no column.

    What else is fitted with the parameters (weight, inertia) is fitted again.
    """
    fit, columns = scan.fit, scan.columns[:, 0]
    own = {placed.parameter_name(spec.symbol): spec for spec in placed.effect.parameters}
    mine = np.zeros(len(columns), dtype=np.bool_)
    mine[: len(fit.names)] = [name in own for name in fit.names]
    if not mine.any():
        return None
    residual, values = scan.residual[0].copy(), fit.robot.values()
    for name, column in zip(fit.names, columns, strict=False):
        if name in own and own[name].role is not ParameterRole.NONLINEAR:
            residual += values.get(name, 0.0) * column
    others = columns[~mine]
    if len(others):
        rows = np.concatenate([scan.space.rows(others[:, None]), scan.space.rows(residual[None, None])])
        products = fold_products(rows, list(scan.folds))
        rest = products.sum(axis=0) - products if len(products) > 1 else products
        low, high = (side[~mine] for side in scan.bounds)
        step = solve_within(rest[:, :-1, :-1], rest[:, :-1, -1], low, high)
        for number, members in enumerate(scan.folds):
            residual[members] -= step[number] @ others[:, members]
    return free_of_constants(scan, residual)

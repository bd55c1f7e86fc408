"""What a change of a model of rows is going to leave, by one linear step about the present fit."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.of_rows.row_errors import free_of_constants
from stiffcal.diagnosis.of_rows.row_scan import RowScan
from stiffcal.diagnosis.scans.base_rows import bounds_of_candidate
from stiffcal.diagnosis.scans.scan import Trial
from stiffcal.estimation.leave_out import LeaveOut
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import ParameterRole
from stiffcal.model.parameters import ParameterSpec


def forecast_row_residual(
    scan: RowScan, added: Sequence[Trial] = (), removed: Collection[PlacedEffect] = ()
) -> Floats | None:
    """Return (k,) residuals in held-out data with candidates added and effects of the model taken out, SI.

    What is fitted with the parameters (weight, inertia) is fitted again.

    Parameters
    ----------
    scan : of the present model.
    added : candidates, each in the shape that was best alone.
    removed : effects of ``scan.fit.robot.placed``.

    Returns
    -------
    array or None
        None where an effect is removed that has no free parameter: the fit holds it as it is.
    """
    fit, columns = scan.fit, scan.columns[:, 0]
    own: dict[str, ParameterSpec] = {}
    for placed in removed:
        specs = {placed.parameter_name(spec.symbol): spec for spec in placed.effect.parameters}
        if specs.keys().isdisjoint(fit.names):
            return None
        own |= specs
    kept = np.ones(len(columns), dtype=np.bool_)
    kept[: len(fit.names)] = [name not in own for name in fit.names]
    residual, values = scan.residual[0].copy(), fit.robot.values()
    for name, column in zip(fit.names, columns, strict=False):
        if name in own and own[name].role is not ParameterRole.NONLINEAR:
            residual += values.get(name, 0.0) * column
    low, high = (side[kept] for side in scan.bounds)
    pieces = [columns[kept]]
    for trial in added:
        pieces.append(trial.regressor.columns[:, 0])
        residual -= trial.regressor.fixed[0]
        lowest, highest = bounds_of_candidate(trial.regressor)
        low, high = np.append(low, lowest), np.append(high, highest)
    others = np.concatenate(pieces)
    rows = scan.space.rows(np.concatenate([others, residual[None]])[:, None])
    problem = LeaveOut(rows, scan.folds, np.zeros((0, len(rows))), low, high)
    # a single fold is all there is: what is left of it is that of the fit
    steps = problem.steps if len(scan.folds) > 1 else problem.solution[None]
    for step, members in zip(steps, scan.folds, strict=True):
        residual[members] -= step @ others[:, members]
    return free_of_constants(scan, residual)

"""What a change of a model of rows is going to leave, by one linear step about the present fit."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.base_rows import bounds_of_candidate
from stiffcal.diagnosis.folds import fold_products
from stiffcal.diagnosis.normal_equations import solve_within
from stiffcal.diagnosis.row_errors import free_of_constants
from stiffcal.diagnosis.row_scan import RowScan
from stiffcal.diagnosis.scan import Trial
from stiffcal.model.composite import PlacedEffect
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
    if len(others):
        rows = np.concatenate([scan.space.rows(others[:, None]), scan.space.rows(residual[None, None])])
        products = fold_products(rows, list(scan.folds))
        rest = products.sum(axis=0) - products if len(products) > 1 else products
        step = solve_within(rest[:, :-1, :-1], rest[:, :-1, -1], low, high)
        for number, members in enumerate(scan.folds):
            residual[members] -= step[number] @ others[:, members]
    return free_of_constants(scan, residual)

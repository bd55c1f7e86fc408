"""What a change of the model is going to leave, by one linear step about the present fit: before anything is fitted."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.base_rows import amplitude_bounds
from stiffcal.diagnosis.folds import fold_products
from stiffcal.diagnosis.load_scan import LoadScan, fold_rows
from stiffcal.diagnosis.normal_equations import solve_within
from stiffcal.diagnosis.scan import Trial
from stiffcal.identification.observation import ParameterColumn, free_columns
from stiffcal.identification.regressors import Linearised
from stiffcal.measurements.load_states import members_of
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import ParameterRole
from stiffcal.validation.heldout import corrected_for_freedom


def forecast_residual(
    scan: LoadScan, added: Sequence[Trial] = (), removed: Collection[int] = (), fold: Integers | None = None
) -> Floats | None:
    """Return (m, n) m and rad, residuals in held-out data with candidates added and effects of the model taken out.

    Parameters
    ----------
    scan : of the present model.
    added : candidates of the scan, each in the shape that was best alone.
    removed : numbers of effects in ``scan.fit.robot.placed``.
    fold : (n,) number of what is left out with each state; None: the poses of the scan.

    Returns
    -------
    array or None
        None where effects are removed of which one has no free parameter: the fit holds it as it is.
    """
    own = scan_columns(scan)
    if not {column.placed for column in own} >= set(removed):
        return None
    kept = np.array([column.placed not in removed for column in own], dtype=np.bool_)
    low = np.array([lowest_step(scan.fit.robot.placed[column.placed], column) for column in own])[kept]
    high = np.full(len(low), np.inf)
    pieces, rows, residual = [scan.own_columns[kept]], [scan.own_rows[kept]], scan.residual.copy()
    if removed:
        state = scan.source.state()
        for number in removed:
            residual += contribution_of(state, scan.fit.robot.placed[number])
    for trial in added:
        regressor = trial.regressor
        columns = regressor.columns
        pieces.append(columns)
        rows.append(scan.space.rows(columns))
        residual -= regressor.fixed
        lowest, highest = amplitude_bounds(regressor)
        low, high = np.append(low, lowest), np.append(high, highest)
    return _left_out(scan, np.concatenate(pieces), np.concatenate(rows), residual, low, high, fold)


def scan_columns(scan: LoadScan) -> list[ParameterColumn]:
    """Return the free parameters of the present model, in the order of the scan's own columns."""
    fixed = frozenset(scan.fit.left_at_neutral | {entry.name for entry in scan.fit.parameters if entry.fixed})
    return free_columns(scan.fit.robot, fixed)


def contribution_of(state: Linearised, placed_effect: PlacedEffect) -> Floats:
    """Return (m, n) what an effect adds to the displacements with the values it has in the model."""
    regressor = state.regressor(placed_effect.effect, placed_effect.place, placed_effect.shape())
    total = regressor.fixed.copy()
    for symbol, column in zip(regressor.symbols, regressor.columns, strict=True):
        total += placed_effect.amplitude(symbol) * column
    return np.asarray(np.where(state.data.measured_mask, total, 0.0))


def lowest_step(placed_effect: PlacedEffect, column: ParameterColumn) -> float:
    """Return how far down a parameter can go from where it is: what cannot be negative stops at zero."""
    spec = placed_effect.effect.spec(column.symbol)
    if column.role is ParameterRole.AMPLITUDE and (spec.inverse or spec.lower == 0.0):
        return min(0.0, -placed_effect.amplitude(column.symbol))
    return -np.inf


def heldout_residual(
    scan: LoadScan, columns: Floats, residual: Floats, low: Floats, high: Floats, fold: Integers | None = None
) -> Floats:
    """Return (m, n) residuals, each fold (by default each pose) by a fit without it, its run's offset taken out.

    Parameters
    ----------
    columns : (k, m, n) of what is fitted. residual : (m, n) before it.
    low, high : (k,) how far each can go.
    fold : (n,) number of what is left out with each state; None: the poses of the scan.
    """
    return _left_out(scan, columns, scan.space.rows(columns), residual, low, high, fold)


def _left_out(
    scan: LoadScan, columns: Floats, rows: Floats, residual: Floats, low: Floats, high: Floats, fold: Integers | None
) -> Floats:
    """Return the same where the columns' whitened rows (k, m · n) are known."""
    remaining, fold = residual.copy(), scan.fold_of_state if fold is None else fold
    if len(columns):
        products = fold_products(
            np.concatenate([rows, scan.space.rows(residual[None])]), fold_rows(scan.fit.data, fold)
        )
        rest = products.sum(axis=0) - products if len(products) > 1 else products
        step = solve_within(rest[:, :-1, :-1], rest[:, :-1, -1], low, high)
        for number, members in enumerate(members_of(fold)):
            remaining[:, members] -= np.tensordot(step[number], columns[:, :, members], axes=1)
    return corrected_for_freedom(scan.space.centred(remaining[None])[0], scan.fit.data)

"""What a change of the model is going to leave, by one linear step about the present fit: before anything is fitted."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.scans.base_rows import bounds_of_candidate
from stiffcal.diagnosis.scans.load_scan import LoadScan, fold_rows
from stiffcal.diagnosis.scans.scan import Trial
from stiffcal.estimation.leave_out import LeaveOut
from stiffcal.estimation.unknowns import bounds_of
from stiffcal.identification.fitting.regressors import Linearised, Regressor
from stiffcal.measurements.load_states import members_of
from stiffcal.model.assembled.composite import PlacedEffect
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
    own = scan.fit.columns
    if not {column.placed for column in own} >= set(removed):
        return None
    kept = np.array([column.placed not in removed for column in own], dtype=np.bool_)
    low, high = (bound[: len(own)][kept] for bound in scan.bounds)
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
        # those of the refit that is forecast
        lowest, highest = bounds_of([regressor.effect.spec(symbol) for symbol in regressor.symbols])
        low, high = np.append(low, lowest), np.append(high, highest)
    known = scan.known_before(kept, len(low))
    return _left_out(scan, np.concatenate(pieces), np.concatenate(rows), residual, (low, high), known, fold)


def contribution_of(state: Linearised, placed_effect: PlacedEffect) -> Floats:
    """Return (m, n) what an effect adds to the displacements with the values it has in the model."""
    regressor = state.regressor(placed_effect.effect, placed_effect.place, placed_effect.shape())
    total = regressor.fixed.copy()
    for symbol, column in zip(regressor.symbols, regressor.columns, strict=True):
        total += placed_effect.amplitude(symbol) * column
    return np.asarray(np.where(state.data.measured_mask, total, 0.0))


def heldout_residual(
    scan: LoadScan,
    kept: Booleans,
    more: Sequence[Regressor],
    residual: Floats,
    fold: Integers | None = None,
) -> Floats:
    """Return (m, n) residuals, each fold (by default each pose) by a fit without it, its run's offset taken out.

    Parameters
    ----------
    kept : (p,) which of the model's own parameters are fitted.
    more : effects that are fitted with them. residual : (m, n) before all that.
    fold : (n,) number of what is left out with each state; None: the poses of the scan.
    """
    columns = np.concatenate([scan.own_columns[kept], *(regressor.columns for regressor in more)])
    edges = [[bound[: len(kept)][kept] for bound in scan.bounds], *map(bounds_of_candidate, more)]
    low, high = (np.concatenate(side) for side in zip(*edges, strict=True))
    known = scan.known_before(kept, len(columns))
    return _left_out(scan, columns, scan.space.rows(columns), residual, (low, high), known, fold)


def _left_out(
    scan: LoadScan,
    columns: Floats,
    rows: Floats,
    residual: Floats,
    bounds: tuple[Floats, Floats],
    known: Floats,
    fold: Integers | None,
) -> Floats:
    """Return the same where the columns' whitened rows (k, m · n), bounds and what is known before are at hand."""
    remaining, fold = residual.copy(), scan.fold_of_state if fold is None else fold
    white = np.concatenate([rows, scan.space.rows(residual[None])])
    problem = LeaveOut(white, fold_rows(scan.fit.data, fold), known, *bounds)
    # a single fold is all there is: what is left of it is that of the fit
    steps = problem.steps if len(problem.folds) > 1 else problem.solution[None]
    for step, members in zip(steps, members_of(fold), strict=True):
        remaining[:, members] -= np.tensordot(step, columns[:, :, members], axes=1)
    return corrected_for_freedom(scan.space.centred(remaining[None])[0], scan.fit.data)

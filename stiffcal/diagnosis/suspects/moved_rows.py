"""What a fit leaves of absolute places, in the order in which they were measured, and the mistake that shows in it."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.readings.row_layout import ROTATION, TRANSLATION
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.found import mistakes_of
from stiffcal.mistakes.places.mistake import LeftOfPlaces, MovedRows, PlacesMistake
from stiffcal.mistakes.places.steps import orthonormal


def moved_rows(fit: Fit, states: LoadStates) -> tuple[PlacesMistake, MovedRows] | None:
    """Return the first mistake that the rows of absolute runs show, and where; None where they show none.

    Parameters
    ----------
    fit : of the present model to these states.
    states : the campaign's states, runs in the order of the manifest.
    """
    left = left_of_places(fit, states)
    if left is None:
        return None
    return next(((mistake, moved) for mistake in mistakes_of(PlacesMistake) for moved in mistake.ways(left)), None)


def left_of_places(fit: Fit, states: LoadStates) -> LeftOfPlaces | None:
    """Return what a fit leaves of the absolute rows; None where there are none, or their noise is not known."""
    data = fit.data
    rows = np.flatnonzero(data.absolute & data.measured_mask.any(axis=0))
    if fit.whitening is None or not len(rows):
        return None
    rows = rows[_as_measured(states, data.index[rows])]
    about = fit.linearised()
    model = about.derivative
    stack = np.concatenate([model, _rigid_motions(states, fit), fit.residual[None]])
    # load runs show nothing of the tracker's place, and keep the model's parameters where they are
    others = np.setdiff1d(np.arange(data.n_states), rows)
    white = about.space.rows(stack).reshape(stack.shape)[:, :, np.append(others, rows)]
    basis = orthonormal(white[: len(model)].reshape(len(model), -1).T).reshape(*white.shape[1:], -1)
    return LeftOfPlaces(
        residual=white[-1],
        motion=np.moveaxis(white[len(model) : -1], 0, -1),
        basis=basis,
        first=len(others),
        index=data.index[rows],
        n_states=len(states),
        dof=fit.dof,
    )


def _as_measured(states: LoadStates, index: Integers) -> Integers:
    """Return the order in which rows were measured: run after run as in the manifest, by time within each.

    The runs' clocks may each start at zero, so that times of two runs are not compared.
    """
    names = [run.of or run.name for run in states.runs]
    run = np.array([names.index(name) for name in names])[states.run[index]]
    time = states.time[index]
    return np.asarray(np.lexsort((time, run)) if np.isfinite(time).all() else np.argsort(run, kind="stable"))


def _rigid_motions(states: LoadStates, fit: Fit) -> Floats:
    """Return (6, m, n) what a shift and a turn about the places' centre make in the rows: m per m and per rad."""
    data = fit.data
    position = np.moveaxis(states.position[data.index], 0, -1)
    centre = np.nanmean(position[:, :, data.absolute], axis=(0, 2))
    result = np.zeros((6, len(data.measured), data.n_states))
    for row, (kind, body, component) in enumerate(zip(data.kind, data.body, data.component, strict=True)):
        axis = int(component) % 3
        if kind == TRANSLATION:
            lever = np.nan_to_num(position[body] - centre[:, None])
            result[axis, row] = 1.0
            result[3 + (axis + 1) % 3, row] = lever[(axis + 2) % 3]
            result[3 + (axis + 2) % 3, row] = -lever[(axis + 1) % 3]
        elif kind == ROTATION:
            result[3 + axis, row] = 1.0
    return np.where(data.absolute, result, 0.0)

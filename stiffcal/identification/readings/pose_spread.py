"""How far each pose is known, next to the usual one: by the points that it comes from, or as its log states.

Where poses are read and nothing is stated row by row there is no such thing: every one errs alike, displacement and
turn apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.readings.row_layout import ROTATION, TRANSLATION, RowLayout
from stiffcal.measurements.load_states import LoadStates


@dataclass(frozen=True)
class PoseSpread:
    """Covariance of the rows of n states per unit of noise: σ_t² translation + σ_r² rotation."""

    translation: Floats
    """(m, n) on the diagonal; 1 where a place was read or all points were measured, 0 but for displacements."""
    rotation: Floats
    """(m, m, n); the unit matrix of the turns' rows where a pose was read."""

    def subset(self, pick: slice | Booleans | Integers) -> PoseSpread:
        """Return that of some states."""
        return PoseSpread(self.translation[:, pick], self.rotation[:, :, pick])

    def rows(self, pick: Booleans) -> PoseSpread:
        """Return that of some rows."""
        return PoseSpread(self.translation[pick], self.rotation[pick][:, pick])


def pose_spread(states: LoadStates, layout: RowLayout) -> PoseSpread | None:
    """Return the uncertainty of all load states' poses; None where all poses are read and err alike.

    Parameters
    ----------
    states : all load states.
    layout : what the rows are.
    """
    by_row = bool(np.isfinite(states.sigma).any())
    if not any(states.setup.markers) and not by_row:
        return None
    m, n = len(layout.kind), len(states)
    translation = np.repeat((layout.kind == TRANSLATION).astype(np.float64)[:, None], n, axis=1)
    rotation = np.zeros((m, m, n))
    turns = np.flatnonzero(layout.kind == ROTATION)
    rotation[turns, turns] = 1.0
    for b, markers in enumerate(states.setup.markers):
        if markers is None:
            continue
        share, covariance = markers.spread(states.markers_measured[:, b, : len(markers.names)], states.rotation[:, b])
        pose_rows = np.flatnonzero((layout.body == b) & np.isin(layout.kind, (TRANSLATION, ROTATION)))
        component = layout.component[pose_rows]
        translation[pose_rows] = np.where(component[:, None] < 3, share, 0.0)
        rotation[np.ix_(pose_rows, pose_rows)] = np.moveaxis(covariance[:, component][:, :, component], 0, -1)
    spread = PoseSpread(translation, rotation)
    return _scaled_by_row(spread, states, layout) if by_row else spread


def _scaled_by_row(spread: PoseSpread, states: LoadStates, layout: RowLayout) -> PoseSpread:
    """Scale the covariance by what each state's uncertainty is of the usual one, as the log states it row by row."""
    m, n = len(layout.kind), len(states)
    size = np.ones((m, n))
    stated = states.setup.sigma
    usual_sizes = (
        (TRANSLATION, stated.translation, stated.absolute_translation),
        (ROTATION, stated.rotation, stated.absolute_rotation),
    )
    for kind, of_loads, of_places in usual_sizes:
        usual = np.where(states.absolute, of_places or of_loads or np.nan, of_loads or np.nan)
        for row in np.flatnonzero(layout.kind == kind):
            own = states.sigma[:, layout.body[row], layout.component[row]]
            size[row] = np.where(np.isfinite(own / usual), own / usual, 1.0)
    rotation = spread.rotation * size[:, None] * size[None]
    return PoseSpread(spread.translation * size**2, rotation)

"""How far each pose is known by the points that it comes from: what stands next to the noise of a pose with all points.

Where poses are read there is no such thing: every one errs alike, displacement and turn apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.rows import ROTATION, TRANSLATION, RowLayout
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
    """Return the uncertainty of all load states' poses; None where no pose comes from points.

    Parameters
    ----------
    states : all load states.
    layout : what the rows are.
    """
    if not any(states.setup.markers):
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
    return PoseSpread(translation, rotation)

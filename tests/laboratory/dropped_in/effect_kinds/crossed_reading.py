"""A reading in which one axis shows in another."""

from __future__ import annotations

import numpy as np

from stiffcal.effects_api import Floats, Instrument, Observed, ParameterSpec, Place, Values


class CrossedReading(Instrument):
    """The tracker's y reads a share of what its x moves by: Δy = share Δx.

    Law: what is read along y is the displacement along y and that share of x.
    """

    name = "crossed-reading"
    place_kind = "setup"
    summary = "y reads a share of x"
    parameters = (ParameterSpec("share", "1", "share of x in y", -0.5, 0.5, 0.01, "made up for a test"),)

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return what a share of one adds."""
        column = np.zeros_like(observed.displacement)
        column[:, 1] = observed.displacement[:, 0]
        return {"share": column}

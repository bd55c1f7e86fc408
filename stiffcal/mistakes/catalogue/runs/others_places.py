"""A run with the places of another one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.runs.others import OthersReadings
from stiffcal.mistakes.suspect_kinds import SuspectKind


class OthersPlaces(OthersReadings):
    """The places or displacements that belong to the run are another run's."""

    name = "others-places"
    kind = SuspectKind.EXCHANGED
    rank = 32
    things = "places or displacements"
    mend = "the tracker logs are interchanged; correct the file names"

    def readings(self, states: LoadStates) -> Mapping[str, Any]:
        """Return what was measured of the target; NaN where that was set aside."""
        used = states.used[:, None, None]
        return {
            "position": np.where(used, states.position, np.nan),
            "rotation": np.where(used[..., None], states.rotation, np.nan),
            "deflection": np.where(used, states.deflection, np.nan),
        }

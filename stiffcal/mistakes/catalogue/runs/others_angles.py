"""A run with the joint angles of another one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.runs.others import OthersReadings
from stiffcal.mistakes.suspect_kinds import SuspectKind


class OthersAngles(OthersReadings):
    """The joint angles that belong to the run are another run's."""

    name = "others-angles"
    kind = SuspectKind.MISLABELLED
    rank = 30
    things = "joint angles"
    mend = "the two are mixed up; correct the angles, or leave the run out"

    def readings(self, states: LoadStates) -> Mapping[str, Any]:
        """Return the angles."""
        return {"joints": states.joints}

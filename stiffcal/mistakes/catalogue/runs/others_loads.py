"""A run with the loads of another one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.runs.others import OthersReadings
from stiffcal.mistakes.suspect_kinds import SuspectKind


class OthersLoads(OthersReadings):
    """The loads that belong to the run are another run's."""

    name = "others-loads"
    kind = SuspectKind.EXCHANGED
    rank = 31
    things = "loads"
    mend = "the force logs are interchanged; interchange them back"

    def readings(self, states: LoadStates) -> Mapping[str, Any]:
        """Return the loads."""
        return {"wrench": states.wrench}

"""A joint that is pressed against a stop: the states of clamped runs, without a description of each curve."""

from __future__ import annotations

import pyarrow as pa

from stiffcal.campaign.loading import Campaign
from stiffcal.identification.readings.state_kinds import StateKind
from stiffcal.kinds import ExperimentKind
from stiffcal.kinds.clamped.reduction import ClampedReduction
from stiffcal.kinds.clamped.states.state_kind import ClampedStateKind
from stiffcal.kinds.reduction import RunsReduction
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.store.provenance import IngestSettings


class PressedReduction(ClampedReduction):
    """Load states alone."""

    def tables(self, settings: IngestSettings) -> dict[str, pa.Table]:
        """Return none."""
        return {}


class PressedStateKind(ClampedStateKind):
    """Angles of pressed motors."""

    name = "pressed"
    runs = "pressed runs"


class PressedKind(ExperimentKind):
    """Runs against a stop."""

    def reduction(self, campaign: Campaign) -> RunsReduction:
        """Collect the states."""
        return PressedReduction(campaign)

    def state_kind(self) -> StateKind:
        """Return motor angles, left out by run or cycle."""
        return PressedStateKind()


KIND = PressedKind("pressed", measures=StateMeasure.MOTOR_ANGLE, run_keys=("moved_joint",))

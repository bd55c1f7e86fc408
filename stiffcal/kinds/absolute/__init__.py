"""Absolute places: joint angles and where a target is in the tracker's frame, each pose once.

The states are those of load campaigns, one run per row; logs go through `stiffcal.reduction` as theirs do. Measured and
predicted are both counted from where the robot file has the target. What stands here is simulation and folds.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.kinds import ExperimentKind
from stiffcal.measurements.state_measures import StateMeasure

if TYPE_CHECKING:
    from stiffcal.identification.readings.state_kinds import StateKind
    from stiffcal.kinds.absolute.simulation_settings import AbsolutePoses
    from stiffcal.simulation.kinds import RunSimulation


class AbsoluteKind(ExperimentKind):
    """Runs of places, each pose once."""

    def simulation(self) -> RunSimulation[AbsolutePoses]:
        """Return the simulation of random poses."""
        from stiffcal.kinds.absolute.simulation import AbsoluteSimulation

        return AbsoluteSimulation()

    def state_kind(self) -> StateKind:
        """Return places, left out by region."""
        from stiffcal.kinds.absolute.state_kind import AbsoluteStateKind

        return AbsoluteStateKind()


KIND = AbsoluteKind(
    "absolute",
    default_model=Path(__file__).with_name("default_model.toml"),
    measures=StateMeasure.PLACE,
    run_keys=("approach",),
)

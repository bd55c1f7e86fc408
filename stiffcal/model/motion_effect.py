"""What all effects of moving joints have in common: they act in friction runs, never in load states."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import DocumentedEffect, Effect, Kind, Place


class MotionEffect(DocumentedEffect):
    """A torque that acts on a joint while it moves. Load states are taken at rest and cannot show it."""

    kind = Kind.NODE_LAW
    place_kind = "joints"
    in_motion = True
    least_speeds: ClassVar[int] = 0
    """Different speeds without which its parameters are not identifiable."""

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Load states are taken at rest."""
        return "friction runs: load states are taken at rest"

    def lacking_motion(self, chain: Chain, motion: DriveMotion) -> str | None:
        """Both directions, and as many speeds as it needs."""
        if not motion.both_ways:
            return "motion in both directions: in one direction friction and weight are measured as one torque"
        if self.least_speeds and len(motion.speeds()) < self.least_speeds:
            return f"at least {self.least_speeds} different speeds"
        return None


def is_constant_torque(effect: Effect, place: Place, chain: Chain) -> bool:
    """Return whether an effect's torque is the same whatever the motion: free constants at each speed absorb it."""
    change = np.array([1.0, -2.0, 0.5, -0.25, 3.0])
    motion = DriveMotion(change, 0.3 * change, 10.0 * change, np.abs(change), np.arange(5.0), np.abs(change[::-1]))
    shape = {spec.symbol: spec.typical for spec in effect.parameters}
    columns = effect.motion_columns(place, chain, motion, shape).values()
    return bool(columns) and all(column.any() and np.ptp(column) == 0.0 for column in columns)

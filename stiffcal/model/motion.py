"""What all effects of moving joints have in common: they act in friction runs, never in load states."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import Covariate, Effect, Kind, Place, Values
from stiffcal.model.parameters import usual_grid


class Motion(Effect):
    """A torque that acts on a joint while it moves. Load states are taken at rest and cannot show it."""

    kind = Kind.NODE_LAW
    place_kind = "joints"
    least_speeds: ClassVar[int] = 0
    """Different speeds without which its parameters are not identifiable."""

    def torque_columns(self, velocity: Floats, shape: Values) -> dict[str, Floats]:
        """Return amplitude symbol to (n,) torque of the drive per unit of it at velocities (n,), rad/s.

        Of laws of velocity alone, which need nothing else.
        """
        return {}

    def motion_columns(self, place: Place, chain: Chain, motion: DriveMotion, shape: Values) -> dict[str, Floats]:
        """Return amplitude symbol to (n,) torque of the place's drive per unit of it, in n samples of free motion."""
        return self.torque_columns(motion.velocity, shape)

    def motion_grid(self, place: Place, chain: Chain, motion: DriveMotion) -> dict[str, Floats]:
        """Return values of the shape parameters to start or profile from."""
        return usual_grid(self.parameters)

    def motion_covariate(self, place: Place, chain: Chain, motion: DriveMotion) -> Covariate:
        """Return the covariate that the residual of this effect follows."""
        return Covariate("velocity", "rad/s", motion.velocity)

    def lacking_motion(self, chain: Chain, motion: DriveMotion) -> str | None:
        """Return the data missing to determine this effect from one drive's motion, or None.

        Both directions, and as many speeds as it needs.
        """
        if not motion.both_ways:
            return "motion in both directions: in one direction friction and weight are measured as one torque"
        if self.least_speeds and len(motion.speeds()) < self.least_speeds:
            return f"at least {self.least_speeds} different speeds"
        return None


def as_motion(effect: Effect) -> Motion:
    """Return an effect that acts in rows of moving joints as what it is; TypeError where it is none."""
    if not isinstance(effect, Motion):
        raise TypeError(f"{effect.name} is no effect of moving joints")
    return effect


def is_constant_torque(effect: Motion, place: Place, chain: Chain) -> bool:
    """Return whether an effect's torque is the same whatever the motion: free constants at each speed absorb it."""
    change = np.array([1.0, -2.0, 0.5, -0.25, 3.0])
    motion = DriveMotion(change, 0.3 * change, 10.0 * change, np.abs(change), np.arange(5.0), np.abs(change[::-1]))
    shape = {spec.symbol: spec.typical for spec in effect.parameters}
    columns = effect.motion_columns(place, chain, motion, shape).values()
    return bool(columns) and all(column.any() and np.ptp(column) == 0.0 for column in columns)

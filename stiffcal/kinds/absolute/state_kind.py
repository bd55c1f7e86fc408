"""Load states of absolute runs: places, each pose once, left out by region."""

from __future__ import annotations

from stiffcal.arrays import Integers
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.state_kinds import StateKind
from stiffcal.measurements.rms import Rms
from stiffcal.quantity import Units
from stiffcal.validation.pose_folds import pose_folds
from stiffcal.validation.region_folds import region_folds
from stiffcal.validation.schemes import BY_REGION
from stiffcal.wording import length


class AbsoluteStateKind(StateKind):
    """Places of targets."""

    name = "absolute"
    runs = "absolute poses"
    left_out = "absolute poses"
    measure = "translation"
    scheme = BY_REGION

    def folds(self, data: Observations) -> Integers:
        """Return (n,) the region of each place."""
        return region_folds(data)

    def search_folds(self, data: Observations) -> Integers:
        """Return (n,) the pose of each place: regions are too few to compare effects over."""
        return pose_folds(data)

    def expected_error(self, error: Rms, whole: Rms, noise: Rms | None) -> str:
        """Return the error in regions, and the noise."""
        if error.translation is None:
            return ""
        units = Units.of_errors((error, noise))
        rms = f"{length(error.translation, units)} rms"
        known = None if noise is None else noise.translation
        against = "" if known is None else f"; noise of the instruments {length(known, units)} rms"
        return f"expected error in regions that were not measured (held-out regions): {rms}{against}"

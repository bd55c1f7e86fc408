"""Load states of load runs: displacements since the run's reference, left out by pose."""

from __future__ import annotations

from stiffcal.arrays import Integers
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.state_kinds import StateKind
from stiffcal.measurements.rms import Rms
from stiffcal.quantity import Units
from stiffcal.validation.pose_folds import pose_folds
from stiffcal.validation.schemes import LEAVE_ONE_POSE_OUT
from stiffcal.wording import length, significant


class LoadStateKind(StateKind):
    """Displacements under load."""

    name = "loads"
    runs = "load runs"
    left_out = "poses of the loads"
    measure = "translation"
    scheme = LEAVE_ONE_POSE_OUT

    def folds(self, data: Observations) -> Integers:
        """Return (n,) the pose of each state."""
        return pose_folds(data)

    def expected_error(self, error: Rms, whole: Rms, noise: Rms | None) -> str:
        """Return the error in new poses, and its share of the deflection."""
        if error.translation is None or not whole.translation:
            return ""
        share = 100.0 * error.translation / whole.translation
        size = length(error.translation, Units.of_errors((error, noise)))
        return (
            f"expected error in new poses of this kind: {size} rms, "
            f"{significant(share)} % of the deflection under such loads"
        )

"""Load states of clamped runs: motor angles, left out by run, or where these are few by cycle."""

from __future__ import annotations

from stiffcal.arrays import Integers
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.search_subject import SearchSubject
from stiffcal.identification.readings.state_kinds import StateKind
from stiffcal.kinds.clamped.states.folds import clamped_folds
from stiffcal.measurements.rms import Rms
from stiffcal.quantity import Units
from stiffcal.validation.schemes import LEAVE_ONE_POSE_OUT
from stiffcal.wording import angle


class ClampedStateKind(StateKind):
    """Angles of driven motors."""

    name = "clamped"
    runs = "clamped runs"
    left_out = "positions or cycles of clamped runs"
    measure = "motor_angle"
    scheme = LEAVE_ONE_POSE_OUT
    # with the output locked, a motor's angle depends on the torque of its own drive
    subject = SearchSubject("clamped", "Torque over angle", "in held-out data")

    def folds(self, data: Observations) -> Integers:
        """Return (n,) the run of each state, of joints in few positions the cycle."""
        return clamped_folds(data)

    def expected_error(self, error: Rms, whole: Rms, noise: Rms | None) -> str:
        """Return the error of the motor's angle."""
        if error.motor_angle is None:
            return ""
        rms = f"{angle(error.motor_angle, Units.of_errors((error, noise)))} rms"
        return f"expected error in positions or cycles that were not measured: {rms} of the motor's angle"

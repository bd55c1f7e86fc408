"""Trackers that are turned against the robot."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.abilities import FiniteShift
from stiffcal.model.effect import Instrument, Observed, ParameterSpec, Place, Values

_SOURCE = "half a degree: a frame defined by three probed points, or a tracker whose stand was moved"


class TrackerFrame(Instrument, FiniteShift):
    """The tracker frame is rotated relative to the robot base, so every measured displacement is rotated.

    Law: D_measured = exp(r) D, r = (rx, ry, rz) a rotation vector in base axes, for the translations and for the
    rotation vectors alike. A shift of the tracker's frame does not matter: displacements are differences.

    Assumes that the tracker stands still during the campaign.

    Limits: the effect of a rotation is the deflection times the angle; one degree is 2 % of it. The unloaded poses show
    the same rotation as an error of absolute position, which is better evidence where the robot is accurate.
    """

    name = "tracker-frame"
    place_kind = "setup"
    summary = "rotation error between tracker and robot base"
    parameters = tuple(
        ParameterSpec(f"r{axis}", "rad", f"rotation about the base {axis} axis", -0.5, 0.5, 0.01, _SOURCE)
        for axis in "xyz"
    )
    looks_like = ("wrench-frame", "base-compliance", "axis-coupling")
    fingerprint = "the residual is perpendicular and proportional to the deflection, in every pose"
    how_to_check = (
        "Compare kinematics and tracker in the unloaded poses: the same rotation appears there. Or repeat the "
        "registration from many poses (estimate = true)."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """A place shows where the tracker stands; only displacements can be turned and not shifted."""
        if not states.absolute.any():
            several = "a tracker that stands still: here it stood in several places, each with its frame"
            return several if len(states.setup.trackers) > 1 else None
        frames = {tracker.frame for tracker in states.setup.trackers}
        if frames & set(states.setup.estimated):
            return "displacements under load alone: in absolute runs the frame of the tracker is estimated by the fit"
        if not states.absolute.all():
            return "displacements under load alone: with absolute runs, estimate = true in the tracker's frame tests it"
        if frames == {""}:
            return "displacements under load: these places are given in the base's axes"
        return "displacements under load alone: in absolute runs the frame itself is estimated to test what is given"

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return e × D for each axis e: the slope of exp(r) D."""
        columns = {}
        for axis in range(3):
            column = np.zeros_like(observed.displacement)
            for first_row in (0, 3):
                second, third = first_row + (axis + 1) % 3, first_row + (axis + 2) % 3
                column[:, second] = -observed.displacement[:, third]
                column[:, third] = observed.displacement[:, second]
            columns[f"r{'xyz'[axis]}"] = column
        return columns

    def observation_shift(self, place: Place, observed: Observed, values: Values) -> Floats:
        """Return exp(r) D − D."""
        turn = rotation_from_vector(np.array([values.get(f"r{axis}", 0.0) for axis in "xyz"])) - np.eye(3)
        shift = np.empty_like(observed.displacement)
        for rows in (slice(0, 3), slice(3, 6)):
            shift[:, rows] = np.einsum("ij,bjn->bin", turn, observed.displacement[:, rows])
        return shift

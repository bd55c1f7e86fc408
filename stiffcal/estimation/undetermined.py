"""Why data do not determine a parameter."""

from __future__ import annotations

from enum import Enum


class Undetermined(Enum):
    """Why data do not determine a parameter, or several that they do not distinguish."""

    NO_LOAD = "no-load"
    WRENCH_NOISE = "wrench-noise"
    UNDRIVEN = "undriven"
    TILT_LOADED = "tilt-loaded"
    GAIN_OF_LOAD = "gain-of-load"
    SAME_MOTION = "same-motion"
    ONE_ORIENTATION = "one-orientation"
    COMMON_SCALE = "common-scale"
    INSEPARABLE = "inseparable"
    ASSEMBLY = "assembly-tolerance"
    PROPORTIONAL = "proportional"
    DEPENDENT = "dependent"

    @property
    def sentence(self) -> str:
        """In words."""
        return _SENTENCES[self]


_SENTENCES = {
    Undetermined.NO_LOAD: "no load in these data acts on it",
    Undetermined.WRENCH_NOISE: "only the noise of the force sensor acts on it",
    Undetermined.UNDRIVEN: "its joint was not driven while the flange was clamped",
    Undetermined.TILT_LOADED: "weight loads it no more than a turn of the base within its tolerance would",
    Undetermined.GAIN_OF_LOAD: (
        "it is exactly redundant with a common factor of all compliances; only a known weight or torque in a nonlinear "
        "law determines it"
    ),
    Undetermined.SAME_MOTION: (
        "other frames and links produce the same motion in every pose: it is set to 0 by convention and included in "
        "their values"
    ),
    Undetermined.ONE_ORIENTATION: (
        "the orientations in these poses do not separate it from a shift of another frame: by convention it stays as "
        "campaign.toml has it, and predictions for other orientations depend on it"
    ),
    Undetermined.COMMON_SCALE: (
        "only weight acts: a common scale of moments and compliances is unknown, only compliance times moment is "
        "known; a known payload in part of the poses, a measured wrench or the motor torques (torque_gain_sigma) "
        "determine it"
    ),
    Undetermined.INSEPARABLE: "its effect cannot be separated from the other parameters",
    Undetermined.ASSEMBLY: "these poses determine it no better than the assembly tolerance",
    Undetermined.PROPORTIONAL: "their regressors are proportional in these poses and loads",
    Undetermined.DEPENDENT: "their regressors are linearly dependent in these poses and loads",
}

"""How data are left out of a fit, by name and in words: one word for each scheme, wherever its figures are printed."""

from __future__ import annotations

from stiffcal.measurements.rms import Rms

LEAVE_ONE_POSE_OUT = "leave-one-pose-out"
"""Each pose in turn: all runs or rows whose joints agree within 1°."""
BY_REGION = "poses-region"
"""Each of six regions of the joints' ranges in turn, of absolute poses."""
HOLDOUT_RUNS = "holdout"
"""The runs that the manifest keeps back."""
BY_REGION_AND_POSE = f"{BY_REGION}; {LEAVE_ONE_POSE_OUT}"
"""Regions of absolute poses, and each pose of loads."""

_WORDS = {
    LEAVE_ONE_POSE_OUT: "held-out poses",
    BY_REGION: "held-out regions",
    BY_REGION_AND_POSE: "held-out regions and load poses",
    HOLDOUT_RUNS: "held-out runs",
}


def held_out_by_diagnosis(rms: Rms) -> str:
    """Return what `diagnose` left out of the fit, in words: of moving joints, whose errors are torques, no poses.

    Examples
    --------
    >>> held_out_by_diagnosis(Rms(1e-4, 2e-4)), held_out_by_diagnosis(Rms(None, None, torque=0.3))
    ('held-out poses', 'held-out data')
    """
    return _WORDS[LEAVE_ONE_POSE_OUT] if rms.torque is None else held_out(None)


def held_out(scheme: str | None) -> str:
    """Return what was left out, in words; "held-out data" for schemes of other experiments or several of them.

    Examples
    --------
    >>> held_out("poses-region"), held_out("each speed left out in turn"), held_out(None)
    ('held-out regions', 'held-out data', 'held-out data')
    """
    return _WORDS.get(scheme or "", "held-out data")

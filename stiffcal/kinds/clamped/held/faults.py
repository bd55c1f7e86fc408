"""What contradicts itself in a clamped run: torque against motion, and torque where a held flange puts none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.kinds.clamped.held.chain import ClampedChain
from stiffcal.kinds.clamped.held.saturation import Saturation, find_saturation
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.kinds.clamped.logs.sweeps import cut_sweeps, driven_one_way, is_too_short, loop_corners
from stiffcal.measurements.varying import varies
from stiffcal.wording import percent, significant

# A held flange lets the moved drive alone give, and no other then carries a torque that follows the motion. Links and
# fixtures give too, some hundredths of a drive's as a rule; beyond this the numbers do not belong together.
LOADED_TOO = 0.5
# Torque and angle that agree less than this are noise, whichever way they go.
FOLLOWS = 0.5


ONE_WAY = (
    "driven in one direction only: friction and play cannot be distinguished from the spring; drive it back and forth"
)
"""Why a run without a reversal is not used."""
TOO_SHORT = (
    "fewer than five readings in a half sweep: they do not show their noise, and make no load states; log at a higher "
    "rate, or drive more slowly"
)
"""Why a run has a description at most."""


@dataclass(frozen=True)
class RunQuality:
    """Which readings of a clamped run cannot be used."""

    saturation: Saturation | None
    """The limit that its torque ran into; None: none."""
    one_way: bool
    """True where the joint was driven from end to end in one direction only."""
    n_sweeps: int
    """Whole half sweeps."""
    too_short: bool
    """True where these hold too few readings to show their noise."""


def run_quality(readings: ClampedReadings, chain: ClampedChain) -> RunQuality:
    """Find which readings of one run cannot be used.

    Parameters
    ----------
    readings : of one run. chain : the run in drive coordinates.
    """
    angle, torque = chain.angle({}), chain.torque[:, chain.joint - 1]
    saturation = find_saturation(readings, angle, torque, chain)
    too_short = is_too_short(angle.size, len(loop_corners(angle, torque)))
    return RunQuality(saturation, driven_one_way(angle), cut_sweeps(angle, torque).count, too_short)


def other_loaded(chain: ClampedChain) -> tuple[int, float] | None:
    """Return the other drive that follows the moved one's motion, and its share of the torque; None where none does.

    The wrench that a held flange answers with turns about the moved joint alone (J Δd = 0 has no other solution where
    joints are distinguished). A wrong pose, a wrong sensor frame or unit, or the log of another run spoil that.

    Parameters
    ----------
    chain : one run.
    """
    k = chain.joint - 1
    if chain.source != "force sensor" or not chain.moments_measured:
        return None
    motion = chain.motion[:, k] - chain.motion[:, k].mean()
    follows = np.abs(motion @ (chain.torque - chain.torque.mean(axis=0)))
    alike = np.abs(chain.sensitivity) > 1e-3
    share = np.where(alike, 0.0, follows) / max(float(follows[k]), 1e-300)
    worst = int(np.argmax(share))
    return (worst + 1, float(share[worst])) if share[worst] > LOADED_TOO else None


def loaded_words(run: str, chain: ClampedChain, names: Sequence[str]) -> str:
    """Return the finding of `other_loaded` as a sentence; "" where nothing is wrong."""
    loaded = other_loaded(chain)
    if loaded is None:
        return ""
    other_joint, share = loaded
    driven, with_it = names[chain.joint - 1], names[other_joint - 1]
    size = f"{percent(share)} of that on {driven}" if share < 10.0 else f"{share:.0f} times that on {driven}"
    return (
        f"run {run}: the motion of {driven} produces a torque on {with_it}, {size}; a clamped flange loads the "
        "driven joint only: check the pose (joints_deg, units of the angles), the sensor's frame and the units of "
        "force and "
        "moment, and whether these files belong together"
    )


def why_no_sweep(angle: Floats, torque: Floats, saturation: Saturation | None) -> str:
    """Return why a run has no whole sweep, in words.

    Parameters
    ----------
    angle, torque : (n,) of the moved joint, rad, N·m. saturation : the limit that the torque ran into, or None.
    """
    if saturation is not None:
        limit = f"{significant(saturation.limit, 4)} {saturation.unit}"
        return f"{saturation.what} stays at its limit of {limit}, and no complete sweep remains"
    together = float(np.corrcoef(angle, torque)[0, 1]) if varies(angle) and varies(torque) else 0.0
    if together < -FOLLOWS:
        return (
            "torque and angle have opposite signs, as of a negative stiffness: check acts_on, the sensor's "
            "axes, units of force and moment, the sign of the current or of gear_ratio, and clock_ahead_s"
        )
    return "no complete sweep: the joint was not driven from end to end"

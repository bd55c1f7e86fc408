"""From which side each drive came to rest in the rows of absolute runs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.states.raw_states import RawStates

LEAST_MOTION = np.radians(0.05)
"""rad: a drive that turns by less stays, as far as friction goes: reducers wind up and play by one to three arc minutes
before their output turns (manufacturers' lost motion), and encoders' noise is far below.
"""


def approach_of_drives(
    raw_states: RawStates, joints: Floats, absolute: Booleans, chain: Chain, manifest_runs: Mapping[str, Run]
) -> Floats:
    """Return (n, J) the direction of each drive's last motion: 1, −1, or 0 where it is not known.

    Logged directions count before those of the rows; no columns where neither is there.

    Parameters
    ----------
    raw_states : n states, runs contiguous.
    joints : (n, L) logged angles, rad.
    absolute : (n,) True for rows of absolute runs, the only ones that have a direction.
    chain : how drives turn with logged joints.
    manifest_runs : by id.
    """
    logged = raw_states.signals.get("joints.approach")
    direct = absolute & np.array([_is_direct(manifest_runs.get(name)) for name in raw_states.run], dtype=np.bool_)
    if (logged is None or not absolute.any()) and not direct.any():
        return np.zeros((len(joints), 0))
    drives = chain.drives_of_logged
    found = last_motion(joints @ drives.T, direct & _continues(raw_states))
    if logged is not None:
        stated = _of_drives(np.sign(np.nan_to_num(logged)), drives)
        found = np.where(stated != 0.0, stated, found)
    return np.where(absolute[:, None], found, 0.0)


def _continues(raw_states: RawStates) -> Booleans:
    """Return (n,) True where a state's row stands right behind that of the state before, in the same run."""
    run = np.array(raw_states.run)
    follows = np.zeros(len(run), dtype=np.bool_)
    follows[1:] = (run[1:] == run[:-1]) & (np.diff(raw_states.number) == 1)
    return follows


def _is_direct(run: Run | None) -> bool:
    return run is not None and run.approach == "direct"


def last_motion(turned: Floats, follows: Booleans) -> Floats:
    """Return (n, J) the sign of each drive's last motion, 0 before the first; a drive that stays keeps it.

    Small steps one way add up: a drive turns back where it is `LEAST_MOTION` behind the farthest angle that it reached
    in the direction of its last motion.

    Parameters
    ----------
    turned : (n, J) angles of the drives, rad.
    follows : (n,) True for rows that the robot reached straight from the row before.
    """
    found = np.zeros_like(turned)
    for k in range(len(turned)):
        if k == 0 or not follows[k]:
            farthest, sign = turned[k], np.zeros(turned.shape[1])
        away = turned[k] - farthest
        moved = np.abs(away) >= LEAST_MOTION
        sign = np.where(moved, np.sign(away), sign)
        farthest = np.where(moved | (away * sign > 0.0), turned[k], farthest)
        found[k] = sign
    return found


def _of_drives(logged: Floats, drives: Floats) -> Floats:
    """Return (n, J) of signs of logged joints (n, L): of a drive that several turn, only where all agree."""
    share = np.abs(drives).sum(axis=1)
    mean = logged @ drives.T / np.where(share > 0.0, share, 1.0)
    return np.where(np.abs(mean) > 1.0 - 1e-9, np.sign(mean), 0.0)

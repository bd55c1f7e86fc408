"""A force sensor whose zero was set anew in the middle of a run.

Differences to the run's reference are then wrong by what the zero moved. It shows where the robot has come back to its
unloaded place and the sensor says otherwise, from one state on, each time by the same; or where it is far away and the
sensor says that nothing pulls.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import Fault
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.motion import motion_of

Floats = NDArray[np.float64]

BACK = 0.03  # of the largest displacement (or force): as good as there
AWAY = 0.06  # of the largest force: not there
ALIKE = 0.03
MENDED = 0.3  # of the squares that a straight line between force and motion leaves
AFAR = 0.25  # of the largest displacement, with no force read: no lost motion is as large
LEAST_RETURNS = 2  # or states of the other kind


def _is_mended(force: Floats, motion: Floats, step: Floats, starts: range) -> bool:
    """Tell whether motion follows force (both (n, 3)) far better with the step taken out from one state on."""

    def left(force: Floats) -> float:
        return float(np.sum((motion - force @ np.linalg.lstsq(force, motion, rcond=None)[0]) ** 2))

    after = np.arange(len(force))[:, None]
    best = min((left(force - np.where(after >= start, step, 0.0)) for start in starts), default=np.inf)
    return best < MENDED * left(force)


def rezeroed_runs(states: LoadStates, chain: Chain, file: str = "campaign.toml") -> list[Fault]:
    """Return a fault for every run in whose middle the sensor's zero moved."""
    told: list[Fault] = []
    if states.deflection_given or not states.setup.targets or not states.has_poses:
        return told
    for k in np.unique(states.run):
        members = np.flatnonzero(states.run == k)
        own = np.flatnonzero(states.reference[members])
        if members.size < 8 or own.size != 1:
            continue
        references = np.zeros(len(states), dtype=np.int64)
        references[members] = members[own[0]]
        motion = motion_of(states, chain).since(references)[members]
        moved = np.linalg.norm(motion, axis=1)
        force = states.wrench[members, :3] - states.wrench[members[own[0]], :3]
        size = np.linalg.norm(force, axis=1)
        if not np.isfinite(moved).all() or size.max() == 0.0 or moved.max() == 0.0:
            continue
        there = moved < BACK * moved.max()
        shifted = np.flatnonzero(there & (size > AWAY * size.max()))
        ghosts = (moved > AFAR * moved.max()) & (size < BACK * size.max())
        if (
            shifted.size == 0
            or shifted.size + ghosts.sum() < LEAST_RETURNS
            or (there & (size < BACK * size.max()))[shifted[0] :].any()
        ):
            continue
        step = force[shifted].mean(axis=0)
        if np.linalg.norm(force[shifted] - step, axis=1).max() > ALIKE * size.max():
            continue
        last = int(np.flatnonzero(there & (size < BACK * size.max()))[-1])
        if not _is_mended(force, motion, step, range(last + 1, int(shifted[0]) + 1)):
            continue
        run = states.runs[int(k)].name
        numbers = ", ".join(f"{value:.0f}" for value in step)
        reason = (
            f"between states {states.row[members[last]]} and {states.row[members[shifted[0]]]} the force sensor's zero "
            f"was set anew: unloaded it reads ({numbers}) N more than before, and forces are used as they stand"
        )
        mend = "split the run there (two [[runs]], each with its own reference), or take the step out in a copy"
        told.append(Fault(file, f"run {run}", reason, mend))
    return told

"""A force sensor whose zero was reset in the middle of a run.

Differences to the run's reference are then wrong by what the zero moved. It shows where the robot has come back to its
unloaded place and the sensor reads otherwise, from one state on, each time by the same; or where it is far away and the
sensor reads that nothing pulls.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.motion import motion_of

BACK = 0.03  # of the largest displacement: as good as there
LEAST_STEP = 0.012  # of the largest force: smaller ones matter less than the sensor's own gain
CLEARLY = 6.0  # times the scatter of what is read unloaded before and after
MENDED = 0.3  # of the squares that a straight line between force and motion leaves
AFAR = 0.25  # of the largest displacement, with no force read: no lost motion is as large
NO_FORCE = 0.03  # of the largest
SMALL = 0.06  # of the largest force: a larger step that the motion does not confirm is a load
LEAST_RETURNS = 2  # or states of the other kind


def _is_mended(force: Floats, motion: Floats, step: Floats, starts: range) -> bool:
    """Return whether motion follows force (both (n, 3)) far better with the step taken out from one state on."""

    def left(force: Floats) -> float:
        return float(np.sum((motion - force @ np.linalg.lstsq(force, motion, rcond=None)[0]) ** 2))

    after = np.arange(len(force))[:, None]
    best = min((left(force - np.where(after >= start, step, 0.0)) for start in starts), default=np.inf)
    return best < MENDED * left(force)


def _best_division(unloaded: Floats) -> tuple[int, Floats, float]:
    """Part readings (m, 3), in order, into two groups that scatter least: where, the step, the scatter about both."""
    m = len(unloaded)

    def left(k: int) -> float:
        return float(sum(((piece - piece.mean(axis=0)) ** 2).sum() for piece in (unloaded[:k], unloaded[k:])))

    k = min(range(1, m), key=left)
    step = unloaded[k:].mean(axis=0) - unloaded[:k].mean(axis=0)
    return k, step, float(np.sqrt(left(k) / max(m - 2, 1)))


def rezeroed_runs(states: LoadStates, chain: Chain, file: str = "campaign.toml") -> tuple[list[Fault], list[Fault]]:
    """Return a fault for every run in whose middle the sensor's zero moved; and those where a load may have stayed on.

    The motion distinguishes the two, unless the step is too small compared with what springs leave unexplained.
    """
    faults: list[Fault] = []
    doubts: list[Fault] = []
    if states.deflection_given or not states.setup.targets or not states.has_poses:
        return faults, doubts
    looked_at, references = [], np.zeros(len(states), dtype=np.int64)
    for members in members_of(states.run):
        own = np.flatnonzero(states.reference[members])
        if members.size >= 8 and own.size == 1:
            looked_at.append(members)
            references[members] = members[own[0]]
    motions = motion_of(states, chain).since(references) if looked_at else np.zeros((len(states), 3))
    for members in looked_at:
        motion = motions[members]
        distance = np.linalg.norm(motion, axis=1)
        force = states.wrench[members, :3] - states.wrench[references[members[0]], :3]
        size = np.linalg.norm(force, axis=1)
        if not np.isfinite(distance).all() or size.max() == 0.0 or distance.max() == 0.0:
            continue
        returned = np.flatnonzero(distance < BACK * distance.max())  # the reference among them
        if returned.size < 2:
            continue
        first, step, scatter = _best_division(force[returned])
        ghosts = (distance > AFAR * distance.max()) & (size < NO_FORCE * size.max())
        if (
            np.linalg.norm(step) < max(LEAST_STEP * size.max(), CLEARLY * scatter)
            or returned.size - first + ghosts.sum() < LEAST_RETURNS
        ):
            continue
        last, shifted = int(returned[first - 1]), int(returned[first])
        sure = _is_mended(force, motion, step, range(last + 1, shifted + 1))
        if not sure and (
            min(first, returned.size - first) < LEAST_RETURNS or np.linalg.norm(step) > SMALL * size.max()
        ):
            continue
        run = states.runs[int(states.run[members[0]])].name
        numbers = ", ".join(f"{value:.0f}" for value in step)
        finding = "was reset" if sure else "was reset, or a load remained"
        reason = (
            f"between states {states.row[members[last]]} and {states.row[members[shifted]]} the force sensor's zero "
            f"{finding}: unloaded it reads ({numbers}) N more than before; forces are used as they are"
        )
        mend = "split the run there (two [[runs]], each with its own reference), or remove the step in a copy"
        (faults if sure else doubts).append(Fault(FaultCode.WRENCH_REZEROED, file, f"run {run}", reason, mend))
    return faults, doubts

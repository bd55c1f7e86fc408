"""What the load did from state to state: direction, branch, cycle, level, and which states repeat each other.

Only the force is looked at (the moment where no force was applied): within a run the pose stands still, so that sensor
axes are as good as any.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates

# Below this share of the run's largest load a state counts as unloaded: loads are set in steps of a tenth and more,
# while a released rig keeps some per cent (cable weight, friction of a pulley).
UNLOADED_SHARE = 0.06
# Two loads point the same way within this angle; rigs repeat a direction within a degree or two.
SAME_DIRECTION = np.cos(np.radians(15.0))
# Loads of like level differ by less than this share of the run's largest load.
SAME_LEVEL_SHARE = 0.08
# Of the moment, 1/m: a lever of a thousand kilometres, such a force is what rounding leaves of none.
LEAST_FORCE = 1e-6

UNLOADED, LOADING, PEAK, UNLOADING = 0, 1, 2, 3
BRANCH_NAMES = ("unloaded", "loading", "peak", "unloading")


@dataclass(frozen=True)
class LoadCycles:
    """How the load went, per state."""

    magnitude: Floats
    """(n,) |force|, N (|moment|, N·m, in runs without force)."""
    direction: Integers
    """(n,) number of the signed direction within the run, −1 where unloaded."""
    axis: Integers
    """(n,) number of the direction regardless of sign, −1 where unloaded."""
    branch: Integers
    """(n,) UNLOADED, LOADING, PEAK or UNLOADING."""
    cycle: Integers
    """(n,) how often this signed direction has been loaded in the run, from 1; for unloaded states that of the
    direction just left, 0 before any.
    """
    last_direction: Integers
    """(n,) for unloaded states the signed direction just left (−1 before any); else the direction itself."""
    first: NDArray[np.bool_]
    """(n,) True on the first loading along an axis in the run, whose memory (friction, play) is not known."""


def load_vector(wrench: Floats) -> Floats:
    """Return (n, 3) the force, or the moment where no force was applied that matters."""
    return wrench[:, :3] if load_unit(wrench) == "N" else wrench[:, 3:]


def load_unit(wrench: Floats) -> str:
    """Return the unit of `load_vector` of wrenches (n, 6): N, or N·m where no force was applied that matters."""
    least = LEAST_FORCE * float(np.max(np.abs(np.nan_to_num(wrench[:, 3:])), initial=0.0))
    return "N" if float(np.max(np.abs(wrench[:, :3]), initial=0.0)) > least else "N·m"


def _directions(vectors: Floats, size: Floats, loaded: NDArray[np.bool_], run: Integers) -> tuple[Integers, Integers]:
    """Number the signed directions and the axes of each run's loads, for all runs at once.

    Parameters
    ----------
    vectors : (n, 3) N or N·m, of `size` (n,). loaded : (n,). run : (n,) numbers, each in one stretch, from 0.
    """
    direction = np.full(len(vectors), -1, dtype=np.int64)
    unit = vectors / np.where(size > 0.0, size, 1.0)[:, None]
    founders: list[Floats] = []
    waiting = np.flatnonzero(loaded)
    n_runs = int(run[-1]) + 1 if len(run) else 0
    # The largest load gives its direction best; it founds the next cluster. Of equal ones the first is taken.
    waiting = waiting[np.lexsort((waiting, -size[waiting], run[waiting]))]
    while waiting.size:
        first = waiting[np.append(True, np.diff(run[waiting]) != 0)]
        founder = np.zeros((n_runs, 3))
        founder[run[first]] = unit[first]
        same_direction = np.einsum("nc,nc->n", unit[waiting], founder[run[waiting]]) > SAME_DIRECTION
        direction[waiting[same_direction]] = len(founders)
        waiting = waiting[~same_direction]
        founders.append(founder)
    axis_of = np.tile(np.arange(len(founders) + 1), (n_runs, 1))
    for number, founder in enumerate(founders):
        for earlier in range(number - 1, -1, -1):
            opposite = np.einsum("rc,rc->r", founder, founders[earlier]) < -SAME_DIRECTION
            axis_of[opposite, number] = axis_of[opposite, earlier]
    axis = np.where(direction >= 0, axis_of[run, direction], -1).astype(np.int64)
    return direction, axis


def _branches(direction: Sequence[int], magnitude: Sequence[float], step: float) -> list[int]:
    """Distinguish loading from unloading within each stretch of one direction, in one run."""
    n = len(direction)
    branch = [UNLOADED] * n
    start = 0
    while start < n:
        if direction[start] < 0:
            start += 1
            continue
        end = start
        while end + 1 < n and direction[end + 1] == direction[start]:
            end += 1
        rising = True
        for i in range(start, end + 1):
            before = magnitude[i - 1] if i > start else 0.0
            if magnitude[i] > before + step:
                rising = True
            elif magnitude[i] < before - step:
                rising = False
            after = magnitude[i + 1] if i < end else 0.0
            branch[i] = (PEAK if after < magnitude[i] - step else LOADING) if rising else UNLOADING
        start = end + 1
    return branch


def run_members(run: Integers) -> list[Integers]:
    """Return each run's indices; states of a run are contiguous."""
    return list(np.split(np.arange(len(run)), np.flatnonzero(np.diff(run)) + 1)) if len(run) else []


def find_load_cycles(states: LoadStates) -> LoadCycles:
    """Label every state by what the load did.

    Examples
    --------
    See ``tests/reduction/test_load_cycles.py``.
    """
    n = len(states)
    magnitude = np.zeros(n)
    direction, axis, last_direction = (np.full(n, -1, dtype=np.int64) for _ in range(3))
    branch, cycle = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    first = np.zeros(n, dtype=np.bool_)
    loaded_alone, size_alone = _loaded_alone(states)
    magnitude[loaded_alone], branch[loaded_alone], cycle[loaded_alone] = size_alone, PEAK, 1
    direction[loaded_alone] = axis[loaded_alone] = last_direction[loaded_alone] = 0
    runs = [members for members in run_members(states.run) if len(members) > 1]
    if not runs:
        return LoadCycles(magnitude, direction, axis, branch, cycle, last_direction, first)
    chosen, run = np.concatenate(runs), np.repeat(np.arange(len(runs)), [len(members) for members in runs])
    starts = np.cumsum([0, *(len(members) for members in runs[:-1])])
    vectors = _load_vectors(states.wrench[chosen], starts, run)
    size = np.sqrt(np.sum(vectors**2, axis=1))
    largest = np.maximum.reduceat(size, starts)
    signed, unsigned = _directions(vectors, size, size > UNLOADED_SHARE * largest[run], run)
    magnitude[chosen], direction[chosen], axis[chosen] = size, signed, unsigned
    for members, step in zip(runs, (0.3 * SAME_LEVEL_SHARE * largest).tolist(), strict=True):
        own, axes = direction[members].tolist(), axis[members].tolist()
        branches = _branches(own, magnitude[members].tolist(), step)
        branch[members] = branches
        cycle[members], last_direction[members], first[members] = _count_cycles(own, axes, branches)
    return LoadCycles(magnitude, direction, axis, branch, cycle, last_direction, first)


def _load_vectors(wrench: Floats, starts: Integers, run: Integers) -> Floats:
    """Return (n, 3) what `load_vector` gives of each run's wrenches (n, 6); a run begins at each of `starts`."""
    sizes = np.abs(wrench)
    force = np.maximum.reduceat(sizes[:, :3].max(axis=1), starts)
    moment = np.maximum.reduceat(np.nan_to_num(sizes[:, 3:]).max(axis=1), starts)
    return np.where((force > LEAST_FORCE * moment)[run][:, None], wrench[:, :3], wrench[:, 3:])


def _loaded_alone(states: LoadStates) -> tuple[Integers, Floats]:
    """Return the states with a load that are the only one of their run, and the size of the load, N or N·m.

    A run of a single state has nothing to be unloaded against. Absolute places are thousands of these.
    """
    changes = np.diff(states.run) != 0
    alone = np.flatnonzero(np.append(True, changes) & np.append(changes, True)) if len(states) else states.run
    alone = alone[states.wrench[alone].any(axis=1)]
    each = np.arange(len(alone))
    size = np.linalg.norm(_load_vectors(states.wrench[alone], each, each), axis=1) if len(alone) else np.zeros(0)
    return alone[size > 0.0], size[size > 0.0]


def _count_cycles(
    signed: Sequence[int], unsigned: Sequence[int], branch: Sequence[int]
) -> tuple[list[int], list[int], list[bool]]:
    """Count, state by state, how often a direction has been loaded, and mark the first time along its axis."""
    cycle, last_direction, first = [], [], []
    count: dict[int, int] = {}
    earlier_axes: set[int] = set()
    current, previous_branch, virgin = -1, UNLOADED, False
    for own, axis, now in zip(signed, unsigned, branch, strict=True):
        if own >= 0:
            # A new cycle begins with a new direction, or when the load turns up again without a full release.
            turned_up = now in (LOADING, PEAK) and previous_branch in (UNLOADED, UNLOADING)
            if own != current or turned_up:
                count[own] = count.get(own, 0) + 1
                virgin = axis not in earlier_axes
                earlier_axes.add(axis)
            current = own
        first.append(own >= 0 and virgin and now == LOADING)
        cycle.append(count.get(current, 0))
        last_direction.append(current)
        previous_branch = now
    return cycle, last_direction, first


def repeat_groups(states: LoadStates, cycles: LoadCycles) -> list[Integers]:
    """Return groups of indices of states that repeat each other.

    Repeats share run, signed direction, branch and level, in different cycles; the first loading along an axis is left
    out, because friction and play start there from an unknown memory (physics, section 3). Unloaded states repeat each
    other when they were reached from the same direction.
    """
    groups: list[Integers] = []
    usable = states.used & ~cycles.first & (cycles.cycle > 0)
    if not usable.any():
        return groups
    largest = np.zeros(len(states))
    for members in run_members(states.run):
        largest[members] = np.max(cycles.magnitude[members])
    picked = np.flatnonzero(usable)
    # Sorted by run, direction, branch and then magnitude, repeats stand side by side.
    keys = (states.run[picked], cycles.last_direction[picked], cycles.branch[picked])
    order = np.lexsort((cycles.magnitude[picked], *reversed(keys)))
    picked = picked[order]
    new_kind = np.any([np.diff(key[order]) != 0 for key in keys], axis=0)
    gap = np.diff(cycles.magnitude[picked]) > SAME_LEVEL_SHARE * largest[picked[1:]]
    for piece in np.split(picked, np.flatnonzero(new_kind | gap) + 1):
        if len(piece) < 2:
            continue
        spread = float(np.ptp(cycles.magnitude[piece]))
        distinct = len(np.unique(cycles.cycle[piece])) == len(piece)
        if distinct and spread <= 2.0 * SAME_LEVEL_SHARE * largest[piece[0]]:
            groups.append(np.sort(piece))
    return groups

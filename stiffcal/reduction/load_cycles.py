"""What the load did from state to state: direction, branch, cycle, level, and which states repeat each other.

Only the force is looked at (the moment where no force was applied): within a run the pose stands still, so that sensor
axes are as good as any.
"""

from __future__ import annotations

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
    # A lever of a thousand kilometres: such a force is what rounding leaves of none.
    least = 1e-6 * float(np.max(np.abs(np.nan_to_num(wrench[:, 3:])), initial=0.0))
    return "N" if float(np.max(np.abs(wrench[:, :3]), initial=0.0)) > least else "N·m"


def _directions(vectors: Floats, loaded: NDArray[np.bool_]) -> tuple[Integers, Integers]:
    """Number the signed directions and the axes of one run's loads."""
    direction = np.full(len(vectors), -1, dtype=np.int64)
    size = np.sqrt(np.sum(vectors**2, axis=1))
    unit = vectors / np.where(size > 0.0, size, 1.0)[:, None]
    founders: list[Floats] = []
    waiting = loaded.copy()
    while waiting.any():
        # The largest load gives its direction best; it founds the next cluster.
        founder = unit[int(np.argmax(np.where(waiting, size, -1.0)))]
        same_direction = waiting & (unit @ founder > SAME_DIRECTION)
        direction[same_direction] = len(founders)
        waiting &= ~same_direction
        founders.append(founder)
    axis_of = np.arange(len(founders))
    if founders:
        opposite = np.stack(founders) @ np.stack(founders).T < -SAME_DIRECTION
        for number in range(len(founders)):
            earlier = np.flatnonzero(opposite[number, :number])
            if len(earlier):
                axis_of[number] = axis_of[earlier[0]]
    axis = np.where(direction >= 0, np.append(axis_of, -1)[direction], -1).astype(np.int64)
    return direction, axis


def _branches(direction: Integers, magnitude: Floats, step: float) -> Integers:
    """Distinguish loading from unloading within each stretch of one direction."""
    n = len(direction)
    branch = np.full(n, UNLOADED, dtype=np.int64)
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
    for members in run_members(states.run):
        if len(members) == 1:
            continue
        vectors = load_vector(states.wrench[members])
        size = np.sqrt(np.sum(vectors**2, axis=1))
        largest = float(np.max(size, initial=0.0))
        signed, unsigned = _directions(vectors, size > UNLOADED_SHARE * largest)
        magnitude[members], direction[members], axis[members] = size, signed, unsigned
        branch[members] = _branches(signed, size, 0.3 * SAME_LEVEL_SHARE * largest)
        cycle[members], last_direction[members], first[members] = _count_cycles(signed, unsigned, branch[members])
    return LoadCycles(magnitude, direction, axis, branch, cycle, last_direction, first)


def _loaded_alone(states: LoadStates) -> tuple[Integers, Floats]:
    """Return the states with a load that are the only one of their run, and the size of the load, N or N·m.

    A run of a single state has nothing to be unloaded against. Absolute places are thousands of these.
    """
    changes = np.diff(states.run) != 0
    alone = np.flatnonzero(np.append(True, changes) & np.append(changes, True)) if len(states) else states.run
    alone = alone[states.wrench[alone].any(axis=1)]
    size = np.array([float(np.linalg.norm(load_vector(row[None]))) for row in states.wrench[alone]])
    return alone[size > 0.0], size[size > 0.0]


def _count_cycles(
    signed: Integers, unsigned: Integers, branch: Integers
) -> tuple[Integers, Integers, NDArray[np.bool_]]:
    """Count, state by state, how often a direction has been loaded, and mark the first time along its axis."""
    n = len(signed)
    cycle, last_direction = np.zeros(n, dtype=np.int64), np.full(n, -1, dtype=np.int64)
    first = np.zeros(n, dtype=np.bool_)
    count: dict[int, int] = {}
    earlier_axes: set[int] = set()
    current, previous_branch, virgin = -1, UNLOADED, False
    for i in range(n):
        if signed[i] >= 0:
            # A new cycle begins with a new direction, or when the load turns up again without a full release.
            turned_up = branch[i] in (LOADING, PEAK) and previous_branch in (UNLOADED, UNLOADING)
            if signed[i] != current or turned_up:
                count[int(signed[i])] = count.get(int(signed[i]), 0) + 1
                virgin = int(unsigned[i]) not in earlier_axes
                earlier_axes.add(int(unsigned[i]))
            current = int(signed[i])
            first[i] = virgin and branch[i] == LOADING
        cycle[i], last_direction[i] = count.get(current, 0), current
        previous_branch = int(branch[i])
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

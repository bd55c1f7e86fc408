"""A force sensor's zero that moved once by as much as a load: readings near the old zero are loads afterwards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Integers, evenly
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.force_zero.moved_zero import (
    CLEARLY,
    LEAST_LEVEL,
    MovedZero,
    Part,
    Unloaded,
    ZeroChange,
    started_at,
)
from stiffcal.reduction.copies.like_readings import LikeReadings, most_alike_from

ALONG = np.cos(np.radians(15.0))  # as of directions in `load_cycles`
LEAST_RETURNS = 2  # to a zero that has moved by as much as a load
# States among which such a zero is looked for: what a longer run returns to shows in as many.
MANY_STATES = 1000
# States of which all pairs are compared at once, of many runs together; of longer runs first which may be alike.
MOST_IN_TABLE = 40
AT_ONCE = 200_000  # of these tables: more do not fit into the cache
ROUNDING = 1e-9  # of a limit: sums that are taken in another order differ in the last digit


@dataclass(frozen=True)
class _Stretch:
    """Part of a run in which a new zero is looked for."""

    run: Unloaded
    start: int
    """An unloaded state."""
    end: int
    """The next one, or the number of states."""
    least: int = LEAST_RETURNS
    """Of states that the load returns to."""


def with_returns_between(runs: Sequence[Unloaded]) -> list[Unloaded | None]:
    """Return runs with what they return to between readings near the old zero as unloaded too; None: nowhere."""
    chosen = [_chosen(run) for run in runs]
    few = [_among(run, own) for run, own in zip(runs, chosen, strict=True)]
    ends = [[*run.places.tolist(), own.size] for run, own in zip(few, chosen, strict=True)]
    stretches = [_Stretch(run, *pair) for run, own in zip(few, ends, strict=True) for pair in pairwise(own)]
    zeros = iter(_new_zeros(stretches))
    found: list[Unloaded | None] = []
    for run, own, thinned in zip(runs, chosen, few, strict=True):
        between = [place for _ in thinned.places for place in next(zeros)]
        places = np.sort(own[[*thinned.places.tolist(), *between]])
        found.append(replace(run, places=places) if between else None)
    return found


def _chosen(run: Unloaded) -> Integers:
    """Return the states of a run, ascending, among which a large step is looked for: all, or `MANY_STATES` at most."""
    n = run.members.size
    if n <= MANY_STATES:
        return np.arange(n)
    unloaded = MANY_STATES // 4
    return np.union1d(evenly(np.arange(n), MANY_STATES - unloaded), evenly(run.places, unloaded))


def _among(run: Unloaded, chosen: Integers) -> Unloaded:
    """Return what is known of some of a run's states, ascending."""
    if chosen.size == run.members.size:
        return run
    places = np.flatnonzero(np.isin(chosen, run.places))
    return Unloaded(run.members[chosen], places, run.wrench[chosen], run.time[chosen])


def large_steps(states: LoadStates, runs: Sequence[Unloaded], scatters: Sequence[float]) -> list[list[MovedZero]]:
    """Return of each run accounts of one step as large as a load, after which readings near the old zero are loads."""
    chosen = [_chosen(run) for run in runs]
    found = _new_zeros_at_once([_among(run, own) for run, own in zip(runs, chosen, strict=True)])
    return [
        [] if zero is None else _account_of(states, run, scatter, own, zero)
        for run, scatter, own, zero in zip(runs, scatters, chosen, found, strict=True)
    ]


def _account_of(
    states: LoadStates, run: Unloaded, scatter: float, chosen: Integers, found: tuple[int, list[int]]
) -> list[MovedZero]:
    place, group = int(chosen[found[0]]), chosen[found[1]]
    if chosen.size < run.members.size:  # what lies between those that were chosen
        place = int(run.places[np.searchsorted(run.places, group[0]) - 1])
        away = np.linalg.norm(run.force[place + 1 :] - run.force[group].mean(axis=0), axis=1)
        group = place + 1 + np.flatnonzero((away <= run.step) | (np.arange(place + 1, run.members.size) == group[0]))
    k = int(np.searchsorted(run.places, place))
    before = run.wrench[run.places[: k + 1]]
    change = run.wrench[group].mean(axis=0) - before.mean(axis=0)
    if np.linalg.norm(change[:3]) < max(LEAST_LEVEL * run.largest, CLEARLY * scatter):
        return []
    between = (int(run.members[place]), int(run.members[group[0]]))
    account = MovedZero(
        int(states.run[run.members[0]]), Part.FORCE, ZeroChange.STEP, between, change, k + 1 + group.size, run.members,
        np.zeros(run.wrench.shape), earliest=int(run.places[max(k - 1, 0)]) + 1, single=group.size == 1,
    )  # fmt: skip
    return [started_at(account, int(group[0]))]


def _new_zeros_at_once(runs: Sequence[Unloaded]) -> list[tuple[int, list[int]] | None]:
    """Return of each run the last state at the old zero and those at the new one, if it moved once by much.

    That is by as much as a load.
    """
    stretches: list[_Stretch] = []
    of_run: list[list[int]] = []
    for run in runs:
        n, places = run.members.size, run.places
        # more than the readings near the old zero after it
        least = np.maximum(places.size - np.arange(places.size), LEAST_RETURNS)
        possible = np.full(places.size, True)
        if n > MOST_IN_TABLE:
            possible = most_alike_from(run.force, run.step, places + 1) >= least
        of_run.append(np.flatnonzero(possible).tolist())
        stretches += [_Stretch(run, int(places[k]), n, int(least[k])) for k in of_run[-1]]
    zeros = iter(_new_zeros(stretches))
    found: list[tuple[int, list[int]] | None] = []
    for run, own in zip(runs, of_run, strict=True):
        groups = [(k, group) for k in own if (group := next(zeros))]
        if groups:
            k, group = max(groups, key=lambda entry: entry[0] + len(entry[1]))
            found.append((int(run.places[k]), group))
        elif run.places.size and run.places[-1] < run.members.size - 1:
            found.append((int(run.places[-1]), [run.members.size - 1]))
        else:
            found.append(None)
    return found


def _new_zeros(stretches: Sequence[_Stretch]) -> list[list[int]]:
    """Return of each stretch the states at which the load is off, though the zero has moved by as much as a load.

    They are what the load returns to, between loads in directions other than that of the change.
    """
    found: list[list[int]] = [[] for _ in stretches]
    alike: dict[int, list[int]] = {}
    for number, stretch in enumerate(stretches):
        size = stretch.end - stretch.start - 1
        if size < LEAST_RETURNS:  # fewer states between them
            continue
        if size > MOST_IN_TABLE:
            found[number] = _new_zero(stretch)
        else:
            alike.setdefault(size, []).append(number)
    for size, numbers in alike.items():
        at_once = max(AT_ONCE // size**3, 1)
        for first in range(0, len(numbers), at_once):
            batch = numbers[first : first + at_once]
            for number, possible in zip(batch, _may_return([stretches[k] for k in batch]), strict=True):
                if possible:
                    found[number] = _new_zero(stretches[number])
    return found


def _may_return(stretches: Sequence[_Stretch]) -> list[bool]:
    """Return of stretches of as many states each whether `_new_zero` can find any; tables of all pairs show it."""
    numbers = np.array([(one.run.step, one.run.largest, one.least) for one in stretches])
    steps, largest, least = numbers.T
    force = np.stack([one.run.force[one.start + 1 : one.end] - one.run.force[one.start] for one in stretches])
    share = force / steps[:, None, None]
    nearly = 1.0 - ROUNDING
    alike = ((share[:, :, None] - share[:, None]) ** 2).sum(axis=3) <= 1.0  # (s, m, m)
    counts = alike.sum(axis=2)
    change = alike @ force / counts[:, :, None]
    length = np.sqrt((change**2).sum(axis=2))
    possible = (counts >= least[:, None]) & (length > nearly * LEAST_LEVEL * largest[:, None])
    if not possible.any():
        return [False] * len(stretches)
    # of each reading, whether a load in another direction lies between the first and the last that are like it
    place = np.arange(force.shape[1])
    first, last = np.argmax(alike, axis=2), place[-1] - np.argmax(alike[:, :, ::-1], axis=2)
    inside = (place >= first[:, :, None]) & (place <= last[:, :, None])
    between = force[:, None] - change[:, :, None]  # (s, m, m, 3)
    size = np.sqrt((between**2).sum(axis=3))
    aside = nearly * np.abs(np.einsum("smkc,smc->smk", between, change)) < ALONG * size * length[:, :, None]
    loaded = inside & aside & (size > nearly * LEAST_LEVEL * largest[:, None, None])
    return list((possible & loaded.any(axis=2)).any(axis=1).tolist())


def _new_zero(stretch: _Stretch) -> list[int]:
    run, start = stretch.run, stretch.start
    force = run.force[start + 1 : stretch.end] - run.force[start]
    like = LikeReadings(force, run.step)
    returned = like.counts >= stretch.least
    if not returned.any():
        return []
    # of those returned to most often, the nearest
    for k in np.lexsort((np.sqrt((force**2).sum(axis=1)), -like.counts)):
        if not returned[k]:
            continue
        group = like.of(int(k))
        returned[group[like.counts[group] == group.size]] = False  # the same readings
        step = force[group].mean(axis=0)
        length = float(np.sqrt((step**2).sum()))
        if length <= LEAST_LEVEL * run.largest:
            continue
        between = force[group[0] : group[-1] + 1] - step
        size = np.sqrt((between**2).sum(axis=1))
        aside = np.abs(between @ step) < ALONG * size * length
        if ((size > LEAST_LEVEL * run.largest) & aside).any():
            return [start + 1 + int(place) for place in group]
    return []

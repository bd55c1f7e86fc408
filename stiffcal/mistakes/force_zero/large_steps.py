"""A force sensor's zero that moved once by as much as a load: readings near the old zero are loads afterwards."""

from __future__ import annotations

from dataclasses import replace
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


def with_returns_between(run: Unloaded) -> Unloaded | None:
    """Return a run with what it returns to between readings near the old zero as unloaded too; None: nowhere."""
    chosen = _chosen(run)
    few = _among(run, chosen)
    ends = [*few.places.tolist(), chosen.size]
    between = [place for start, end in pairwise(ends) for place in _new_zero(few, start, end)]
    return replace(run, places=np.sort(chosen[[*few.places.tolist(), *between]])) if between else None


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


def large_steps(states: LoadStates, run: Unloaded, scatter: float) -> list[MovedZero]:
    """Return accounts of one step as large as a load, after which readings near the old zero are loads."""
    chosen = _chosen(run)
    found = _new_zero_at_once(_among(run, chosen))
    if found is None:
        return []
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


def _new_zero_at_once(run: Unloaded) -> tuple[int, list[int]] | None:
    """Return the last state at the old zero and those at the new one, if it moved once by as much as a load."""
    n = run.members.size
    groups = []
    most_alike = most_alike_from(run.force, run.step, run.places + 1)
    for k, place in enumerate(run.places.tolist()):
        least = run.places.size - k  # more than the readings near the old zero after it
        if most_alike[k] >= max(least, LEAST_RETURNS):
            group = _new_zero(run, place, n, least)
            groups += [(k, group)] if group else []
    if groups:
        k, group = max(groups, key=lambda entry: entry[0] + len(entry[1]))
        return int(run.places[k]), group
    if run.places.size and run.places[-1] < n - 1:
        return int(run.places[-1]), [n - 1]
    return None


def _new_zero(run: Unloaded, start: int, end: int, least: int = LEAST_RETURNS) -> list[int]:
    """Return the states between two at which the load is off, though the zero has moved by as much as a load.

    They are what the load returns to, between loads in directions other than that of the change.

    Parameters
    ----------
    start : an unloaded state. end : the next one, or the number of states. least : of them.
    """
    if end - start <= LEAST_RETURNS:  # fewer states between them
        return []
    force = run.force[start + 1 : end] - run.force[start]
    like = LikeReadings(force, run.step)
    returned = like.counts >= max(least, LEAST_RETURNS)
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

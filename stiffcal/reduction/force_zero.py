"""A force sensor whose zero moved within a run: it was reset there, or it drifted.

Differences to the run's reference are then wrong by what the zero moved. It shows in what the sensor reads whenever
the load is taken off: these readings have to agree within their noise, those of the moments as well where the forces
do. The motion of the robot is not consulted, as play and friction keep an unloaded robot from its first place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.reduction.like_readings import LikeReadings, most_alike_from
from stiffcal.reduction.load_cycles import UNLOADED_SHARE

LEAST_STEP = 0.012  # of the largest force, or moment: smaller ones matter less than the sensor's own gain
CLEARLY = 6.0  # times the scatter of the unloaded readings
# Loads are set in steps of a tenth of the largest and more: a smaller change is none of them.
LEAST_LEVEL = 0.1
ALONG = np.cos(np.radians(15.0))  # as of directions in `load_cycles`
LEAST_RETURNS = 2  # to a zero that has moved by as much as a load
# |Δ| of two readings of three components of unit noise has the median √2 · 1.538 (that of χ with three degrees).
MEDIAN_OF_DIFFERENCES = 1.538 * np.sqrt(2.0)


class ZeroChange(StrEnum):
    """How a force sensor's zero moved."""

    STEP = "step"
    DRIFT = "drift"
    STEPS = "steps"
    UNCLEAR = "unclear"


class Part(StrEnum):
    """Three of a sensor's six readings; the value is their unit."""

    FORCE = "N"
    MOMENT = "N·m"

    @property
    def columns(self) -> slice:
        """Where they stand in a wrench."""
        return slice(0, 3) if self is Part.FORCE else slice(3, 6)


@dataclass(frozen=True)
class MovedZero:
    """One account of how the sensor's zero moved in a run."""

    run: int
    """Number of the run."""
    part: Part
    """What shows it: the forces, or the moments alone."""
    kind: ZeroChange
    """How it moved."""
    between: tuple[int, int]
    """Two states, as indices: the unloaded ones around the step; else the first one, and that which differs most."""
    change: Floats
    """(6,) N and N·m, what is read more in the second of these than in the first; of the forces 0 where they agree."""
    n_unloaded: int
    """How many unloaded readings there are."""
    members: Integers
    """(m,) the run's states, as indices."""
    zero: Floats
    """(m, 6) N and N·m, what the sensor reads too much in each of them, against the reference."""
    earliest: int | None = None
    """Of a step as large as a load, the first of ``members`` that it may have been before; None where that is known."""
    single: bool = False
    """Whether one reading alone shows it, which a load that remained would show as well."""


@dataclass(frozen=True)
class _Unloaded:
    """Unloaded readings of one run."""

    members: Integers
    """(m,) the run's states, as indices."""
    places: Integers
    """(u,) which of them are unloaded."""
    wrench: Floats
    """(m, 6) N and N·m, against the reference; moments that were not measured are 0."""
    time: Floats
    """(m,) s, or the number of the state where no time is known."""

    @property
    def force(self) -> Floats:
        """(m, 3) N, against the reference."""
        return np.asarray(self.wrench[:, :3])

    @property
    def largest(self) -> float:
        """N, of all forces."""
        return self.largest_of(Part.FORCE)

    def largest_of(self, part: Part) -> float:
        """Return the largest force, N, or moment, N·m."""
        return self._largest[part]

    @cached_property
    def _largest(self) -> dict[Part, float]:
        squares = self.wrench**2
        return {part: float(np.sqrt(squares[:, part.columns].sum(axis=1).max())) for part in Part}

    def readings(self, part: Part) -> Floats:
        """Return (u, 3) N or N·m of the unloaded states."""
        return np.asarray(self.wrench[self.places, part.columns])

    @property
    def step(self) -> float:
        """N, the least that counts: readings that differ by less are alike."""
        return LEAST_STEP * self.largest


def moved_zeros(states: LoadStates) -> list[list[MovedZero]]:
    """Return, for each run in which the force sensor's zero seems to have moved, the accounts of it.

    A load that the rig left on looks the same in the forces alone.

    Parameters
    ----------
    states : load states that are used, of load runs.
    """
    if states.setup.load_is_weight or not len(states):
        return []
    runs = [run for run in (_unloaded_of(states, members) for members in members_of(states.run)) if run is not None]
    largest = max((run.largest for run in runs), default=0.0)
    runs = [run for run in runs if run.largest > UNLOADED_SHARE * largest]
    by_part = [_accounts_of_runs(states, runs, part) for part in Part]
    # a load that is left on shows in the moments too: they are asked where the forces agree
    found = [of_force or of_moment for of_force, of_moment in zip(*by_part, strict=True)]
    return [accounts for accounts in found if accounts]


def _accounts_of_runs(states: LoadStates, runs: Sequence[_Unloaded], part: Part) -> list[list[MovedZero]]:
    """Return the accounts of each run; none where its readings agree, or nothing shows their noise."""
    scatters = _scatters(runs, part)
    known = [scatter for scatter in scatters if scatter is not None]
    usual = float(np.median(known)) if known else None
    found: list[list[MovedZero]] = []
    for run, own, of_sensor in zip(runs, scatters, _noise_of_sensor(states, runs, part), strict=True):
        floors = [value for value in (own, usual, of_sensor) if value is not None]
        found.append(_accounts(states, run, max(floors), part) if floors else [])
    return found


def started_at(moved: MovedZero, start: int) -> MovedZero:
    """Return an account of one step with the step before another one of the run's states."""
    after = np.arange(moved.members.size)[:, None] >= start
    first = moved.between[0]
    if moved.earliest is not None and moved.members[start] <= first:
        first = int(moved.members[moved.earliest - 1])
    return replace(moved, zero=np.where(after, moved.change, 0.0), between=(first, moved.between[1]))


def without_zeros(states: LoadStates, moved: Sequence[MovedZero]) -> LoadStates:
    """Return the states with what the zeros moved taken off the readings."""
    wrench = states.wrench.copy()
    for run in moved:
        wrench[run.members] -= run.zero
    return replace(states, wrench=wrench)


def _unloaded_of(states: LoadStates, members: Integers) -> _Unloaded | None:
    """Return one run's unloaded readings; None where there is nothing to compare."""
    members = members[np.isfinite(states.wrench[members, :3]).all(axis=1)]
    if members.size < 3:
        return None
    own = np.flatnonzero(states.reference[members])
    wrench = states.wrench[members]
    if not np.isfinite(wrench).all():
        wrench = wrench * [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    start = np.zeros(6) if own.size != 1 else wrench[own[0]]
    wrench = wrench - start
    largest = float(np.linalg.norm(wrench[:, :3], axis=1).max())
    if largest <= 0.0 or (states.setup.tared != "no" and np.linalg.norm(start[:3]) > UNLOADED_SHARE * largest):
        return None
    time = states.time[members]
    if not (np.isfinite(time).all() and (np.diff(time) > 0.0).all()):
        time = np.arange(members.size, dtype=np.float64)
    places = np.array(_returns(wrench[:, :3], np.zeros(3), LEAST_LEVEL * largest), dtype=np.int64)
    return _Unloaded(members, places, wrench, time)


def _returns(force: Floats, zero: Floats, near: float) -> list[int]:
    """Return the unloaded states of a run, in order: the nearest to the zero of each time that the load was taken off.

    Parameters
    ----------
    force : (m, 3) N. zero : (3,) N, what the sensor reads unloaded at first; it is followed from one time to the next.
    near : N, less than any load that is set.
    """
    places: list[int] = []
    inside: list[tuple[float, int]] = []
    readings, unloaded = force.tolist(), zero.tolist()
    for k, reading in enumerate(readings):
        away = math.dist(reading, unloaded)
        if away >= near and inside:
            places.append(min(inside)[1])
            inside, unloaded = [], readings[places[-1]]
            away = math.dist(reading, unloaded)
        if away < near:
            inside.append((away, k))
    return [*places, min(inside)[1]] if inside else places


def _accounts(states: LoadStates, run: _Unloaded, scatter: float, part: Part) -> list[MovedZero]:
    """Return the accounts of what the sensor reads in a run whenever the load is taken off; none where that agrees."""
    if part is Part.MOMENT:  # the forces say when the load is off
        return [account for account in (_moved(states, run, scatter, part),) if account is not None]
    ends = [*run.places.tolist(), run.members.size]
    gaps = [place for start, end in pairwise(ends) for place in _new_zero(run, start, end)]
    several = replace(run, places=np.array(sorted([*run.places.tolist(), *gaps]), dtype=np.int64))
    accounts = [_moved(states, readings, scatter, part) for readings in ([run, several] if gaps else [run])]
    return [account for account in (*accounts, *_large_steps(states, run, scatter)) if account is not None]


def _large_steps(states: LoadStates, run: _Unloaded, scatter: float) -> list[MovedZero]:
    """Return accounts of one step as large as a load, after which readings near the old zero are loads."""
    n, number = run.members.size, int(states.run[run.members[0]])
    groups = []
    most_alike = most_alike_from(run.force, run.step, run.places + 1)
    for k, place in enumerate(run.places.tolist()):
        least = run.places.size - k  # more than the readings near the old zero after it
        if most_alike[k] >= max(least, LEAST_RETURNS):
            group = _new_zero(run, place, n, least)
            groups += [(k, group)] if group else []
    if groups:
        k, group = max(groups, key=lambda entry: entry[0] + len(entry[1]))
    elif run.places.size and run.places[-1] < n - 1:
        k, group = run.places.size - 1, [n - 1]
    else:
        return []
    before = run.wrench[run.places[: k + 1]]
    change = run.wrench[group].mean(axis=0) - before.mean(axis=0)
    if np.linalg.norm(change[:3]) < max(LEAST_LEVEL * run.largest, CLEARLY * scatter):
        return []
    between = (int(run.members[run.places[k]]), int(run.members[group[0]]))
    account = MovedZero(
        number, Part.FORCE, ZeroChange.STEP, between, change, k + 1 + len(group), run.members, np.zeros((n, 6)),
        earliest=int(run.places[max(k - 1, 0)]) + 1, single=len(group) == 1,
    )  # fmt: skip
    return [started_at(account, group[0])]


def _new_zero(run: _Unloaded, start: int, end: int, least: int = LEAST_RETURNS) -> list[int]:
    """Return the states between two at which the load is off, though the zero has moved by as much as a load.

    They are what the load returns to, between loads in directions other than that of the change.

    Parameters
    ----------
    start : an unloaded state. end : the next one, or the number of states. least : of them.
    """
    force = run.force[start + 1 : end] - run.force[start]
    like = LikeReadings(force, run.step)
    returned = like.counts >= max(least, LEAST_RETURNS)
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


def _scatters(runs: Sequence[_Unloaded], part: Part) -> list[float | None]:
    """Return of each run the scatter of one component of the unloaded readings about their best account.

    None: there are too few readings, or the part reads nothing.
    """
    found: list[float | None] = [None] * len(runs)
    of_count: dict[int, list[int]] = {}
    for k, run in enumerate(runs):
        if run.places.size >= 3 and run.largest_of(part) > 0.0:
            of_count.setdefault(run.places.size, []).append(k)
    for numbers in of_count.values():
        readings = np.stack([runs[k].readings(part) for k in numbers])
        at = np.stack([runs[k].time[runs[k].places] for k in numbers])
        between = np.median(np.sqrt((np.diff(readings, axis=1) ** 2).sum(axis=2)), axis=1) / MEDIAN_OF_DIFFERENCES
        least = np.minimum(np.minimum(_step_of(readings)[2], _line_of(at, readings)[1]), between)
        for k, scatter in zip(numbers, least.tolist(), strict=True):
            found[k] = scatter
    return found


def _noise_of_sensor(states: LoadStates, runs: Sequence[_Unloaded], part: Part) -> list[float | None]:
    """Return of each run the noise of a reading as the manifest states it or the log shows it; None: neither does."""
    sigma = states.setup.sigma
    stated = (sigma.force if part is Part.FORCE else sigma.moment) or 0.0
    if not runs:
        return []
    members = np.concatenate([run.members for run in runs])
    starts = np.cumsum([0, *(run.members.size for run in runs[:-1])])
    squares = states.wrench_scatter[members, part.columns] ** 2 / np.maximum(states.n_readings[members], 1)[:, None]
    finite = np.isfinite(squares)
    sums = np.add.reduceat(np.where(finite, squares, 0.0).sum(axis=1), starts)
    counts = np.add.reduceat(finite.sum(axis=1), starts)
    shown = np.sqrt(sums / np.maximum(counts, 1))
    return [max(own, stated) or None for own in shown.tolist()]


def _step_of(readings: Floats) -> tuple[Integers, Floats, Floats]:
    """Part readings (r, u, 3) of r runs, in order, into two groups each that scatter least.

    Returns
    -------
    Where the second group begins (r,), the step (r, 3), the scatter about both (r,).
    """
    u = readings.shape[1]
    # Σ|x − mean|² of both pieces is least where Σ|piece's sum|² / piece's count, about any point, is largest
    sums = np.cumsum(readings - readings.mean(axis=1, keepdims=True), axis=1)
    counts = np.arange(1, u)
    first, second = (sums[:, :-1] ** 2).sum(axis=2), ((sums[:, -1:] - sums[:, :-1]) ** 2).sum(axis=2)
    at = 1 + np.argmax(first / counts + second / (u - counts), axis=1)
    after = (np.arange(u) >= at[:, None])[:, :, None]
    means = [(readings * own).sum(axis=1) / own.sum(axis=1) for own in (~after, after)]
    rest = readings - np.where(after, means[1][:, None], means[0][:, None])
    return at, means[1] - means[0], np.sqrt((rest**2).sum(axis=(1, 2)) / (3 * max(u - 2, 1)))


def _line_of(time: Floats, readings: Floats) -> tuple[Floats, Floats]:
    """Return the slopes (r, c) of readings (r, u, c) over times (r, u), per s, and their scatter (r,) about these."""
    at = time - time.mean(axis=1, keepdims=True)
    slope = np.einsum("ru,ruc->rc", at, readings) / (at**2).sum(axis=1)[:, None]
    rest = readings - readings.mean(axis=1, keepdims=True) - at[:, :, None] * slope[:, None]
    free = readings.shape[2] * max(readings.shape[1] - 2, 1)
    return slope, np.sqrt((rest**2).sum(axis=(1, 2)) / free)


def _moved(states: LoadStates, run: _Unloaded, scatter: float, part: Part) -> MovedZero | None:
    """Return how the zero moved in a run; None where its unloaded readings agree."""
    readings, places, time = run.readings(part), run.places, run.time
    if len(readings) < 2:
        return None
    least = max(LEAST_STEP * run.largest_of(part), CLEARLY * scatter)
    if ((readings - readings[0]) ** 2).sum(axis=1).max() < least**2:
        return None
    (k,), _, (about_step,) = _step_of(readings[None])
    _, (about_line,) = _line_of(time[None, places], readings[None])
    first, last = int(places[0]), int(places[-1])
    # what neither a step nor a trend explains is several steps, each of which the readings around it show
    if len(readings) == 2:
        kind = ZeroChange.UNCLEAR
    elif min(about_step, about_line) > 2.0 * scatter:
        kind = ZeroChange.STEPS
    else:
        kind = ZeroChange.STEP if about_step <= about_line else ZeroChange.DRIFT
    unloaded = run.wrench[places]
    if part is Part.MOMENT:  # the forces agree
        unloaded[:, :3] = 0.0
    if kind is ZeroChange.STEP:
        change, around = unloaded[k:].mean(axis=0) - unloaded[:k].mean(axis=0), (int(places[k - 1]), int(places[k]))
        zero = np.where(np.arange(run.members.size)[:, None] < places[k], 0.0, change)
    elif kind is ZeroChange.STEPS:
        far = int(np.argmax(np.linalg.norm(readings - readings[0], axis=1)))
        change, around = unloaded[far] - unloaded[0], (first, int(places[far]))
        zero = np.stack([np.interp(time, time[places], column - column[0]) for column in unloaded.T], axis=1)
    else:
        (slope,), _ = _line_of(time[None, places], unloaded[None])
        change, around = slope * (time[last] - time[first]), (first, last)
        zero = (time - time[first])[:, None] * slope
    if kind is not ZeroChange.STEPS and np.linalg.norm(change[part.columns]) < least:
        return None
    between = (int(run.members[around[0]]), int(run.members[around[1]]))
    number = int(states.run[run.members[0]])
    return MovedZero(number, part, kind, between, change, len(readings), run.members, zero)

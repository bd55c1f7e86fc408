"""What is said of a force sensor's zero that moved, and the unloaded readings of one run that show it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates
from stiffcal.reduction.loads.cycles import UNLOADED_SHARE

LEAST_STEP = 0.012  # of the largest force, or moment: smaller ones matter less than the sensor's own gain
LEAST_CLEAR_STEP = 0.001  # the same of one step between readings that agree: below it stands the last digit of tables
# Loads are set in steps of a tenth of the largest and more: a smaller change is none of them.
LEAST_LEVEL = 0.1
CLEARLY = 6.0  # times the scatter of the unloaded readings


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
class Unloaded:
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


def started_at(moved: MovedZero, start: int) -> MovedZero:
    """Return an account of one step with the step before another one of the run's states."""
    after = np.arange(moved.members.size)[:, None] >= start
    first = moved.between[0]
    if moved.earliest is not None and moved.members[start] <= first:
        first = int(moved.members[moved.earliest - 1])
    return replace(moved, zero=np.where(after, moved.change, 0.0), between=(first, moved.between[1]))


def unloaded_of(states: LoadStates, members: Integers) -> Unloaded | None:
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
    return Unloaded(members, places, wrench, time)


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

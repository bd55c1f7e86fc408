"""Load cycles: which loads a run sets, when, and how it goes from one to the next.

Why a path coordinate: between two holds the load runs along one straight line in wrench space, ahead of nothing and
behind nothing. All instruments measure the same path, each at its own times, so one number p gives where on it
the robot is at any time, and everything that depends on the load is solved at some p and interpolated between.
Hold k (from 0) covers p = 2k … 2k + 1, the ramp after it p = 2k + 1 … 2k + 2.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.simulation.settings import Loads

# After eight time constants a first-order lag has e^-8 = 0.03 % of its step left: less than any instrument shows.
SETTLED_AFTER = 8.0


@dataclass(frozen=True)
class LoadProgram:
    """The m holds of one run, in order; the first is unloaded."""

    wrench: Floats
    """(m, 6) N, N·m, base axes, about the load point: what is really set."""
    direction: Integers
    """(m,) number of the load's direction from 0; -1 where unloaded."""
    sign: Integers
    """(m,) +1 along the direction, -1 against it, 0 unloaded."""
    level: Floats
    """(m,) nominal load, as a fraction of the largest force."""
    branch: Integers
    """(m,) +1 loading, -1 unloading, 0 unloaded."""
    cycle: Integers
    """(m,) number of the full cycle in this direction from 0."""
    ramp_from: Floats
    """(m,) s when the ramp to this hold starts; the run's first hold starts at 0."""
    ramp_to: Floats
    """(m,) s when the ramp ends and settling starts."""
    start: Floats
    """(m,) s, true time from the run's start: the load has settled."""
    end: Floats
    """(m,) s, true time from the run's start: the load is kept until then."""

    def __len__(self) -> int:
        return int(self.wrench.shape[0])

    @property
    def duration(self) -> float:
        """When the last hold ends, s."""
        return float(self.end[-1])

    def first_hold(self) -> LoadProgram:
        """Return the first hold alone: the robot is never loaded."""
        return LoadProgram(*(getattr(self, entry.name)[:1] for entry in fields(LoadProgram)))

    def hold_at(self, time: Floats) -> Integers:
        """Return (n,) which hold a moment lies in or, during a ramp, comes to."""
        return np.clip(np.searchsorted(self.end, time, side="left"), 0, len(self) - 1).astype(np.int64)

    def path(self, time: Floats) -> Floats:
        """Return (n,) the path coordinate p at moments, s from the run's start.

        A ramp is a straight change of the load behind a first-order lag (air in the cylinder, the robot coming to
        rest); before the first hold and after the last the robot stays as it is in them.
        """
        hold = self.hold_at(time)
        start, end = self.start[hold], self.end[hold]
        within = np.clip((time - start) / (end - start), 0.0, 1.0)
        ramping = (time < start) & (hold > 0)
        done = self._progress(hold, time)
        return np.asarray(np.where(ramping, 2.0 * hold - 1.0 + done, 2.0 * hold + within))

    def _progress(self, hold: Integers, time: Floats) -> Floats:
        """Return the share of the step to ``hold`` that is done: a ramp of length T through a lag τ, in closed form."""
        length = np.maximum(self.ramp_to[hold] - self.ramp_from[hold], 1e-9)
        lag = np.maximum((self.start[hold] - self.ramp_to[hold]) / SETTLED_AFTER, 1e-9)
        since = np.maximum(time - self.ramp_from[hold], 0.0)
        on_ramp = np.minimum(since, length)
        rising = (on_ramp - lag * -np.expm1(-on_ramp / lag)) / length
        after = np.maximum(since - length, 0.0)
        return np.asarray(1.0 - (1.0 - rising) * np.exp(-after / lag))

    def wrench_at(self, path: Floats) -> Floats:
        """Return (n, 6) the load at path coordinates, N, N·m, base axes."""
        return interpolate_between_holds(self.wrench, path)


@dataclass(frozen=True)
class WavyProgram(LoadProgram):
    """A program whose ramps are wavy: friction in the device makes the load lead and lag (paper 000, Fig. 5)."""

    waviness: float
    """By what share of the step."""
    waves: int
    """So often on each ramp."""

    def _progress(self, hold: Integers, time: Floats) -> Floats:
        even = super()._progress(hold, time)
        return np.asarray(even + self.waviness * np.sin(2.0 * np.pi * self.waves * even))


def interpolate_between_holds(values_per_hold: Floats, path_coordinate: Floats) -> Floats:
    """Return (n, …) a quantity that is constant in each hold and changes in proportion to the load in between.

    Parameters
    ----------
    values_per_hold : (m, …) the quantity in each hold.
    path_coordinate : (n,) where to evaluate it: 2k … 2k + 1 is hold k (from 0), 2k + 1 … 2k + 2 the ramp to the next.
    """
    before = np.clip(np.floor(path_coordinate / 2.0).astype(np.int64), 0, len(values_per_hold) - 1)
    after = np.minimum(before + 1, len(values_per_hold) - 1)
    share = np.clip(path_coordinate - 2.0 * before - 1.0, 0.0, 1.0)
    share = share.reshape(share.shape + (1,) * (values_per_hold.ndim - 1))
    return np.asarray(values_per_hold[before] * (1.0 - share) + values_per_hold[after] * share)


def load_program(loads: Loads, base_from_axes: Floats, rng: np.random.Generator) -> LoadProgram:
    """Draw one run's load cycles.

    Parameters
    ----------
    loads : directions, levels, times.
    base_from_axes : (3, 3) turns the directions to base axes.
    rng : draws the scatter of loads and times.

    Examples
    --------
    >>> import numpy as np
    >>> program = load_program(Loads(levels=[0.5, 1.0]), np.eye(3), np.random.default_rng(1))
    >>> len(program)  # 1 unloaded, then 3 directions × 2 signs × (up, top, down, zero)
    25
    """
    direction, sign, level, branch, cycle = _sequence(loads)
    size = len(level)
    wrench = _wrenches(loads, base_from_axes, rng, direction, sign, level)
    hold = loads.hold_s * np.maximum(1.0 + loads.hold_scatter * rng.standard_normal(size), 0.2)
    hold[0] = loads.first_hold_s
    ramp = loads.ramp_s * np.maximum(1.0 + loads.ramp_scatter * rng.standard_normal(size), 0.2)
    ramp[0] = 0.0
    settle = np.full(size, loads.settle_s)
    settle[0] = 0.0
    end = np.cumsum(hold + ramp + settle)
    start = end - hold
    program = LoadProgram(
        wrench=wrench,
        direction=direction,
        sign=sign,
        level=level,
        branch=branch,
        cycle=cycle,
        ramp_from=start - settle - ramp,
        ramp_to=start - settle,
        start=start,
        end=end,
    )
    if loads.waviness == 0.0:
        return program
    own = {entry.name: getattr(program, entry.name) for entry in fields(program)}
    return WavyProgram(**own, waviness=loads.waviness, waves=loads.waves)


def _sequence(loads: Loads) -> tuple[Integers, Integers, Floats, Integers, Integers]:
    """Return direction, sign, level, branch and cycle of every hold: up, down, (the other way), for each direction."""
    holds: list[tuple[int, int, float, int, int]] = [(-1, 0, 0.0, 0, 0)]
    ascending = sorted(loads.levels)
    for direction in range(len(loads.directions)):
        for cycle in range(loads.cycles):
            for sign in (1, -1) if loads.both_ways else (1,):
                holds += [(direction, sign, level, 1, cycle) for level in ascending]
                holds += [(direction, sign, level, -1, cycle) for level in ascending[-2::-1]]
                holds.append((-1, 0, 0.0, 0, cycle))
    direction_of, sign_of, level_of, branch_of, cycle_of = zip(*holds, strict=True)
    return (
        np.array(direction_of, dtype=np.int64),
        np.array(sign_of, dtype=np.int64),
        np.array(level_of, dtype=np.float64),
        np.array(branch_of, dtype=np.int64),
        np.array(cycle_of, dtype=np.int64),
    )


def _wrenches(
    loads: Loads,
    base_from_axes: Floats,
    rng: np.random.Generator,
    direction: Integers,
    sign: Integers,
    level: Floats,
) -> Floats:
    """Return (m, 6) the loads as they are really set: never quite the size, never quite the direction."""
    unit = np.zeros((len(loads.directions), 6))
    for number, components in enumerate(loads.directions):
        unit[number, : len(components)] = components
        unit[number, :3] /= np.sqrt(np.sum(unit[number, :3] ** 2))
    unit[:, :3] = unit[:, :3] @ base_from_axes.T
    unit[:, 3:] = unit[:, 3:] @ base_from_axes.T
    loaded = np.asarray(level > 0.0, dtype=np.float64)
    size = loads.max_force_N * level * sign * (1.0 + loads.level_scatter * rng.standard_normal(level.size))
    along = unit[np.maximum(direction, 0)]
    tilt = loads.direction_scatter_rad * rng.standard_normal((level.size, 3))
    turned = along.copy()
    turned[:, :3] += np.cross(tilt, along[:, :3])
    turned[:, 3:] += np.cross(tilt, along[:, 3:])
    return np.asarray(turned * (size * loaded)[:, None])

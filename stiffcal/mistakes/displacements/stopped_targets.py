"""A target whose readings stop in part of a table or of a run: the tracker lost it, or zeros were filled in.

Two readings of an instrument never agree in every digit, but of a coarse gauge, or of a robot that friction holds, some
may. So the rows that read the same are held against what joint springs, fitted to all the others, make of their loads:
they are named where the others follow these springs and they do not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.displacements.springs import joint_springs
from stiffcal.reduction.loads.motion import MeasuredMotion, motion_of
from stiffcal.reduction.registration.still_components import rounding_of
from stiffcal.wording import length

SURE = 1e-3
"""Of the F test: one campaign in a thousand without such rows has a warning, as of `force_zero.tables`."""
# Stretches that one warning lists.
MOST_NAMED = 10


def stopped_targets(states: LoadStates, chain: Chain) -> list[str]:
    """Return a warning for every stretch of rows in which a target, or a gauge, reads the same whatever the load.

    Parameters
    ----------
    states : of load runs, those that are set aside as outliers included. chain : the robot's.
    """
    if len(states) < 2 or not np.isfinite(states.wrench).all():
        return []
    motion = motion_of(states, chain, all_targets=True)
    all_components = np.arange(motion.measured.shape[1])
    stretches = list(_stretches(states, motion))
    of_sensor = [(all_components, rows) for rows in _dead_sensor(states)]
    if not stretches and not of_sensor:
        return []
    alike = np.zeros(motion.measured.shape, dtype=np.bool_)
    for group, rows in (*stretches, *of_sensor):
        alike[np.ix_(rows, group)] = True
    reading, per_reading, columns = joint_springs(states, chain)
    design = columns * (per_reading @ reading[:, :, None])[:, None, :, 0]
    live = np.isfinite(motion.measured) & ~alike & states.used[:, None]
    springs = _Springs.of(states, motion.measured, design, live)
    if springs is None:
        return []
    n_tests = len(stretches) + len(of_sensor)
    lost = [(group, rows) for group, rows in stretches if springs.chance(rows, group) * n_tests < SURE]
    dead = [rows for group, rows in of_sensor if springs.chance(rows, group) * n_tests < SURE]
    remarks = [_words(states, motion.measured, lost, springs)] if lost else []
    if dead:
        remarks.append(
            f"{_places(states, dead)}: the force sensor reads the same, and the target moves by more than the other "
            "rows' springs explain: the sensor stopped; these rows are used as they are: exclude them with "
            "[[exclude]], or keep them"
        )
    return remarks


_Stretch: TypeAlias = tuple[Integers, Integers]
"""Components of a target, and states one after the other, in which they read the same."""


def _stretches(states: LoadStates, motion: MeasuredMotion) -> Iterator[_Stretch]:
    """Yield the stretches of whole targets, then those of single components next to others that change."""
    whole = np.zeros(motion.measured.shape, dtype=np.bool_)
    targets, rounding = np.array(motion.target), rounding_of(motion.measured)
    for target in dict.fromkeys(motion.target) if states.has_poses else ():
        group = np.flatnonzero(targets == target)
        for rows in _alike(states, motion.measured[:, group], 1 if states.deflection_given else 2, rounding):
            whole[np.ix_(rows, group)] = True
            yield group, rows
    for k in range(len(targets)):
        for rows in _alike(states, motion.measured[:, [k]], 2, rounding):
            if not whole[rows, k].any():
                yield np.array([k]), rows


def _dead_sensor(states: LoadStates) -> list[Integers]:
    """Return the stretches of states with the very same force, where no two others have: of a sensor, not set loads."""
    if states.setup.load_is_weight:
        return []
    load, n = states.wrench[:, :3], len(states)
    same = (load[1:] == load[:-1]).all(axis=1) & (np.diff(states.run) == 0)
    ends = [0, *(np.flatnonzero(~same) + 1).tolist(), n]
    stretches = [np.arange(start, end) for start, end in pairwise(ends) if end - start > 1]
    others = np.ones(n, dtype=np.bool_)
    for rows in stretches:
        others[rows] = False
    loads = load[others & load.any(axis=1)]
    return stretches if len(loads) and len(np.unique(loads, axis=0)) == len(loads) else []


def _alike(states: LoadStates, measured: Floats, least: int, rounding: float) -> Iterator[Integers]:
    """Yield the stretches of states with the very same readings (n, c), of zeros from `least` on, else of two."""
    n = len(states)
    with np.errstate(invalid="ignore"):
        same = (np.abs(np.diff(measured, axis=0)) <= rounding).all(axis=1)
    if not states.deflection_given:
        same &= np.diff(states.run) == 0
    starts = np.append(0, np.flatnonzero(~same) + 1)
    ends = np.append(starts[1:], n)
    with np.errstate(invalid="ignore"):
        moved = (np.abs(measured[starts]) > rounding).any(axis=1) if n else np.zeros(1, dtype=np.bool_)
    for k in np.flatnonzero(ends - starts >= np.where(moved, 2, least)):
        yield np.arange(starts[k], ends[k])


@dataclass(frozen=True)
class _Springs:
    """Joint springs fitted to the readings that change."""

    measured: Floats
    """(n, k) m, from the mean of the run's readings that change, or of all where none does."""
    predicted: Floats
    """(n, k) m, likewise."""
    known_level: Booleans
    """(n, k) whether there are such readings in the run."""
    mean_square: float
    """Of what the springs leave, m²."""
    free: int
    """Degrees of freedom of that."""

    @classmethod
    def of(cls, states: LoadStates, measured: Floats, design: Floats, live: Booleans) -> _Springs | None:
        """Fit the springs to live readings (n, k) with an offset for each run; None where they are not determined.

        Parameters
        ----------
        measured : (n, k) m. design : (n, k, J) m per unit of compliance. live : (n, k).
        """
        values = np.concatenate([np.nan_to_num(measured)[:, :, None], design], axis=2)
        known_level = np.ones_like(live)
        n_levels = 0
        if not states.deflection_given:
            for members in members_of(states.run):
                counted = live[members]
                known_level[members] = counted.any(axis=0)
                n_levels += int(counted.any(axis=0).sum())
                counted = counted | ~counted.any(axis=0)
                mean = np.einsum("mk,mkc->kc", counted, values[members]) / counted.sum(axis=0)[:, None]
                values[members] -= mean
        target, matrix = values[live][:, 0], values[live][:, 1:]
        scale = np.linalg.norm(matrix, axis=0)
        acting = scale > 1e-9 * max(float(scale.max(initial=0.0)), 1e-300)
        free = len(target) - int(acting.sum()) - n_levels
        if free < 1 or not acting.any():
            return None
        compliance = np.zeros(len(scale))
        compliance[acting] = np.linalg.lstsq(matrix[:, acting] / scale[acting], target, rcond=1e-9)[0] / scale[acting]
        left = target - matrix @ compliance
        mean_square = max(float(left @ left) / free, 1e-300)
        return cls(values[:, :, 0], values[:, :, 1:] @ compliance, known_level, mean_square, free)

    def missed(self, rows: Integers, group: Integers) -> tuple[Floats, int]:
        """Return (m, c) m how far readings are from the springs, and their degrees of freedom."""
        missed = (self.measured - self.predicted)[np.ix_(rows, group)]
        own_level = ~self.known_level[np.ix_(rows[:1], group)][0]
        missed = missed - np.where(own_level, missed.mean(axis=0), 0.0)
        return missed, missed.size - int(own_level.sum())

    def chance(self, rows: Integers, group: Integers) -> float:
        """Return how likely readings that follow the springs are so far from them."""
        from scipy.special import fdtrc

        missed, free = self.missed(rows, group)
        if free < 1 or not missed.any():
            return 1.0
        return float(fdtrc(free, self.free, float(np.sum(missed**2)) / free / self.mean_square))


def _words(states: LoadStates, measured: Floats, lost: Sequence[_Stretch], springs: _Springs) -> str:
    """Return the warning of all stretches."""
    zero = not any((np.abs(measured[np.ix_(rows, group)]) > rounding_of(measured)).any() for group, rows in lost)
    size = max(float(np.linalg.norm(springs.missed(rows, group)[0], axis=1).max()) for group, rows in lost)
    components = sorted({int(group[0]) for group, _ in lost if len(group) == 1})
    if states.has_poses and len(components) and all(len(group) == 1 for group, _ in lost):
        what, end = " and ".join(f"{'XYZ'[k % 3]} of the target, as read," for k in components), "a dead channel"
    else:
        what, end = "the target", "it was lost"
    return (
        f"{_places(states, [rows for _, rows in lost])}: {what} reads {'zero' if zero else 'the same'} "
        f"whatever the load, which by springs fitted to the other rows moves it by {length(size, digits=2)}: {end}, "
        "or not measured; these rows are used as they are: exclude them with [[exclude]], or keep them"
    )


def _places(states: LoadStates, stretches: Sequence[Integers]) -> str:
    places = list(dict.fromkeys(_place(states, rows) for rows in stretches))
    more = f" and {len(places) - MOST_NAMED} more" if len(places) > MOST_NAMED else ""
    return "; ".join(places[:MOST_NAMED]) + more


def _place(states: LoadStates, rows: Integers) -> str:
    """Return the run and the rows of states one after the other."""
    infos = [states.runs[int(states.run[k])] for k in (rows[0], rows[-1])]
    names, (first, last) = [info.of or info.name for info in infos], states.row[[rows[0], rows[-1]]]
    numbers = f"row {first}" if first == last else f"rows {first} to {last}"
    return numbers if names[0] != names[1] or names[0] == str(first) else f"run {names[0]}, {numbers}"

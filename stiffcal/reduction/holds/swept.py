"""Load states of a swept load: a device that goes up and down without holding (paper 000's load-displacement device).

The load is cut at its turning points into passes, each of one direction of change. Every pass is cut again where it
goes through the same few levels of load; what was read while the load passed a level is averaged into one state. States
of a pass up and of a pass down thus lie at comparable loads, and stay apart: which branch a state belongs to follows
from the order of the loads, as with loads that were held (`stiffcal.reduction.loads.cycles`).

Why averages around a level and not all readings: neighbouring readings of one pass share what friction and drift do
to them; a few windows that do not overlap are nearly independent, and mean load and mean displacement over one window
belong together to first order whatever the waviness of the device's force.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.reduction.holds.finding import Holds
from stiffcal.reduction.holds.unused import UnusedCode, UnusedStretch

# Levels per side of zero: ten per cent of the largest load apart, so that none is taken for its neighbour
# (`load_cycles.SAME_LEVEL_SHARE` is eight).
LEVELS = 10
# Half-width of the window around a level, in steps from level to level: windows leave half of the way between them.
WINDOW = 0.25
# A change of the load by less than this share of its range is waviness of the device, not a turning point.
WAVINESS = 0.15
# Readings that a pass needs, else it was a step and no sweep.
LEAST_READINGS = 4 * LEVELS
# A load that goes up and never comes back cannot be distinguished from drift.
LEAST_PASSES = 2
# Bands of load, and the share of the time under load in the tenth of them that has most, below which nothing is held:
# a sweep has a tenth there, a wavy one perhaps a third, a load that is held well above half.
BANDS = 100
HELD_SHARE = 0.45
# Of the range: a load within this of where it rests is resting.
AT_REST = 0.02
# The tenth of the bands that hold most.
FULLEST = BANDS // 10
# One of so many parts of a log, at its ends, gives the load at rest: a device waits for longer than that.
RESTING = 50
# Readings of a rest that makes a state.
LEAST_RESTING = 8
# Of a rest, left off at each end: the load has settled, and does not change yet.
REST_MARGIN = 0.1
# Readings of a window that makes a state: two have no scatter to compare.
LEAST_IN_WINDOW = 3
# Of a step from level to level: a load that is a level but for rounding is at it.
ROUNDING = 1e-9


@dataclass(frozen=True)
class SweptPasses:
    """The passes of a swept load."""

    holds: Holds
    """The windows around the levels, in order of time, as the holds of a load that is held."""
    passes: int
    """How often the load went from one turning point to the next."""


def swept_load(time: Floats, values: Floats) -> Floats:
    """Return (n,) the load along the line on which it changes, from the mean of its first readings.

    Parameters
    ----------
    time : (n,) s.
    values : (n, c) force and moment (zero where not measured), any units.
    """
    initial_load = values[: max(len(time) // RESTING, 1)].mean(axis=0)
    change = values - initial_load
    _, _, axes = np.linalg.svd(change, full_matrices=False)
    along = change @ axes[0]
    return np.asarray(along if along.max() >= -along.min() else -along)


def turning_points(load: Floats, least: float) -> Integers:
    """Return the indices at which the load turns: the ends and the extremes between changes of more than ``least``.

    Examples
    --------
    >>> import numpy as np
    >>> turning_points(np.array([0.0, 1.0, 0.9, 2.0, 1.0, 0.0]), 0.5).tolist()
    [0, 3, 5]
    """
    turns, extreme, rising = [0], 0, 0
    for k in range(1, len(load)):
        change = load[k] - load[extreme]
        if rising == 0:
            if abs(load[k] - load[0]) > least:
                rising, extreme = (1 if load[k] > load[0] else -1), k
        elif change * rising >= 0.0:
            extreme = k
        elif abs(change) > least:
            turns.append(extreme)
            extreme, rising = k, -rising
    if extreme != turns[-1]:
        turns.append(extreme)
    return np.array(turns, dtype=np.int64)


def find_sweeps(time: Floats, values: Floats) -> SweptPasses | None:
    """Find the states of a swept load; None where the load does not sweep.

    Parameters
    ----------
    time : (n,) s, of readings or of means over short blocks.
    values : (n, c) the load as read.

    Examples
    --------
    >>> import numpy as np
    >>> time = np.arange(0.0, 40.0, 0.02)
    >>> swept = find_sweeps(time, np.interp(time, [0, 5, 15, 25, 40], [0, 0, 500.0, 0, 0])[:, None])
    >>> swept.passes, len(swept.holds)
    (2, 21)
    """
    if time.size < LEAST_READINGS:
        return None
    load = swept_load(time, values)
    span = float(np.ptp(load))
    if span <= 0.0:
        return None
    turns = turning_points(load, WAVINESS * span)
    step = float(np.abs(load).max()) / LEVELS
    windows: list[tuple[float, float]] = []
    passes = 0
    moving = _moving(load, turns, AT_REST * span)
    if moving is None:
        return None
    first, last = moving
    windows += _rest(time[: first + 1])
    for begin, end in pairwise(turns):
        begin, end = max(begin, first), min(end, last)
        if end - begin < LEAST_READINGS:
            return None
        passes += 1
        windows += _windows_of(time, load, begin, end, step)
    if passes < LEAST_PASSES:
        return None
    windows += _rest(time[last:])
    start, stop = (np.array(side) for side in zip(*_disjoint(windows), strict=True))
    between = (UnusedStretch(float(time[0]), float(time[-1]), UnusedCode.BETWEEN_SWEPT_LOADS),)
    return SweptPasses(Holds(start, stop, start.copy(), stop.copy(), between), passes)


def is_swept(time: Floats, values: Floats) -> bool:
    """Return whether a load goes through all loads alike, rather than standing at some.

    A load that is held spends most of its time in a few narrow bands of load; one that is swept, however wavy, in all
    of them. How it rests before and after does not count.

    Parameters
    ----------
    time : (n,) s.
    values : (n, c) the load as read.

    Examples
    --------
    >>> import numpy as np
    >>> time = np.arange(0.0, 40.0, 0.02)
    >>> held = np.interp(time, [0, 5, 6, 12, 13, 20, 21, 30, 31, 40], [0, 0, 300, 300, 600, 600, 300, 300, 0, 0])
    >>> swept = np.interp(time, [0, 5, 15, 25, 40], [0, 0, 500.0, 0, 0])
    >>> is_swept(time, held[:, None]), is_swept(time, swept[:, None])
    (False, True)
    """
    if time.size < LEAST_READINGS:
        return False
    load = swept_load(time, values)
    span = float(np.ptp(load))
    moving = _moving(load, turning_points(load, WAVINESS * span), AT_REST * span) if span > 0.0 else None
    if moving is None:
        return False
    under = load[moving[0] : moving[1] + 1]
    under = under[np.abs(under) > AT_REST * span]
    count = np.sort(np.histogram(under, bins=BANDS, range=(float(load.min()), float(load.max())))[0])[::-1]
    return bool(count[:FULLEST].sum() < HELD_SHARE * max(count.sum(), 1))


def _moving(load: Floats, turns: Integers, still: float) -> tuple[int, int] | None:
    """Return the indices at which the load leaves its first rest for good and reaches its last one."""
    away = np.flatnonzero(np.abs(load - load[: max(turns[1] // RESTING, 1)].mean()) > still)
    if not len(away):
        return None
    last = np.median(load[-max(len(load) // RESTING, 1) :])
    back = np.flatnonzero(np.abs(load - last) > still)
    return max(int(away[0]) - 1, 0), min(int(back[-1]) + 1, len(load) - 1) if len(back) else len(load) - 1


def _rest(time: Floats) -> list[tuple[float, float]]:
    """Return the window of an unloaded rest, its last tenth left to what comes after; none where it is too short."""
    if len(time) < LEAST_RESTING:
        return []
    margin = REST_MARGIN * (time[-1] - time[0])
    return [(float(time[0] + margin), float(time[-1] - margin))]


def _windows_of(time: Floats, load: Floats, begin: int, end: int, step: float) -> list[tuple[float, float]]:
    """Return when a pass goes through each level, in order of time, and the turn at its end."""
    samples = slice(begin, end + 1)
    moment, course = time[samples], load[samples]
    # A wavy load comes back now and then: the time of a level is determined by the course without its waves.
    rising = bool(course[-1] > course[0])
    smooth = np.maximum.accumulate(course) if rising else np.minimum.accumulate(course)
    low, high = (course[0], course[-1]) if rising else (course[-1], course[0])
    levels = step * np.arange(np.ceil(low / step - ROUNDING), np.floor(high / step + ROUNDING) + 1)
    # What is nearer to the turns than a window belongs to both passes, and only once to the states.
    inner = levels[(levels - low > WINDOW * step) & (high - levels > WINDOW * step)]
    windows = []
    for level in inner if rising else inner[::-1]:
        at_level = np.flatnonzero(np.abs(smooth - level) <= WINDOW * step)
        if len(at_level) >= LEAST_IN_WINDOW:
            windows.append((float(moment[at_level[0]]), float(moment[at_level[-1]])))
    turn = np.flatnonzero(np.abs(course - course[-1]) <= WINDOW * step)
    tail = turn[turn >= len(course) // 2]
    if len(tail) >= LEAST_IN_WINDOW and abs(course[-1]) > 0.5 * step:
        windows.append((float(moment[tail[0]]), float(moment[-1])))
    return windows


def _disjoint(windows: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the windows in order of time, none reaching into the one before."""
    disjoint: list[tuple[float, float]] = []
    for start, end in sorted(windows):
        begin = max(start, disjoint[-1][1]) if disjoint else start
        if end > begin:
            disjoint.append((begin, end))
    return disjoint

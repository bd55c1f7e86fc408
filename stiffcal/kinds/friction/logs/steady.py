"""Steady velocities in a log: where a joint moved freely at a constant velocity, and what its drive needed for that.

A stroke is the motion from one turning point to the next. Within it the velocity is looked for that was held longest:
as logged, never as programmed. Passes of both directions over the same stretch of angle carry the same weight, which
half their difference is free of.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.set_aside import IN_USE, SetAside, SetAsideCode
from stiffcal.mechanics.like_poses import SAME_POSE_RAD
from stiffcal.reduction.holds.unused import UnusedCode, UnusedStretch
from stiffcal.reduction.logs.blocks import noise_along_a_course

# A turn of the motion counts when it goes back by more than this share of the whole travel, and by more than noise.
TURN_SHARE = 0.02
TURN_NOISE = 12.0
# Of a stroke: what the joint creeps at its ends before it rests.
REST_SHARE = 0.005
# Pieces a stroke is looked at in: ramps of trapezoidal profiles take a tenth of a stroke or more.
PIECES = 16
# The velocity counts as held while it changes by no more than this from one piece to the next, and by no more than four
# standard deviations of what the encoder leaves unknown.
HELD = 0.03
# Over the whole of it the velocity may not rise and fall by more.
FLAT = 0.01
NOISE_BAND = 4.0
LEAST_PIECES = 2.0
LEAST_SAMPLES = 8
# Speeds are one level when they lie this close: programmed steps are 10 % of full speed or more, 1 % below 5 %, so that
# the closest neighbours, 90 and 100 %, differ by a tenth.
SAME_SPEED = 0.04
# A pass that shares less than this with the others of its level is set aside.
LEAST_SHARED = 0.6

ONE_WAY = SetAside(
    SetAsideCode.ONE_DIRECTION,
    "moved in one direction only at this speed: weight and friction cannot be distinguished",
)
SHORT = SetAside(SetAsideCode.ANOTHER_STRETCH, "covers a different range of angle than the other passes at this speed")


@dataclass(frozen=True)
class Pass:
    """A stretch of one stroke at constant velocity."""

    time: Floats
    """(k,) s."""
    angle: Floats
    """(k,) rad, at the joint's side of the gear."""
    torque: Floats
    """(k,) N·m, at the joint's side of the gear."""
    velocity: float
    """rad/s, signed, mean as logged."""
    turned_at: float = float("nan")
    """rad, where the direction of motion last changed; NaN where that is not logged."""

    @property
    def low(self) -> float:
        """The smallest angle, rad."""
        return float(min(self.angle[0], self.angle[-1]))

    @property
    def high(self) -> float:
        """The largest angle, rad."""
        return float(max(self.angle[0], self.angle[-1]))


@dataclass(frozen=True)
class JointLog:
    """One joint's log of one run, at the joint's side of its gear."""

    time: Floats
    """(n,) s."""
    angle: Floats
    """(n,) rad."""
    torque: Floats
    """(n,) N·m."""
    velocity: Floats | None = None
    """(n,) rad/s as logged, None where it is not: then it comes from the angles."""
    excluded: Booleans | None = None
    """(n,) True for samples that are interpolated over excluded rows: they show where the joint moved and are no
    readings of a pass."""


def turning_points(angle: Floats) -> list[int]:
    """Return the samples at which a motion turns, first and last sample included.

    Parameters
    ----------
    angle : (n,) rad.

    Examples
    --------
    >>> there, back = np.linspace(0.0, 2.0, 21), np.linspace(1.9, 0.0, 20)
    >>> turning_points(np.concatenate([there, back, there[1:11]]))
    [0, 20, 40, 50]
    """
    least = max(TURN_SHARE * float(np.ptp(angle)), TURN_NOISE * noise_along_a_course(angle))
    values = angle.tolist()
    turns, low, high, direction = [0], 0, 0, 0
    for k, value in enumerate(values):
        if direction >= 0 and value > values[high]:
            high = k
        elif direction >= 0 and value < values[high] - least:  # it went back from the top
            turns += [high] if direction > 0 else []
            direction, low = -1, k
        if direction <= 0 and value < values[low]:
            low = k
        elif direction <= 0 and value > values[low] + least:
            turns += [low] if direction < 0 else []
            direction, high = 1, k
    return list(dict.fromkeys([*turns, len(values) - 1]))


def steady_passes(log: JointLog) -> tuple[list[Pass], list[UnusedStretch]]:
    """Find the stretches at constant velocity, and list the strokes that have none.

    Returns
    -------
    passes : in the order of the log.
    dropped : strokes that never held a velocity, and those of whose pass nearly all is excluded, with the reason.
    """
    noise = noise_along_a_course(log.angle)
    turns = turning_points(log.angle)
    strokes = [_without_rests(log.angle, first, last) for first, last in pairwise(turns)]
    # What the joint did before the log began is not known.
    turned_at = [float("nan"), *log.angle[turns[1:-1]].tolist()]
    longest = max(abs(float(log.angle[last] - log.angle[first])) for first, last in strokes)
    passes: list[Pass] = []
    dropped: list[UnusedStretch] = []
    for (first, last), turn in zip(strokes, turned_at, strict=True):
        steady_piece = _longest_steady_piece(log.time[first : last + 1], log.angle[first : last + 1], noise)
        if steady_piece is not None:
            rows = np.arange(first + steady_piece[0], first + steady_piece[1] + 1)
            kept = rows if log.excluded is None else rows[~log.excluded[rows]]
            if kept.size < LEAST_SAMPLES:
                ends = float(log.time[rows[0]]), float(log.time[rows[-1]])
                dropped.append(UnusedStretch(*ends, UnusedCode.EXCLUDED))
                continue
            passes.append(_pass_of(log, kept, turn))
        elif abs(float(log.angle[last] - log.angle[first])) > 0.5 * longest:  # others are moves to the start
            dropped.append(_never_steady(log, first, last))
    return passes, dropped


def _without_rests(angle: Floats, first: int, last: int) -> tuple[int, int]:
    """Take the rests at its ends off a stroke."""
    size = float(angle[last] - angle[first])
    progress = (angle[first : last + 1] - angle[first]) / size if size else np.zeros(last - first + 1)
    moving = np.flatnonzero((progress > REST_SHARE) & (progress < 1.0 - REST_SHARE))
    if moving.size == 0:
        return first, last
    return first + max(int(moving[0]) - 1, 0), first + min(int(moving[-1]) + 1, last - first)


def _never_steady(log: JointLog, first: int, last: int) -> UnusedStretch:
    stroke = slice(first, last + 1)
    time, angle = log.time[stroke], log.angle[stroke]
    size = abs(float(angle[-1] - angle[0]))
    width = max(2, time.size // PIECES)
    speed = float(np.max(np.abs(angle[width:] - angle[:-width]) / (time[width:] - time[:-width]), initial=0.0))
    return UnusedStretch(float(time[0]), float(time[-1]), UnusedCode.NEVER_STEADY, stroke=size, speed=speed)


def _longest_steady_piece(time: Floats, angle: Floats, noise: float) -> tuple[int, int] | None:
    """Return first and last sample of the longest piece of a stroke at constant velocity, None where there is none."""
    n = time.size
    width = max(4, n // PIECES)
    if n < 2 * width + LEAST_SAMPLES:
        return None
    slope = (angle[width:] - angle[:-width]) / (time[width:] - time[:-width])
    change = np.abs(slope[width:] - slope[:-width])
    middle = 0.5 * (slope[width:] + slope[:-width])
    doubt = noise * np.sqrt(6.0) / (time[2 * width :] - time[width:-width])  # slopes that share one sample
    top = float(np.abs(middle).max())
    steady = (change <= np.maximum(HELD * np.abs(middle), NOISE_BAND * doubt)) & (
        np.abs(middle) > np.maximum(0.02 * top, NOISE_BAND * doubt)
    )
    edges = np.flatnonzero(np.diff(np.concatenate([[0], steady.astype(np.int8), [0]])))
    best: tuple[int, int] | None = None
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        first, last = int(start), int(stop) - 1 + 2 * width
        piece = _narrow_to_steady(time[first : last + 1], angle[first : last + 1], width)
        if piece is None:
            continue
        first, last = first + piece[0], first + piece[1]
        if last - first < max(LEAST_PIECES * width, LEAST_SAMPLES) or _bends(time, angle, first, last, noise):
            continue
        if best is None or last - first > best[1] - best[0]:
            best = first, last
    return best


def _bends(time: Floats, angle: Floats, first: int, last: int, noise: float) -> bool:
    """Return whether the velocity changes slowly over the length of a piece, as around the fastest point of a swing."""
    away = np.linspace(-1.0, 1.0, last - first + 1)
    _, linear, square, cubic = (
        float(coefficient) for coefficient in np.polynomial.legendre.legfit(away, angle[first : last + 1], 3)
    )
    # the slopes of Legendre's second and third polynomials span 6 and 7.5; noise leaves √((2k + 1)/n) in the k-th
    change = 6.0 * abs(square) + 7.5 * abs(cubic)
    doubt = noise * (6.0 * np.sqrt(5.0) + 7.5 * np.sqrt(7.0)) / np.sqrt(away.size)
    return bool(change > max(FLAT * abs(linear), NOISE_BAND * doubt))


def _narrow_to_steady(time: Floats, angle: Floats, width: int) -> tuple[int, int] | None:
    """Take slow bends off the ends: the velocity there must be that of the middle."""
    n = time.size
    if n <= 2 * width:
        return None
    slope = (angle[width:] - angle[:-width]) / (time[width:] - time[:-width])
    usual_slope = float(np.median(slope))
    off = np.abs(slope - usual_slope) > 2.0 * HELD * abs(usual_slope) + 1e-12
    inside = np.flatnonzero(~off)
    if inside.size == 0:
        return None
    edges = np.flatnonzero(np.diff(inside) > 1)
    runs = np.split(inside, edges + 1)
    longest = max(runs, key=len)
    # a piece may reach two thirds of its width into the acceleration before its slope shows it: left out at each end
    margin = 3 * width // 4 + 1
    return int(longest[0]) + margin, int(longest[-1]) + width - margin


def _pass_of(log: JointLog, rows: Integers, turned_at: float) -> Pass:
    time, angle = log.time[rows], log.angle[rows]
    velocity = _slope(time, angle) if log.velocity is None else float(log.velocity[rows].mean())
    return Pass(time, angle, log.torque[rows], velocity, turned_at)


def _slope(time: Floats, value: Floats) -> float:
    away = time - time.mean()
    return float(away @ value / (away @ away))


@dataclass(frozen=True)
class JointPass:
    """A pass, and what has to be alike for passes to be compared."""

    steady_pass: Pass
    """The pass at constant velocity."""
    run: int
    """Index of its run."""
    joint: int
    """The moved joint, from 1."""
    other_angles: Floats
    """(L,) rad, where all joints stood, the moved one zero."""


@dataclass(frozen=True)
class SteadyTorque:
    """A pass reduced to a torque at a velocity over the stretch that its level shares."""

    joint_pass: JointPass
    """The pass, its run and its joint."""
    stretch: int
    """Number of the level whose passes share the stretch."""
    low: float
    """rad, where the stretch begins."""
    high: float
    """rad, where it ends."""
    velocity: float
    """rad/s, signed."""
    torque: float
    """N·m, mean over the stretch."""
    scatter: float
    """N·m, standard deviation of the readings in the stretch."""
    n_readings: int
    """Number of readings in the stretch."""
    set_aside: SetAside
    """Whether the fit uses it, or why not."""


def readings_of(passes: Sequence[JointPass]) -> list[SteadyTorque]:
    """Bring passes at one speed together and average each over the stretch of angle that all of them cover.

    Parameters
    ----------
    passes : of all joints and runs.

    Returns
    -------
    One reading per pass, in the order given; those without a pass the other way, or off the stretch, are marked so.
    """
    readings: dict[int, SteadyTorque] = {}
    for number, level in enumerate(_levels(passes)):
        members, short = _sharing([passes[k].steady_pass for k in level])
        chosen = [level[k] for k in members]
        members_held = [passes[k].steady_pass for k in chosen]
        low, high = (
            max(steady_pass.low for steady_pass in members_held),
            min(steady_pass.high for steady_pass in members_held),
        )
        both_directions = len({np.sign(steady_pass.velocity) for steady_pass in members_held}) == 2
        for k in chosen:
            readings[k] = _reading(passes[k], number, low, high, IN_USE if both_directions else ONE_WAY)
        for k in (level[i] for i in short):
            steady_pass = passes[k].steady_pass
            readings[k] = _reading(passes[k], number, steady_pass.low, steady_pass.high, SHORT)
    return [readings[k] for k in range(len(passes))]


def _reading(joint_pass: JointPass, stretch: int, low: float, high: float, set_aside: SetAside) -> SteadyTorque:
    """Average a pass between two angles, to a fraction of a sample: weight must be alike in both directions."""
    steady = joint_pass.steady_pass
    slope = _slope(steady.time, steady.angle)
    middle_time, middle_angle = float(steady.time.mean()), float(steady.angle.mean())
    ends = sorted(middle_time + (angle - middle_angle) / slope for angle in (low, high))
    start, end = max(ends[0], float(steady.time[0])), min(ends[1], float(steady.time[-1]))
    area = np.concatenate([[0.0], np.cumsum(0.5 * (steady.torque[1:] + steady.torque[:-1]) * np.diff(steady.time))])
    if end > start:
        torque = float(np.interp(end, steady.time, area) - np.interp(start, steady.time, area)) / (end - start)
    else:
        torque = float(steady.torque.mean())
    inside = steady.torque[(steady.time >= start) & (steady.time <= end)]
    scatter = float(inside.std(ddof=1)) if inside.size > 1 else 0.0
    return SteadyTorque(joint_pass, stretch, low, high, steady.velocity, torque, scatter, int(inside.size), set_aside)


def _levels(passes: Sequence[JointPass]) -> list[list[int]]:
    """Return indices of passes of one joint, with the others alike, at one speed."""
    levels: list[list[int]] = []
    assigned: set[int] = set()
    order = sorted(range(len(passes)), key=lambda k: abs(passes[k].steady_pass.velocity))
    for k in order:
        if k in assigned:
            continue
        level, last = [k], abs(passes[k].steady_pass.velocity)
        for candidate in order:
            speed = abs(passes[candidate].steady_pass.velocity)
            same_level = passes[candidate].joint == passes[k].joint and _same_pose(passes[k], passes[candidate])
            if (
                candidate != k
                and candidate not in assigned
                and same_level
                and last <= speed <= last * (1.0 + SAME_SPEED)
            ):
                level.append(candidate)
                last = speed
        assigned.update(level)
        levels.append(sorted(level))
    return sorted(levels)


def _same_pose(first: JointPass, second: JointPass) -> bool:
    return bool(np.abs(first.other_angles - second.other_angles).max(initial=0.0) < SAME_POSE_RAD)


def _sharing(passes: Sequence[Pass]) -> tuple[list[int], list[int]]:
    """Return the passes that share a stretch long enough, and those that do not."""
    low = float(np.median([steady_pass.low for steady_pass in passes]))
    high = float(np.median([steady_pass.high for steady_pass in passes]))
    length = max(high - low, 1e-12)
    shared = [
        min(steady_pass.high, high) - max(steady_pass.low, low) >= LEAST_SHARED * length for steady_pass in passes
    ]
    if sum(shared) == 0:
        return list(range(len(passes))), []
    return [k for k, fits in enumerate(shared) if fits], [k for k, fits in enumerate(shared) if not fits]

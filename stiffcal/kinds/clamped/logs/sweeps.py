"""Clamped runs from logs to readings: clocks brought together, the joint that moved found, sweeps cut into cycles.

A half sweep leads from one corner of the torque-angle loop to the next. Corners are found in angle and torque together,
because either may turn first: a driven motor turns in angle, a motor that is driven by torque and held by friction
turns in torque while its angle stands still.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.clamped.logs.clocks import MOVED, STANDS_RAD, lag_of
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.measurements.load_states import RunInfo
from stiffcal.quantity import JOINT_ANGLE
from stiffcal.reduction.clocks.offsets import SourceClockOffset
from stiffcal.reduction.logs.blocks import Blocks, noise_of
from stiffcal.wording import in_unit

# Only one joint is driven; what the others show is their servos giving way.
ALONE = 0.3
# A corner of the loop stands off the last one by at least this share of the loop's size.
TURN_SHARE = 0.35
# A half sweep that covers less of the whole span is none.
WHOLE = 0.8
# Readings of a fourth difference, which shows the noise: with fewer in a half sweep a run makes no states.
LEAST_OF_SWEEP = 5
_ONE_WAY = "the joint was driven in one direction only: no loop of force over angle shows it"


def clamped_readings(run: Run, logs: Mapping[str, Blocks]) -> tuple[ClampedReadings, dict[str, SourceClockOffset]]:
    """Return the readings of one clamped run, on the clock of the log of motor angles, and the clocks.

    Parameters
    ----------
    run : the manifest's entry.
    logs : source to block averages, SI, joint side.

    Raises
    ------
    InputError
        No log holds motor angles, nothing determines the torque, or a clock cannot be found.
    """
    sources = {name: [key for key, blocks in logs.items() if name in blocks.mean] for name in ("joints", "wrench")}
    if not sources["joints"]:
        raise InputError.at(
            FaultCode.SIGNAL_MISSING,
            f"run {run.id}",
            "",
            "a clamped run needs the motor angles",
            'add a source with joints = { position = "A1..A6", units = { position = "deg" } }, say',
        )
    angles = logs[sources["joints"][0]]
    n, width = len(angles), angles.mean["joints"].shape[1]
    torque = angles.mean.get("joints.torque", np.full((n, width), np.nan))
    wrench, clocks = np.full((n, 6), np.nan), {sources["joints"][0]: SourceClockOffset(0.0, 0.0)}
    two_clocks = False
    if sources["wrench"]:
        name = sources["wrench"][0]
        # where the manifest states the clock, nothing is left that a lag could be mistaken for
        two_clocks = logs[name] is not angles and name not in run.clock_ahead_s
        clock = _clock(run, name, angles, logs[name])
        clocks[name] = clock
        # without a clock the run is not used; that the logs begin together shows what else is in them
        ahead = logs[name].time[0] - angles.time[0] if clock.value is None else clock.value
        wrench = _at(logs[name], "wrench", angles.time + float(ahead))
    elif "joints.torque" not in angles.mean:
        unscaled = "joints.current" in angles.mean
        raise InputError.at(
            FaultCode.SIGNAL_MISSING, f"run {run.id}", "",
            "no force sensor, and motor currents without a torque constant: nothing measures the torque"
            if unscaled else "neither a force sensor nor motor torques are logged: nothing measures the torque",
            "add torque_constant = 0.8, say (N*m per ampere, one number or one per joint), to the joints signal"
            if unscaled else "add a source with a wrench, or torque = 'T1..T6', say (or current with torque_constant)",
        )  # fmt: skip
    complete = np.isfinite(wrench).all(axis=1) if sources["wrench"] else np.ones(n, dtype=np.bool_)
    info = RunInfo(run.id, run.experiment, run.holdout, run.tags)
    readings = ClampedReadings(
        runs=(info,),
        run=np.zeros(int(complete.sum()), dtype=np.int64),
        time=angles.time[complete],
        joints=angles.mean["joints"][complete],
        wrench=wrench[complete],
        torque=torque[complete],
        two_clocks=np.array([two_clocks]),
    )
    if len(readings) < 2:
        raise InputError.at(
            FaultCode.CLOCK_UNKNOWN,
            f"run {run.id}",
            "",
            "force and motor angles do not overlap in time",
            "check which files belong together",
        )
    return readings, clocks


def _at(blocks: Blocks, name: str, time: Floats) -> Floats:
    """Return (n, c) a signal at times of its own clock; NaN outside its log."""
    values = blocks.mean[name]
    columns = [np.interp(time, blocks.time, column, left=np.nan, right=np.nan) for column in values.T]
    return np.stack(columns, axis=1)


def _clock(run: Run, name: str, angles: Blocks, wrench_log: Blocks) -> SourceClockOffset:
    """Return how much more the other log's clock shows than that of the angles; no value of a motion one way only.

    Raises
    ------
    InputError
        No force follows a motion there and back.
    """
    if wrench_log is angles:
        return SourceClockOffset(0.0, 0.0)
    if name in run.clock_ahead_s:
        return SourceClockOffset(float(run.clock_ahead_s[name]), 0.0, "given in the manifest")
    joints = angles.mean["joints"]
    angle = joints[:, int(np.argmax(np.ptp(joints, axis=0)))]
    if driven_one_way(angle):
        return SourceClockOffset(None, None, _ONE_WAY)
    offset = lag_of(angles.time, angle, wrench_log.time, wrench_log.mean["wrench"])
    if offset.value is None:
        raise InputError.at(
            FaultCode.CLOCK_UNKNOWN,
            f"run {run.id}", f"clock of {name}", offset.reason,
            f"give {toml_text.pair('clock_ahead_s', {name: 0.0})} for this run (s), or check that the joint was driven",
        )  # fmt: skip
    return offset


@dataclass(frozen=True)
class Sweeps:
    """One joint's motion, cut at the corners of its loop."""

    number: Integers
    """(n,) half sweep that a reading belongs to, from 0; −1 at rest before, after, and where nothing goes on."""
    up: Booleans
    """(n,) True where the joint's angle grows in that half sweep."""
    count: int
    """Half sweeps."""

    @property
    def cycles(self) -> int:
        """Whole cycles, there and back."""
        return self.count // 2


def moved_joint(run: str, joints: Floats, given: int | None, names: tuple[str, ...]) -> int:
    """Return the joint that was driven, from 1.

    Parameters
    ----------
    run : its name, for faults. joints : (n, L) rad. given : the manifest's word, or None. names : L joint names.

    Raises
    ------
    InputError
        The joint that the manifest names never moved, another moved more, none moved, or several did.
    """
    span = np.ptp(joints, axis=0)
    floor = np.maximum(STANDS_RAD, MOVED * noise_of(joints))
    largest = int(np.argmax(span))
    if STANDS_RAD < span[largest] <= floor[largest]:
        raise InputError.at(
            FaultCode.MOTION_WRONG,
            f"run {run}", "", "the motor angles change from reading to reading by as much as in the whole run of "
            f"{len(joints)} readings: no motion is distinguished from noise",
            "log at a higher rate, or drive more slowly; if the joint stood still, remove this run",
        )  # fmt: skip
    if span[largest] <= floor[largest]:
        raise InputError.at(
            FaultCode.MOTION_WRONG,
            f"run {run}", "", (
                f"no joint moved: the motor angles stay within "
                f"{in_unit(span[largest], JOINT_ANGLE.usual, 2)}"
            ),
            "check the columns and the unit of the motor angles, or remove this run",
        )  # fmt: skip
    joint = largest if given is None else given - 1
    if span[joint] <= floor[joint]:
        raise InputError.at(
            FaultCode.MOTION_WRONG, f"run {run}", "moved_joint",
            f"joint {joint + 1} ({names[joint]}) never moved: its angle stays within "
            f"{in_unit(span[joint], JOINT_ANGLE.usual, 2)}",
            f"joint {largest + 1} ({names[largest]}) moved by {in_unit(span[largest], JOINT_ANGLE.usual)}: "
            f"write moved_joint = {largest + 1}, or measure again",
        )  # fmt: skip
    moving = [k for k in range(span.size) if k != joint and span[k] > max(ALONE * span[joint], floor[k])]
    if moving:
        raise InputError.at(
            FaultCode.MOTION_WRONG, f"run {run}", "moved_joint",
            f"joint {moving[0] + 1} ({names[moving[0]]}) also moved, by "
            f"{in_unit(span[moving[0]], JOINT_ANGLE.usual)} against "
            f"{in_unit(span[joint], JOINT_ANGLE.usual)} of joint {joint + 1}",
            "drive one joint at a time, each in a separate run, and state it in moved_joint",
        )  # fmt: skip
    return joint + 1


def cut_sweeps(angle: Floats, torque: Floats) -> Sweeps:
    """Cut one joint's motion into half sweeps.

    Parameters
    ----------
    angle, torque : (n,) rad and N·m, in order of time.

    Examples
    --------
    >>> import numpy as np
    >>> angle = np.interp(np.arange(401), [0, 50, 150, 250, 350, 400], [0, 1, -1, 1, -1, 0.0])
    >>> sweeps = cut_sweeps(angle, 100.0 * angle)
    >>> sweeps.count, bool(sweeps.up[100]), bool(sweeps.up[200])
    (3, False, True)
    """
    n = angle.size
    number, up = np.full(n, -1, dtype=np.int64), np.zeros(n, dtype=np.bool_)
    size, count = np.ptp(angle), 0
    for start, end in pairwise(loop_corners(angle, torque)):
        # the way from rest to the first corner, and from the last one to rest, is no whole branch
        if abs(angle[end] - angle[start]) < WHOLE * size:
            continue
        number[start : end + 1] = count
        up[start : end + 1] = angle[end] > angle[start]
        count += 1
    return Sweeps(number, up, count)


def driven_one_way(angle: Floats) -> bool:
    """Return whether a joint went from end to end in one direction only, by its angles (n,), rad.

    Examples
    --------
    >>> driven_one_way(np.linspace(0.0, 1.0, 50)), driven_one_way(np.sin(np.linspace(0.0, 9.0, 50)))
    (True, False)
    """
    sweeps = cut_sweeps(angle, angle)
    up = sweeps.up[sweeps.number >= 0]
    return bool(up.size and (up.all() or not up.any()))


def loop_corners(angle: Floats, torque: Floats) -> list[int]:
    """Return the readings at which a torque-angle loop turns, its first and last extreme among them.

    Parameters
    ----------
    angle, torque : (n,) rad and N·m, in order of time.
    """
    size = np.ptp(angle)
    if angle.size < 8 or size <= 0.0:
        return []
    place = angle / size + torque / max(float(np.ptp(torque)), 1e-300)
    return _corners(place, TURN_SHARE * float(np.ptp(place)))


def is_too_short(n: int, n_corners: int) -> bool:
    """Return whether a loop of n readings with so many corners has too few in a half sweep to show its noise.

    Examples
    --------
    >>> is_too_short(14, 3), is_too_short(15, 3)
    (True, False)
    """
    return n < LEAST_OF_SWEEP * n_corners


def _corners(place: Floats, least: float) -> list[int]:
    """Return indices where `place` turns back by at least `least`, the first and last extreme among them."""
    corners: list[int] = []
    low = high = 0
    rising: bool | None = None
    for k in range(1, place.size):
        if place[k] > place[high]:
            high = k
        if place[k] < place[low]:
            low = k
        if rising is not False and place[high] - place[k] > least:
            corners.append(high)
            rising, low = False, k
        elif rising is not True and place[k] - place[low] > least:
            corners.append(low)
            rising, high = True, k
    if rising is not None:
        corners.append(high if rising else low)
    return corners

"""Friction runs reduced: passes at constant velocity where one joint moves, else samples of the whole motion."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.friction.logs.clocks import torque_clock
from stiffcal.kinds.friction.logs.free_motion import free_motion
from stiffcal.kinds.friction.logs.friction_run import FrictionRun
from stiffcal.kinds.friction.logs.readings import FreeMotion, SteadyReadings, stacked_motion
from stiffcal.kinds.friction.logs.samples import PassSamples, pass_samples
from stiffcal.kinds.friction.logs.steady import JointLog, JointPass, readings_of, steady_passes
from stiffcal.measurements.load_states import RunInfo
from stiffcal.measurements.set_aside import set_aside_columns
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.clocks.offsets import SourceClockOffset
from stiffcal.reduction.holds.unused import UnusedStretch, by_cause, cause_text
from stiffcal.reduction.logs.blocks import Blocks, noise_along_a_course
from stiffcal.wording import listing, significant

# A joint moves when it travels this far, more than this share of the widest, and out of its noise: others are held by
# their servos within arc seconds, and give by some 1e-4 rad when a neighbour accelerates.
LEAST_TRAVEL_RAD = 1e-3
TRAVEL_SHARE = 0.02
TRAVEL_NOISE = 8.0
LEAST_READINGS = 8
# A velocity as logged that differs from that of the angles by more than this is of another unit or side of the gear.
VELOCITY_AGREES = 0.1


@dataclass(frozen=True)
class FrictionReduction:
    """What friction runs hold."""

    steady: SteadyReadings | None
    """Passes at constant velocity; None where there are none."""
    motion: FreeMotion | None
    """Other motion; None where there is none."""
    samples: PassSamples | None = None
    """Within the passes that are used; None where there are none."""
    dropped: Mapping[str, tuple[UnusedStretch, ...]] = field(default_factory=dict)
    """Run to what was not used of it."""
    warnings: tuple[str, ...] = ()
    """What a user ought to know."""


def friction_run(run: Run, logs: Mapping[str, Blocks]) -> FrictionRun:
    """Bring the logs of one run to one clock, that of the angles.

    Parameters
    ----------
    run : the manifest's entry. logs : source to block averages in SI, at the joint's side.

    Raises
    ------
    InputError
        No angles or velocities, no torque, a current without its torque constant, clocks that nothing ties together.
    """
    place = f"run {run.id}"
    position = _source_of(logs, "joints")
    speed = _source_of(logs, "joints.velocity")
    if position is None and speed is None:
        raise InputError.at(
            FaultCode.SIGNAL_MISSING, "campaign.toml", place, "a friction run needs the motion of the joints",
            'add position = "A1..A6" or velocity = "V1..V6", say, to the joints of a source',
        )  # fmt: skip
    torque = _source_of(logs, "joints.torque")
    if torque is None:
        raise _no_torque(place, logs)
    lead = position or speed or ""
    blocks = logs[lead]
    time = blocks.time
    clocks = _clocks_of_manifest(run, logs)
    velocity = None
    if speed is not None:
        velocity = _on_clock(run, logs, speed, "joints.velocity", lead, clocks)
    if position is not None:
        angle = blocks.mean["joints"]
    else:
        assert velocity is not None
        steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time)[:, None]
        angle = np.concatenate([np.zeros((1, velocity.shape[1])), np.cumsum(steps, axis=0)])
    if velocity is not None and position is not None:
        _check_velocity(place, time, angle, velocity)
    if torque != lead and (torque not in clocks or lead not in clocks):
        _find_clock(run, clocks, torque, lead, time, angle, logs[torque])
    needed = _on_clock(run, logs, torque, "joints.torque", lead, clocks)
    info = RunInfo(run.id, run.experiment, run.holdout, run.tags)
    # Blocks hold one or two samples where a log is as fast as they are: even steps are what differences need.
    first, last = _in_common(time, logs, [torque, *([speed] if speed is not None else [])], lead, clocks)
    even = np.arange(first, last, float(np.median(np.diff(time)))) if time.size > 2 else time
    if even.size < LEAST_READINGS:
        raise InputError.at(
            FaultCode.CLOCK_UNKNOWN, "campaign.toml", place, "angles and torques do not overlap in time",
            "check which files belong together, and clock_ahead_s",
        )  # fmt: skip
    angle, needed = _evenly(even, time, angle), _evenly(even, time, needed)
    velocity = None if velocity is None else _evenly(even, time, velocity)
    warm = _temperature(logs, lead, clocks, even)
    sources = [lead, torque, *([speed] if speed is not None else [])]
    excluded = _excluded(logs, sources, lead, clocks, even)
    return FrictionRun(info, run.moved_joint, even, angle, needed, velocity, warm, clocks, excluded)


def _excluded(
    logs: Mapping[str, Blocks], sources: Sequence[str], lead: str, clocks: Mapping[str, SourceClockOffset], even: Floats
) -> Booleans | None:
    """Return (n,) where a source's rows are excluded at times of the lead's clock; None where they never are."""
    excluded = np.zeros(even.size, dtype=np.bool_)
    for source in dict.fromkeys(sources):
        if logs[source].excluded.size:
            shift = 0.0 if source == lead else (clocks[source].value or 0.0) - (clocks[lead].value or 0.0)
            excluded |= logs[source].in_excluded(even + shift)
    return excluded if excluded.any() else None


def _temperature(
    logs: Mapping[str, Blocks], lead: str, clocks: Mapping[str, SourceClockOffset], even: Floats
) -> Floats | None:
    """Return the first logged temperature at the times of the lead's log, K; None where there is none."""
    source = _source_of(logs, "temperature")
    if source is None or (source != lead and (source not in clocks or lead not in clocks)):
        return None
    shift = 0.0 if source == lead else (clocks[source].value or 0.0) - (clocks[lead].value or 0.0)
    blocks = logs[source]
    return np.asarray(np.interp(even + shift, blocks.time, blocks.mean["temperature"][:, 0]))


def _in_common(
    time: Floats, logs: Mapping[str, Blocks], sources: list[str], lead: str, clocks: Mapping[str, SourceClockOffset]
) -> tuple[float, float]:
    """Return from when to when all sources logged, s on the lead's clock."""
    first, last = float(time[0]), float(time[-1])
    for source in sources:
        if source != lead:
            shift = (clocks[lead].value or 0.0) - (clocks[source].value or 0.0)
            first = max(first, float(logs[source].time[0]) + shift)
            last = min(last, float(logs[source].time[-1]) + shift)
    return first, last


def _evenly(even: Floats, time: Floats, values: Floats) -> Floats:
    return np.stack([np.interp(even, time, column) for column in values.T], axis=1)


def _clocks_of_manifest(run: Run, logs: Mapping[str, Blocks]) -> dict[str, SourceClockOffset]:
    """Return the clocks that are known without looking: the first source's, and what the manifest states."""
    given = {name: SourceClockOffset(value, 0.0, "given in the manifest") for name, value in run.clock_ahead_s.items()}
    return {next(iter(logs)): SourceClockOffset(0.0, 0.0), **{name: given[name] for name in logs if name in given}}


def _find_clock(
    run: Run, clocks: dict[str, SourceClockOffset], torque: str, lead: str, time: Floats, angle: Floats, blocks: Blocks
) -> None:
    """Find the torques' clock against that of the angles, one of which is known; raise where it cannot be found."""
    moving_joints = [k - 1 for k in _moving(angle)]
    offset = SourceClockOffset(None, None, "no joint moved")
    if moving_joints:
        offset = torque_clock(
            time, angle[:, moving_joints], blocks.time, blocks.mean["joints.torque"][:, moving_joints]
        )
    if offset.value is None:
        reason = f"torques and angles come from devices with clocks of their own: {offset.reason}"
        raise InputError.at(
            FaultCode.CLOCK_UNKNOWN, "campaign.toml", f"run {run.id}", reason,
            f"give {toml_text.pair('clock_ahead_s', {torque if lead in clocks else lead: 0.0})} for this run (s)",
        )  # fmt: skip
    if lead in clocks:
        clocks[torque] = SourceClockOffset((clocks[lead].value or 0.0) + offset.value, offset.std)
    else:
        clocks[lead] = SourceClockOffset((clocks[torque].value or 0.0) - offset.value, offset.std)


def _source_of(logs: Mapping[str, Blocks], signal: str) -> str | None:
    return next((name for name, blocks in logs.items() if signal in blocks.mean), None)


def _no_torque(place: str, logs: Mapping[str, Blocks]) -> InputError:
    current = _source_of(logs, "joints.current")
    if current is not None:
        return InputError.at(
            FaultCode.KEY_MISSING, "campaign.toml", f"sources.{current}.joints.torque_constant",
            f"{place} logs currents, and no torque constant is given",
            "add torque_constant = 0.8, say: N·m per ampere, one number or one per joint",
        )  # fmt: skip
    return InputError.at(
        FaultCode.SIGNAL_MISSING, "campaign.toml", place, "a friction run needs the torques of the drives",
        'add torque = "T1..T6", or current = "I1..I6" with torque_constant, say, to the joints of a source',
    )  # fmt: skip


def _on_clock(
    run: Run, logs: Mapping[str, Blocks], source: str, signal: str, lead: str, clocks: Mapping[str, SourceClockOffset]
) -> Floats:
    """Return a signal at the times of the lead's log."""
    blocks = logs[source]
    if source == lead:
        return blocks.mean[signal]
    unknown = [name for name in (source, lead) if name not in clocks]
    if unknown:
        raise InputError.at(
            FaultCode.CLOCK_UNKNOWN,
            "campaign.toml", f"run {run.id}", f"{signal} and the angles come from devices with clocks of their own",
            f"give {toml_text.pair('clock_ahead_s', {unknown[0]: 0.0})} for this run (s)",
        )  # fmt: skip
    source_time = logs[lead].time - (clocks[lead].value or 0.0) + (clocks[source].value or 0.0)
    return np.stack([np.interp(source_time, blocks.time, column) for column in blocks.mean[signal].T], axis=1)


def _check_velocity(place: str, time: Floats, angle: Floats, velocity: Floats) -> None:
    """Raise where the logged velocity is not that of the angles."""
    integrated = np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time)[:, None], axis=0)
    joint = int(np.argmax(np.ptp(angle, axis=0)))
    travel, logged = float(np.ptp(angle[:, joint])), float(np.ptp(integrated[:, joint]))
    correlation = float((angle[1:, joint] - angle[1:, joint].mean()) @ integrated[:, joint])
    if travel > LEAST_TRAVEL_RAD and (abs(logged - travel) > VELOCITY_AGREES * travel or correlation < 0.0):
        factor = (logged / travel) * (1.0 if correlation > 0.0 else -1.0)
        raise InputError.at(
            FaultCode.UNIT_IMPLAUSIBLE, "campaign.toml", f"{place}, joints.velocity",
            f"the logged velocity of joint {joint + 1} is {significant(factor)} times that of its angles",
            "check units.velocity, motor = true and the gear ratios",
        )  # fmt: skip


def moved_joints(run: FrictionRun) -> list[int]:
    """Return the joints that moved, from 1."""
    return _moving(run.angle)


def _moving(angle: Floats) -> list[int]:
    travel = np.ptp(angle, axis=0)
    least = np.maximum(LEAST_TRAVEL_RAD, TRAVEL_NOISE * np.array([noise_along_a_course(column) for column in angle.T]))
    return [int(k) + 1 for k in np.flatnonzero(travel > np.maximum(least, TRAVEL_SHARE * travel.max(initial=0.0)))]


def reduce_friction(runs: Sequence[FrictionRun], chain: Chain) -> FrictionReduction:
    """Find the steady passes of all runs, and take the rest as motion to be modelled.

    Raises
    ------
    InputError
        A run in which nothing moved, or in which the joint that the manifest names stood still.
    """
    moved_of_run = [_joints_in_motion(run, chain) for run in runs]
    passes_of_run = [
        _passes(run, k, moved_of_run[k][0]) if len(moved_of_run[k]) == 1 else ([], []) for k, run in enumerate(runs)
    ]
    # a joint that holds its velocity in one run is measured that way, and runs that never held one are dropped
    with_passes = {moved_of_run[k][0] for k, (passes, lost) in enumerate(passes_of_run) if len(passes) > len(lost)}
    passes: list[JointPass] = []
    motions: list[FreeMotion] = []
    dropped: dict[str, tuple[UnusedStretch, ...]] = {}
    warnings: list[str] = []
    for k, run in enumerate(runs):
        if len(moved_of_run[k]) == 1 and moved_of_run[k][0] in with_passes:
            passes += passes_of_run[k][0]
            dropped[run.info.name] = tuple(passes_of_run[k][1])
            warnings += _unused_warnings(run, chain, moved_of_run[k][0], passes_of_run[k][1])
            continue
        motions.append(free_motion(run.info, chain, run.time, run.angle, run.torque, run.excluded))
        names = ", ".join(chain.joint_names[j - 1] for j in moved_of_run[k])
        why = (
            "several joints move at the same time"
            if len(moved_of_run[k]) > 1
            else ("there is no phase of constant velocity")
        )
        warnings.append(
            f"run {run.info.name} ({names}): {why}, so weight and inertia are modelled and not averaged out"
        )
    steady = _steady(tuple(run.info for run in runs), passes)
    if steady is not None:
        warnings += _one_way_words(steady, chain)
    samples = None if steady is None else pass_samples(runs, passes, steady, chain)
    return FrictionReduction(steady, stacked_motion(motions) if motions else None, samples, dropped, tuple(warnings))


def _joints_in_motion(run: FrictionRun, chain: Chain) -> list[int]:
    moving = moved_joints(run)
    place = f"run {run.info.name}"
    if run.moved_joint is not None and run.moved_joint not in moving:
        name = chain.joint_names[run.moved_joint - 1]
        moving_names = ", ".join(chain.joint_names[k - 1] for k in moving)
        mend = f"joint {moving_names} moved: correct moved_joint" if moving else "check the log"
        raise InputError.at(
            FaultCode.MOTION_WRONG,
            "campaign.toml",
            f"{place}.moved_joint",
            f"joint {name} never moved in this run",
            mend,
        )
    if not moving:
        raise InputError.at(
            FaultCode.MOTION_WRONG,
            "campaign.toml",
            place,
            "no joint moved in this run",
            "check the log, or exclude the run",
        )
    return [run.moved_joint] if run.moved_joint is not None and len(moving) == 1 else moving


def _passes(run: FrictionRun, number: int, joint: int) -> tuple[list[JointPass], list[UnusedStretch]]:
    k = joint - 1
    velocity = None if run.velocity is None else run.velocity[:, k]
    steady, refused = steady_passes(JointLog(run.time, run.angle[:, k], run.torque[:, k], velocity, run.excluded))
    other_angles = run.angle.mean(axis=0)
    other_angles[k] = 0.0
    return [JointPass(steady_pass, number, joint, other_angles) for steady_pass in steady], refused


def _unused_warnings(run: FrictionRun, chain: Chain, joint: int, lost: Sequence[UnusedStretch]) -> list[str]:
    name = chain.joint_names[joint - 1]
    warnings = []
    for group in by_cause(lost):
        count = f"{len(group)} readings" if len(group) > 1 else "a reading"
        warnings.append(f"run {run.info.name}, joint {name}: {count} dropped: {cause_text(group)}")
    return warnings


def _steady(infos: tuple[RunInfo, ...], passes: Sequence[JointPass]) -> SteadyReadings | None:
    if not passes:
        return None
    readings = readings_of(passes)
    codes, texts = set_aside_columns([reading.set_aside for reading in readings])
    return SteadyReadings(
        runs=infos,
        run=np.array([reading.joint_pass.run for reading in readings], dtype=np.int64),
        joint=np.array([reading.joint_pass.joint for reading in readings], dtype=np.int64),
        velocity=np.array([reading.velocity for reading in readings]),
        torque=np.array([reading.torque for reading in readings]),
        stretch=np.array([reading.stretch for reading in readings], dtype=np.int64),
        low=np.array([reading.low for reading in readings]),
        high=np.array([reading.high for reading in readings]),
        start=np.array([float(reading.joint_pass.steady_pass.time[0]) for reading in readings]),
        end=np.array([float(reading.joint_pass.steady_pass.time[-1]) for reading in readings]),
        n_readings=np.array([reading.n_readings for reading in readings], dtype=np.int64),
        scatter=np.array([reading.scatter for reading in readings]),
        set_aside=texts,
        set_aside_code=codes,
    )


def _one_way_words(steady: SteadyReadings, chain: Chain) -> list[str]:
    """Say of which joints nothing can be determined because they moved one way only, and what else was set aside."""
    alike: dict[tuple[int, int, str, str], list[str]] = defaultdict(list)
    for joint in np.unique(steady.joint):
        of_joint = steady.joint == joint
        name = chain.joint_names[int(joint) - 1]
        for code in np.unique(steady.set_aside_code[of_joint & ~steady.used]):
            of_code = of_joint & (steady.set_aside_code == code)
            speeds = np.unique(np.abs(steady.velocity[of_code]).round(3))
            listed = ", ".join(significant(speed) for speed in speeds[:4]) + (", …" if speeds.size > 4 else "")
            found = int(of_code.sum()), int(of_joint.sum()), listed, str(steady.set_aside[of_code][0])
            alike[found].append(name)
    return [
        f"joint{'s' * (len(names) > 1)} {listing(names)}: {count} of {n_readings} readings"
        f"{' of each' * (len(names) > 1)} set aside (at {speeds_of} rad/s): {cause}"
        for (count, n_readings, speeds_of, cause), names in alike.items()
    ]

"""What `compensate` is given: a path as joint angles or poses, and the forces on it.

Forces stand in the path's own table, are one for all, come per segment, or were logged by a sensor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.toml.toml_reading import LARGEST
from stiffcal.compensation.load_table import (
    WrittenTable,
    force_mend,
    joint_doubts,
    load_doubts,
    place_doubts,
    read_table,
)
from stiffcal.compensation.table_columns import (
    ANGLES,
    AXES,
    POSITION,
    QUATERNION,
    SEGMENT,
    TIME,
    joints_in_words,
)
from stiffcal.compensation.table_doubts import angle_doubts
from stiffcal.errors import Fault, InputError, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.reduction.logs.reading_bounds import LARGEST_ANGLE_RAD, LONGEST_TRAVEL_M
from stiffcal.wording import unused_columns

if TYPE_CHECKING:
    from stiffcal.compensation.fitted_robot import FittedRobot
    from stiffcal.compensation.targets import PoseGoal
    from stiffcal.measurements.load_states import Attachment, MeasurementSetup
    from stiffcal.mechanics.chain import Chain


_MOST_FAULTS = 10
OPTION_IN_N = "the option takes N and N·m"


@dataclass(frozen=True)
class Forces:
    """Where the forces on a path come from; without any of the first three: the path's own columns Fx … Tz."""

    everywhere: str | None = None
    """"Fx,Fy,Fz" or "Fx,Fy,Fz,Tx,Ty,Tz", N and N·m, all along the path."""
    segments: Path | None = None
    """CSV with a column ``segment`` and Fx … Tz; the path has a column ``segment`` too."""
    log: Path | None = None
    """CSV with ``t`` and Fx … Tz as a sensor logged them; the path has a column ``t`` on the same clock."""
    frame: str | None = None
    """Frame whose axes the components are in and whose origin moments refer to; None: base axes, about the manifest's
    load point.
    """
    acts_on: str = "robot"
    """"environment" where the numbers are what the robot does to its surroundings."""
    filter_hz: float | None = None
    """Cut-off of a low-pass for a log's noise, run forward and backward: no delay."""
    tool: str | None = None
    """"kg,x,y,z": mass and centre (flange frame, m) of what hangs beyond the sensor, to be taken out of a log."""
    zeroed: bool = True
    """True where the sensor was zeroed in the log's first pose, tool and all."""


@dataclass(frozen=True)
class CompensationPath:
    """A path with its loads."""

    table: WrittenTable
    """The file as read."""
    joints: Floats
    """(n, L) commanded logged angles, rad."""
    goal: PoseGoal | None
    """The wanted poses where the path is given in space; None where it is given as joint angles."""
    wrench: Floats
    """(n, 6) on the robot, in the axes and about the point of ``setup``."""
    setup: MeasurementSetup
    """The set-up with those axes, that point, and the frame that follows the path as its target."""
    time: Floats | None
    """(n,) s, or None."""
    doubts: tuple[str, ...] = ()
    """What was read and may not have been meant, and columns that were not read, in words."""
    loads_from: str = ""
    """The file or option that the loads are from."""
    unit_mend: str = ""
    """What to do where the loads are in another unit; empty: theirs is stated."""


@dataclass(frozen=True)
class _Loads:
    """Loads on a path as they are given."""

    wrench: Floats
    """(n, 6)"""
    where: str
    """The file or option that they are from."""
    mend: str = ""
    """What to do where they are in another unit; empty: theirs is stated."""
    doubts: tuple[str, ...] = ()
    """What was not read of their table, in words."""


def read_path(
    fitted: FittedRobot, setup: MeasurementSetup, file: Path, forces: Forces, start: str | None
) -> CompensationPath:
    """Read a path and its forces.

    Parameters
    ----------
    fitted : the robot.
    setup : the set-up, aimed at the frame that follows the path.
    file : CSV: joints by name (degrees), or X, Y, Z (mm) with qw, qx, qy, qz or roll, pitch, yaw (degrees, about the
        fixed axes x, y, z); without an orientation that of ``start`` is kept. NonLoadRuns them Fx … Tz, t, segment.
    forces : where the forces come from.
    start : joint angles near the first pose, "A1,A2,…" in degrees; None: the middle of the joints' ranges.

    Raises
    ------
    InputError : the input is wrong, a pose is out of reach, or a joint beyond its limit.
    """
    chain = fitted.campaign.chain
    names = chain.joint_names
    asked = (*names, *POSITION, *QUATERNION, *ANGLES, *AXES, TIME)
    table = read_table(file, names, asked, (SEGMENT,), chain.prismatic_names)
    goal, doubts = None, table.unused_words
    if table.has(names):
        joints = table.block(names)
        doubts += joint_doubts(table, names, chain.prismatic_names)
        places = [name for name in (*POSITION, *QUATERNION, *ANGLES) if name in table.numbers]
        doubts += [f"{table.file}: the joint angles give the path: {words}" for words in unused_columns(places)]
        doubts += [] if start is None else ["--start is not used: the joint angles give the path"]
        _check_limits(fitted, table, joints)
    elif table.has(POSITION):
        joints, goal = _from_poses(fitted, setup, table, start)
        doubts += [] if start is None else pose_doubts(pose_of_words(start, chain, "--start"), chain, "--start")
        doubts += place_doubts(table)
    else:
        lacking = next(name for name in names if name not in table.numbers)
        of_joints = joints_in_words(names, chain.prismatic_names)
        mend = f"give a column for each of {of_joints}, or {', '.join(POSITION)} (mm)"
        raise InputError.at(FaultCode.COLUMN_MISSING, table.file, "line 1", f"no column {lacking}", mend)
    time = table.numbers.get(TIME)
    if time is not None and np.any(np.diff(time) < 0.0):
        row = int(np.argmax(np.diff(time) < 0.0)) + 1
        raise InputError.at(
            FaultCode.TIME_ORDER,
            table.file,
            f"{table.place(row)}, column t",
            "time decreases",
            "sort the rows by time",
        )
    setup = _in_frame(fitted, setup, forces)
    loads = _loads(fitted, setup, table, joints, forces)
    wrench = -loads.wrench if forces.acts_on == "environment" else loads.wrench
    return CompensationPath(table, joints, goal, wrench, setup, time, (*doubts, *loads.doubts), loads.where, loads.mend)


def _check_limits(fitted: FittedRobot, table: WrittenTable, joints: Floats) -> None:
    chain = fitted.campaign.chain
    beyond = (joints < chain.limits[:, 0]) | (joints > chain.limits[:, 1])
    doubts = _doubts_in_mend(table, joint_doubts(table, chain.joint_names, chain.prismatic_names))
    faults = []
    for row, joint in zip(*np.nonzero(beyond), strict=True):
        mark = " mm" if chain.prismatic[joint] else "°"
        low, high = chain.printed_positions(chain.limits.T)[:, joint]
        at = chain.printed_positions(joints[row])[joint]
        reason = f"{chain.joint_names[joint]} = {at:.4g}{mark} lies beyond its limits"
        faults.append(
            Fault(
                FaultCode.POSE_UNREACHABLE,
                table.file,
                table.place(row),
                reason,
                f"keep it within {low:g}{mark} … {high:g}{mark}{doubts}",
            )
        )
    raise_faults(shortened(faults))


def _doubts_in_mend(table: WrittenTable, doubts: list[str]) -> str:
    """Return as the end of a mend what a table gives reason to doubt: a refusal shows no warnings."""
    return "".join("; " + doubt.removeprefix(f"{table.file}: ") for doubt in doubts)


def shortened(faults: list[Fault]) -> list[Fault]:
    """Return the first faults of many, the last of them with how many more there are."""
    if len(faults) <= _MOST_FAULTS:
        return faults
    last = faults[_MOST_FAULTS - 1]
    more = f"{last.reason} (and {len(faults) - _MOST_FAULTS} more lines)"
    return [*faults[: _MOST_FAULTS - 1], Fault(last.code, last.file, last.place, more, last.mend)]


def _from_poses(
    fitted: FittedRobot, setup: MeasurementSetup, table: WrittenTable, start: str | None
) -> tuple[Floats, PoseGoal]:
    from stiffcal.compensation.inverse import joints_along_path, middle_of_ranges
    from stiffcal.compensation.targets import PoseGoal
    from stiffcal.mechanics.kinematics import attached_poses
    from stiffcal.mechanics.rotations import rotation_from_rpy
    from stiffcal.quaternions import rotation_from_quaternion

    chain, target = fitted.campaign.chain, setup.targets[0]
    start_angles = None if start is None else pose_of_words(start, chain, "--start")
    if table.has(QUATERNION):
        quaternion = table.block(QUATERNION)
        wrong = np.abs(np.linalg.norm(quaternion, axis=1) - 1.0) > 0.01
        if wrong.any():
            place = table.place(int(np.argmax(wrong)))
            raise InputError.at(
                FaultCode.NUMBER_INVALID,
                table.file,
                place,
                "qw, qx, qy, qz is not a unit quaternion",
                "correct the row",
            )
        rotation = rotation_from_quaternion(quaternion)
    elif table.has(ANGLES):
        rotation = rotation_from_rpy(table.block(ANGLES))
    elif (incomplete := _incomplete_orientation(table)) is not None:
        mend = f"give {', '.join(QUATERNION)}, or {', '.join(ANGLES)}, or none of them"
        raise InputError.at(FaultCode.COLUMN_MISSING, table.file, "line 1", f"no column {incomplete}", mend)
    else:
        home = middle_of_ranges(chain) if start_angles is None else start_angles
        _, home_rotation = attached_poses(chain, chain.model_angles(home[None]), target)
        rotation = np.repeat(home_rotation, len(table), axis=0)
    goal = PoseGoal(table.block(POSITION), rotation)
    joints, reached = joints_along_path(chain, target, goal, start_angles)
    if not reached.all():
        reason = "the robot does not reach this pose within its joint limits"
        mend = "move the path, or state with --start from which joint angles it is reached"
        mend += _doubts_in_mend(table, place_doubts(table))
        raise_faults(
            shortened(
                [
                    Fault(FaultCode.POSE_UNREACHABLE, table.file, table.place(row), reason, mend)
                    for row in np.flatnonzero(~reached).tolist()
                ]
            )
        )
    return joints, goal


def _incomplete_orientation(table: WrittenTable) -> str | None:
    """Return a column that is missing of an orientation of which others are there."""
    for names in (QUATERNION, ANGLES):
        lacking = [name for name in names if name not in table.numbers]
        if lacking and len(lacking) < len(names):
            return lacking[0]
    return None


def pose_doubts(angles: Floats, chain: Chain, option: str) -> list[str]:
    """Return a warning where a pose of an option, (L,) rad and m, looks like radians."""
    turning = angles[~chain.prismatic]
    return angle_doubts(turning[None], option, "it takes degrees")


def pose_of_words(text: str, chain: Chain, option: str) -> Floats:
    """Return (L,) rad (prismatic joints: m) from "A1,A2,…" in degrees (mm); raises `InputError`."""
    names = chain.joint_names
    angles = numbers_of_words(text, option)
    if len(angles) != len(names):
        reason = f"{len(angles)} angles, the robot has {len(names)} joints"
        raise InputError.at(
            FaultCode.JOINT_COUNT, "command line", option, reason, f"give {', '.join(names)} in degrees"
        )
    pose = np.asarray(chain.from_printed(np.array(angles)))
    beyond = np.abs(pose) > np.where(chain.prismatic, LONGEST_TRAVEL_M, LARGEST_ANGLE_RAD)
    if beyond.any():
        joint = int(np.argmax(beyond))
        reason = f"{angles[joint]:.6g} is no position of joint {names[joint]}"
        mend = f"give {', '.join(names)} in degrees{', mm where they slide' if chain.prismatic.any() else ''}"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", option, reason, mend)
    return pose


def numbers_of_words(text: str, option: str) -> list[float]:
    """Return the numbers of "1,2.5,…"; raises `InputError`."""
    try:
        # answers are printed with a true minus sign, and copied from there
        numbers = [float(word) for word in text.replace("−", "-").split(",")]
    except ValueError:
        numbers = [float("nan")]
    if not np.isfinite(numbers).all():
        mend = "write numbers with a point, separated by commas"
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", option, f"{text!r} contains something that is not a number", mend
        )
    too_large = [value for value in numbers if abs(value) > LARGEST]
    if too_large:
        reason = f"{too_large[0]:g} is larger than any plausible value"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", option, reason, "correct the number")
    return numbers


def _in_frame(fitted: FittedRobot, setup: MeasurementSetup, forces: Forces) -> MeasurementSetup:
    """Return the set-up whose wrench axes and point are those that the forces are given in."""
    from stiffcal.measurements.load_states import Attachment

    if forces.frame is None:
        return replace(setup, wrench_axes=Attachment(0, np.eye(4)), moments_measured=True)
    frame: Attachment = fitted.frame(forces.frame, "--frame")
    point = setup.wrench_point if frame.body == 0 else frame
    return replace(setup, wrench_axes=frame, wrench_point=point, moments_measured=True)


def _loads(fitted: FittedRobot, setup: MeasurementSetup, table: WrittenTable, joints: Floats, forces: Forces) -> _Loads:
    has_columns = any(name in table.numbers for name in AXES)
    options_given = [name for name in ("everywhere", "segments", "log") if getattr(forces, name) is not None]
    corrects_geometry = any(placed.changes_geometry for placed in fitted.robot.placed)
    if not options_given and not has_columns and corrects_geometry and forces.filter_hz is None and forces.tool is None:
        return _Loads(np.zeros((len(table), 6)), table.file)  # the calibrated robot under its own weight
    if len(options_given) + has_columns != 1:
        mend = "give the forces once: columns Fx … Tz of the path, --force, --segments or --log"
        reason = "no forces are given" if not options_given and not has_columns else "forces are given more than once"
        raise InputError.at(
            FaultCode.OPTION_CONFLICT,
            table.file if has_columns or not options_given else "command line",
            "",
            reason,
            mend,
        )
    if forces.log is None and (forces.filter_hz is not None or forces.tool is not None):
        option = "--filter" if forces.filter_hz is not None else "--tool"
        raise InputError.at(
            FaultCode.OPTION_CONFLICT,
            "command line",
            option,
            "filter and tool weight apply to logged forces only",
            "give --log FILE",
        )
    if forces.everywhere is not None:
        given = numbers_of_words(forces.everywhere, "--force")
        if len(given) not in (3, 6):
            mend = "write Fx,Fy,Fz or Fx,Fy,Fz,Tx,Ty,Tz"
            raise InputError.at(
                FaultCode.OPTION_INVALID, "command line", "--force", f"{forces.everywhere!r} is not a wrench", mend
            )
        wrench = np.repeat(np.array([given + [0.0] * (6 - len(given))]), len(table), axis=0)
        return _Loads(wrench, "--force", OPTION_IN_N)
    if forces.segments is not None:
        return _segment_loads(table, forces.segments)
    if forces.log is not None:
        return _logged(fitted, setup, table, joints, forces)
    return _Loads(table.block(AXES), table.file, force_mend(table), tuple(load_doubts(table)))


def _segment_loads(table: WrittenTable, file: Path) -> _Loads:
    if SEGMENT not in table.words:
        raise InputError.at(
            FaultCode.COLUMN_MISSING,
            table.file,
            "line 1",
            "no column segment",
            "state for each row which segment it belongs to",
        )
    listed = read_table(file, (), AXES, (SEGMENT,))
    if SEGMENT not in listed.words or not any(name in listed.numbers for name in AXES):
        raise InputError.at(
            FaultCode.COLUMN_MISSING,
            listed.file,
            "line 1",
            "no columns segment and Fx … Tz",
            "one row for each segment",
        )
    names = listed.words[SEGMENT]
    faults = [
        Fault(
            FaultCode.DATA_MISSING,
            table.file,
            table.place(row),
            f"no force for the segment {word}",
            f"add it to {listed.file}",
        )
        for row, word in enumerate(table.words[SEGMENT])
        if word not in names
    ]
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        faults.append(
            Fault(FaultCode.NAME_DUPLICATE, listed.file, "segment", f"{doubled[0]} is given twice", "leave one out")
        )
    raise_faults(shortened(faults))
    segment_of_row = [names.index(word) for word in table.words[SEGMENT]]
    return _Loads(
        listed.block(AXES)[segment_of_row],
        listed.file,
        force_mend(listed),
        (*listed.unused_words, *load_doubts(listed)),
    )


def _logged(
    fitted: FittedRobot, setup: MeasurementSetup, table: WrittenTable, joints: Floats, forces: Forces
) -> _Loads:
    """Return the forces of a log at the path's times: filtered, without the tool's weight."""
    from stiffcal.compensation.tool_weight import without_tool
    from stiffcal.mechanics.low_pass import LowPass

    assert forces.log is not None
    log = read_table(forces.log, (), (*AXES, TIME))
    if TIME not in table.numbers or TIME not in log.numbers:
        short = table if TIME not in table.numbers else log
        raise InputError.at(
            FaultCode.COLUMN_MISSING,
            short.file,
            "line 1",
            "no column t",
            "path and log need times, s, of the same clock",
        )
    moments, at = log.numbers[TIME], table.numbers[TIME]
    steps = np.diff(moments)
    if len(moments) < 2 or np.any(steps <= 0.0):
        row = int(np.argmax(steps <= 0.0)) + 1 if len(moments) > 1 else 0
        place = f"{log.place(row)}, column t"
        raise InputError.at(FaultCode.TIME_ORDER, log.file, place, "time does not increase", "sort the rows by time")
    period = float(np.median(steps))
    if at[0] < moments[0] - period or at[-1] > moments[-1] + period:
        reason = f"the path runs from {at[0]:g} s to {at[-1]:g} s, the log from {moments[0]:g} s to {moments[-1]:g} s"
        raise InputError.at(
            FaultCode.PATH_INVALID, log.file, "t", reason, "log the whole path, with the clock of the path"
        )
    readings = log.block(AXES)
    if forces.tool is not None:
        mass, com = tool_of_words(forces.tool)
        if setup.wrench_axes.body < fitted.campaign.chain.n_joints:
            mend = "name the sensor's frame with --frame"
            raise InputError.at(
                FaultCode.OPTION_CONFLICT,
                "command line",
                "--tool",
                "the log is not in axes of a sensor on the flange",
                mend,
            )
        logged = np.stack([np.interp(moments, at, joints[:, k]) for k in range(joints.shape[1])], axis=1)
        chain = fitted.campaign.chain
        sign = -1.0 if forces.acts_on == "environment" else 1.0
        weighed = without_tool(sign * readings, chain, chain.model_angles(logged), setup, (mass, com), forces.zeroed)
        readings = sign * weighed
    if forces.filter_hz is not None:
        try:
            readings = LowPass(forces.filter_hz, 1.0 / period).without_delay(readings)
        except ValueError as error:
            raise InputError.at(
                FaultCode.OPTION_INVALID, "command line", "--filter", str(error), "choose a lower cut-off"
            ) from error
    wrench = np.stack([np.interp(at, moments, readings[:, k]) for k in range(6)], axis=1)
    return _Loads(wrench, log.file, force_mend(log), (*log.unused_words, *load_doubts(log)))


def tool_of_words(text: str) -> tuple[float, Floats]:
    """Return mass, kg, and centre (3,), m, from "kg,x,y,z" of ``--tool``; raises `InputError`."""
    numbers = numbers_of_words(text, "--tool")
    if len(numbers) != 4 or numbers[0] <= 0.0:
        mend = "write kg,x,y,z: mass, and centre in the flange frame in m"
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", "--tool", f"{text!r} is not a mass with a centre", mend
        )
    return numbers[0], np.array(numbers[1:])

"""What `compensate` is given: a path as joint angles or poses, and the forces on it.

Forces stand in the path's own table, are one for all, come per segment, or were logged by a sensor.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.load_table import joint_doubts, place_doubts
from stiffcal.compensation.option_words import pose_doubts, pose_of_words
from stiffcal.compensation.path_forces import Forces, in_frame, path_loads
from stiffcal.compensation.table_columns import (
    ANGLES,
    AXES,
    POSITION,
    QUATERNION,
    SEGMENT,
    TIME,
    joints_in_words,
)
from stiffcal.compensation.table_doubts import shortened
from stiffcal.compensation.written_table import WrittenTable, read_table
from stiffcal.errors import Fault, InputError, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.wording import unused_columns

if TYPE_CHECKING:
    from stiffcal.compensation.fitted_robot import FittedRobot
    from stiffcal.compensation.targets import PoseGoal
    from stiffcal.measurements.load_states import MeasurementSetup


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
    setup = in_frame(fitted, setup, forces)
    loads = path_loads(fitted, setup, table, joints, forces)
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

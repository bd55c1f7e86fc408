"""The forces on a path: in its own table, one for all, per segment, or logged by a sensor."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.load_table import force_mend, load_doubts
from stiffcal.compensation.option_words import OPTION_IN_N, numbers_of_words, tool_of_words
from stiffcal.compensation.table_columns import (
    AXES,
    SEGMENT,
    TIME,
)
from stiffcal.compensation.table_doubts import shortened
from stiffcal.compensation.written_table import WrittenTable, read_table
from stiffcal.errors import Fault, InputError, raise_faults
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from stiffcal.compensation.fitted_robot import FittedRobot
    from stiffcal.measurements.load_states import Attachment, MeasurementSetup


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
class PathLoads:
    """Loads on a path as they are given."""

    wrench: Floats
    """(n, 6)"""
    where: str
    """The file or option that they are from."""
    mend: str = ""
    """What to do where they are in another unit; empty: theirs is stated."""
    doubts: tuple[str, ...] = ()
    """What was not read of their table, in words."""


def in_frame(fitted: FittedRobot, setup: MeasurementSetup, forces: Forces) -> MeasurementSetup:
    """Return the set-up whose wrench axes and point are those that the forces are given in."""
    from stiffcal.measurements.load_states import Attachment

    if forces.frame is None:
        return replace(setup, wrench_axes=Attachment(0, np.eye(4)), moments_measured=True)
    frame: Attachment = fitted.frame(forces.frame, "--frame")
    point = setup.wrench_point if frame.body == 0 else frame
    return replace(setup, wrench_axes=frame, wrench_point=point, moments_measured=True)


def path_loads(
    fitted: FittedRobot, setup: MeasurementSetup, table: WrittenTable, joints: Floats, forces: Forces
) -> PathLoads:
    """Return the loads on a path, wherever they are given; raises `InputError`."""
    has_columns = any(name in table.numbers for name in AXES)
    options_given = [name for name in ("everywhere", "segments", "log") if getattr(forces, name) is not None]
    corrects_geometry = any(placed.changes_geometry for placed in fitted.robot.placed)
    if not options_given and not has_columns and corrects_geometry and forces.filter_hz is None and forces.tool is None:
        return PathLoads(np.zeros((len(table), 6)), table.file)  # the calibrated robot under its own weight
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
        return PathLoads(wrench, "--force", OPTION_IN_N)
    if forces.segments is not None:
        return _segment_loads(table, forces.segments)
    if forces.log is not None:
        return _logged(fitted, setup, table, joints, forces)
    return PathLoads(table.block(AXES), table.file, force_mend(table), tuple(load_doubts(table)))


def _segment_loads(table: WrittenTable, file: Path) -> PathLoads:
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
    return PathLoads(
        listed.block(AXES)[segment_of_row],
        listed.file,
        force_mend(listed),
        (*listed.unused_words, *load_doubts(listed)),
    )


def _logged(
    fitted: FittedRobot, setup: MeasurementSetup, table: WrittenTable, joints: Floats, forces: Forces
) -> PathLoads:
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
    return PathLoads(wrench, log.file, force_mend(log), (*log.unused_words, *load_doubts(log)))

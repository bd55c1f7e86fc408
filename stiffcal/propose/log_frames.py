"""The frames that the sources of a folder of logs name: what no log states of them is a line to fill in."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.propose.further_logs import FurtherLog
from stiffcal.propose.lines import (
    FORCE_SENSOR,
    LOAD_POINT,
    TARGET,
    TOOL,
    TRACKER,
    FrameNames,
    ProposedLine,
    frame_table,
    question_line,
)
from stiffcal.propose.log_devices import LoggingDevice, together


def frame_names(tool: Sequence[float] | None) -> FrameNames:
    """Return the frames of load and displacement: one where the tool point is given, else one each to be filled in."""
    point, body = (LOAD_POINT, TARGET) if tool is None else (TOOL, TOOL)
    return FrameNames(body, point, FORCE_SENSOR)


def frames_of_logs(
    devices: Sequence[LoggingDevice], missing: Sequence[FurtherLog], tool: Sequence[float] | None
) -> list[ProposedLine]:
    """Return the frames that the sources name."""
    named = {frame for device in devices for line in device.kind.signals for frame in line.frames}
    named |= {
        TOOL if tool and frame in (LOAD_POINT, TARGET) else frame for signal in missing for frame in signal.frames
    }
    roles = together(devices)
    known = None if tool is None else f"xyz_m = [{', '.join(map(repr, tool))}]"
    lines: list[ProposedLine] = []
    for frame in (TOOL, LOAD_POINT, TARGET):
        if frame == TARGET and {TARGET, TRACKER} <= named:
            lines += [*frame_table(frame, "flange"), ProposedLine("estimate = true", f"{_FOUND}, as designed")]
        elif frame in named:
            where = _WHERE[TARGET if frame == TOOL and roles.mass is None and roles.force is None else frame]
            both = "of load and target both; where they differ, write a frame for each" if roles.force else None
            lines += [
                *frame_table(frame, "flange"),
                ProposedLine(known, both) if known else question_line(frame, "xyz_m", where),
            ]
    if FORCE_SENSOR in named:
        where = "origin of the force sensor's axes, from which it counts moments, x, y, z in m in the flange frame"
        asked = question_line(FORCE_SENSOR, "xyz_m", where)
        origin = ProposedLine("xyz_m = [0.0, 0.0, 0.0]") if roles.moment is None else asked
        lines += [*frame_table(FORCE_SENSOR, "flange"), origin, question_line(FORCE_SENSOR, "rpy_deg", _TURNED)]
    if TRACKER in named:
        lines += [
            *frame_table(TRACKER, "base"),
            ProposedLine("estimate = true", f"{_FOUND} and rpy_deg, as calibrated"),
        ]
    if roles.force is not None:
        lines += map(ProposedLine, _TOOL_MASS)
    return lines


_FOUND = "found from the unloaded poses; or give xyz_m"
_TOOL_MASS = (
    "",
    "# [tool]                       # what hangs on the flange, for the sag under its weight",
    "# mass_kg = 12.0",
    "# com_m = [0.0, 0.0, 0.09]     # its centre of mass, in the flange frame",
)


_WHERE = {
    TOOL: "where the load acts and the displacement is measured, x, y, z in m in the flange frame",
    LOAD_POINT: "where the force acts, x, y, z in m in the flange frame",
    TARGET: "where the displacement is measured, x, y, z in m in the flange frame",
}


_TURNED = "how the force sensor is turned on the flange, about its fixed x, y, z in degrees; 0, 0, 0 where it is not"

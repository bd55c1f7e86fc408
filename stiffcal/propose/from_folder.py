"""`init --from FOLDER`: a campaign proposed from a folder of logs, a source for each device that wrote them.

Files whose columns are the same come from one device; what their names share with those of the other devices is the
run's (`run_names`). What no log states, as where the target sits, is a line to write, and asked for at a terminal.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from stiffcal.campaign.file_formats import format_of
from stiffcal.campaign.naming import MANIFEST_FILE
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.from_table import Proposal, arm_of_given, check_robot_fits, robot_text, write_proposal
from stiffcal.propose.lines import (
    FORCE_SENSOR,
    TOOL,
    TRACKER,
    FrameNames,
    ProposedLine,
    Question,
    as_text,
)
from stiffcal.propose.log_devices import LoggingDevice, of_use, runs_of, sorted_files, together, with_patterns
from stiffcal.propose.table_sniffing import SniffedColumn
from stiffcal.propose.urdf_arm import UrdfArm

LOAD_POINT, TARGET, RAW = "load_point", "target", "raw"

Ask = Callable[[Question], str]


def propose_from_folder(
    folder: Path,
    logs: Path,
    *,
    urdf: Path | None = None,
    robot: str | None = None,
    tool: Sequence[float] | None = None,
    ask: Ask | None = None,
    overwrite: bool = False,
) -> Proposal:
    """Write a proposed campaign folder: manifest, robot file, and the logs in ``raw/`` where they lie elsewhere.

    Parameters
    ----------
    folder : made where it does not exist.
    overwrite : also files in it. Others as in `draft_from_folder`.

    Returns
    -------
    Proposal
        With the files that were written.

    Raises
    ------
    InputError
        As `draft_from_folder`; or the folder holds a campaign already.
    """
    place = _place_in(folder, logs)
    draft = draft_from_folder(logs, RAW if place is None else place, urdf=urdf, robot=robot, tool=tool, ask=ask)
    if place is not None:
        extra = {name: path for name, path in draft.copies.items() if not path.is_relative_to(logs)}
        draft = replace(draft, copies=extra)
    return write_proposal(folder, draft, overwrite=overwrite)


def draft_from_folder(
    logs: Path,
    place: str = RAW,
    *,
    urdf: Path | None = None,
    robot: str | None = None,
    tool: Sequence[float] | None = None,
    ask: Ask | None = None,
) -> Proposal:
    """Propose a campaign of load runs from a folder of logs.

    Parameters
    ----------
    logs : the folder. Files whose names begin with a point are not looked at.
    place : where the logs lie in the campaign folder, "" in itself.
    urdf : the robot as a URDF; ignored where ``robot`` is given too.
    robot : the name of a bundled robot, or the path of a robot file. With neither, robot.toml holds rows to fill in.
    tool : where the load acts and the displacement is measured, m, in the flange frame; None: two frames to fill in.
    ask : called with a question for three numbers, returns the answer or ""; None: the lines are left to be written.

    Raises
    ------
    InputError
        No logs of joints, forces and displacements are there, their names hold no run, or they do not fit the robot.
    """
    names = _frame_names(tool)

    def joints_of(columns: Sequence[SniffedColumn]) -> Sequence[SniffedColumn]:
        try:
            return arm_of_given(urdf, robot, columns).columns
        except InputError:  # of another device: whether the joints fit is judged when all devices are known
            return ()

    devices, unused = with_patterns(*of_use(sorted_files(logs, place, joints_of, names), names), place)
    runs, unpaired = runs_of(devices)
    lines = [
        *map(ProposedLine, ('schema = "stiffcal/campaign/1"', 'robot = "robot.toml"')),
        *_answered(_frame_lines(devices, tool), ask),
        *(line for device in devices for line in _source_lines(device)),
    ]
    if not any(device.pattern for device in devices):
        files = {device.name: device.files[0] for device in devices}
        lines += [
            *map(ProposedLine, ("", "[[runs]]", 'id = "run1"')),
            ProposedLine(f"files = {{ {', '.join(toml_text.pair(*entry) for entry in files.items())} }}"),
        ]
    roles = together(devices)
    arm = arm_of_given(urdf, robot, roles.joints.columns) if roles.joints is not None else UrdfArm((), ())
    text, extra, rows = robot_text(roles, urdf, robot, arm)
    marked = [(MANIFEST_FILE, line) for line in lines] + [("robot.toml", line) for line in rows]
    used = {file for device in devices for file in device.files}
    proposal = Proposal(
        as_text(lines),
        text,
        {file: logs / _within(file, place) for file in sorted(used)} | extra,
        tuple(f"{file}: {line}" for file, line in marked if line.doubt is not None and line.question is None),
        tuple(column.header for device in devices for column in device.kind.roles.unused),
        roles=roles,
        to_write=_to_write(lines, urdf is not None or robot is not None),
        runs=tuple(runs),
        remarks=(*unpaired, *unused),
    )
    check_robot_fits(proposal, roles, urdf)
    return proposal


def _place_in(folder: Path, logs: Path) -> str | None:
    """Return where the logs lie in the campaign folder, None where they lie elsewhere."""
    try:
        inside = logs.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError:
        return None
    return "" if inside == "." else inside


def _within(file: str, place: str) -> str:
    return file[len(place) + 1 :] if place else file


def _frame_names(tool: Sequence[float] | None) -> FrameNames:
    point, body = (LOAD_POINT, TARGET) if tool is None else (TOOL, TOOL)
    return FrameNames(body, point, FORCE_SENSOR)


def _source_lines(device: LoggingDevice) -> list[ProposedLine]:
    kind = device.kind
    lines = [ProposedLine(""), ProposedLine(f"[sources.{device.name}]")]
    if device.pattern:
        lines.append(ProposedLine(toml_text.pair("file", device.pattern)))
    if format_of(device.files[0]) != kind.format:
        lines.append(ProposedLine(toml_text.pair("format", kind.format)))
    stated = sorted(device.encodings - {""})
    options = {key: value for key, value in kind.options.items() if key != "encoding"}
    if stated:
        options["encoding"] = stated[0]
    lines += replace(kind, options=options).options_line
    states = kind.roles.deflection is not None and kind.roles.time is None
    lines += [ProposedLine('sampling = "states"')] if states else [kind.time] if kind.time is not None else []
    return [*lines, *kind.signals]


def _frame_lines(devices: Sequence[LoggingDevice], tool: Sequence[float] | None) -> list[ProposedLine]:
    """Return the frames that the sources name."""
    named = {frame for device in devices for line in device.kind.signals for frame in line.frames}
    roles = together(devices)
    known = None if tool is None else f"xyz_m = [{', '.join(map(repr, tool))}]"
    lines: list[ProposedLine] = []
    for frame in (TOOL, LOAD_POINT, TARGET):
        if frame in named:
            where = _WHERE[frame if roles.force is not None else TARGET]
            lines += [*_table(frame, "flange"), ProposedLine(known) if known else _question(frame, "xyz_m", where)]
    if FORCE_SENSOR in named:
        where = "origin of the force sensor's axes, from which it counts moments, x, y, z in m in the flange frame"
        origin = (
            ProposedLine("xyz_m = [0.0, 0.0, 0.0]") if roles.moment is None else _question(FORCE_SENSOR, "xyz_m", where)
        )
        lines += [*_table(FORCE_SENSOR, "flange"), origin, _question(FORCE_SENSOR, "rpy_deg", _TURNED)]
    if TRACKER in named:
        doubt = "found from the unloaded poses; or give xyz_m and rpy_deg, as calibrated"
        lines += [*_table(TRACKER, "base"), ProposedLine("estimate = true", doubt)]
    return lines


_WHERE = {
    TOOL: "where the load acts and the displacement is measured, x, y, z in m in the flange frame",
    LOAD_POINT: "where the force acts, x, y, z in m in the flange frame",
    TARGET: "where the displacement is measured, x, y, z in m in the flange frame",
}
_TURNED = "how the force sensor is turned on the flange, about its fixed x, y, z in degrees; 0, 0, 0 where it is not"


def _question(frame: str, key: str, what: str) -> ProposedLine:
    return ProposedLine(f"{key} = []", f"to be filled in: {what}", question=Question(f"frames.{frame}", key, what))


def _table(frame: str, parent: str) -> list[ProposedLine]:
    return [ProposedLine(text) for text in ("", f"[frames.{frame}]", toml_text.pair("parent", parent))]


def _answered(lines: Sequence[ProposedLine], ask: Ask | None) -> list[ProposedLine]:
    """Return the lines with the answers of a person, where one is asked and gives some."""
    answered = []
    for line in lines:
        text = ask(line.question) if ask is not None and line.question is not None else ""
        if text and line.question is not None:
            line = ProposedLine(f"{line.question.key} = [{', '.join(map(repr, three_numbers(text)))}]")
        answered.append(line)
    return answered


def three_numbers(text: str) -> tuple[float, ...]:
    """Read ``X,Y,Z``.

    Raises
    ------
    InputError : these are not three numbers.

    Examples
    --------
    >>> three_numbers("0, 0 0.2")
    (0.0, 0.0, 0.2)
    """
    try:
        numbers = tuple(float(word) for word in text.replace(",", " ").replace(";", " ").split())
    except ValueError:
        numbers = ()
    if len(numbers) != 3:
        raise InputError.at(FaultCode.VALUE_INVALID, "answer", "", f"found {text!r}", "give three numbers: X, Y, Z")
    return numbers


def _to_write(lines: Sequence[ProposedLine], has_robot: bool) -> tuple[str, ...]:
    """Return what a person has to write: each line with its file and table."""
    written = [
        f"{MANIFEST_FILE} [{line.question.table}] {line.question.key} = [x, y, z]  # {line.question.text}"
        for line in lines
        if line.question is not None
    ]
    return tuple(written if has_robot else [*written, _ROWS])


_ROWS = "robot.toml [[joints]] a_m, alpha_deg, d_m, theta_deg of each; or begin again with --robot NAME or --urdf FILE"

"""`init --from FOLDER`: a campaign proposed from logs, a source for each device that wrote them.

Files whose columns are the same come from one device; what their names share with those of the other devices is the
run's (`run_names`). What no log states, as where the target sits, is a line to write, and asked for at a terminal.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from stiffcal.campaign.found.file_formats import format_of
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.reach import leads_outside
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.answers import Ask, answered, to_write_by_hand
from stiffcal.propose.column_roles import Roles
from stiffcal.propose.explained_column import ExplainedColumn
from stiffcal.propose.from_table import (
    Proposal,
    arm_of_given,
    chain_of_given,
    check_robot_fits,
    robot_text,
    write_proposal,
)
from stiffcal.propose.further_logs import FURTHER, lacking_signals
from stiffcal.propose.lines import ProposedLine, as_text
from stiffcal.propose.log_devices import (
    MOST_NAMED,
    JointsOf,
    LoggingDevice,
    files_in,
    of_use,
    runs_of,
    sorted_files,
    together,
    with_patterns,
)
from stiffcal.propose.log_frames import frame_names, frames_of_logs
from stiffcal.propose.log_kind import log_kind, unfilled_time
from stiffcal.propose.noise import sigma_of_logs
from stiffcal.propose.table_purpose import serves_absolute
from stiffcal.propose.table_sniffing import SniffedColumn
from stiffcal.propose.templates import chosen_robot, robot_template
from stiffcal.propose.unnamed_columns import open_columns

RAW = "raw"


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


def propose_of_logs(
    folder: Path,
    logs: Sequence[Path],
    *,
    urdf: Path | None = None,
    robot: str | None = None,
    tool: Sequence[float] | None = None,
    ask: Ask | None = None,
    overwrite: bool = False,
) -> Proposal:
    """Write a proposed campaign folder of single logs, copied into ``raw/``; as `propose_from_folder`.

    Raises
    ------
    InputError
        As `draft_of_logs`; two logs have one name, or the folder holds a campaign already.
    """
    files = {f"{RAW}/{path.name}": path for path in logs}
    if len(files) < len(logs):
        reason, mend = "two logs have the same name", "give each log a unique name, or give their folder"
        raise InputError.at(FaultCode.OPTION_CONFLICT, "command line", "--from", reason, mend)
    draft = draft_of_logs(files, urdf=urdf, robot=robot, tool=tool, ask=ask)
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
    urdf : the robot as a URDF; not where `robot` is given too.
    robot : the name of a bundled robot, or the path of a robot file. With neither, robot.toml holds rows to fill in.
    tool : where the load acts and the displacement is measured, m, in the flange frame; None: two frames to fill in.
    ask : called with a question for three numbers, returns the answer or ""; None: the lines are left to be written.

    Raises
    ------
    InputError
        As `draft_of_logs`.
    """
    files, links = {}, []
    for file in files_in(logs):
        if leads_outside(logs, file) is not None:
            links.append(f"{file}: a link out of the folder: not used")
        else:
            files[f"{place}/{file}" if place else file] = logs / file
    if not files:
        reason = "; ".join(links) or "the folder holds no log"
        mend = "copy the logs of your instruments into it, or correct the path after --from"
        raise InputError.at(FaultCode.FILE_MISSING, str(logs), "", reason, mend)
    draft = draft_of_logs(files, place, urdf=urdf, robot=robot, tool=tool, ask=ask, given=str(logs))
    return replace(draft, remarks=(*draft.remarks, *links))


def are_logs(tables: Sequence[Path], urdf: Path | None = None, robot: str | None = None) -> bool:
    """Return whether files are logs over time that no load state can be made of without those of other instruments."""
    chain = chain_of_given(urdf, robot)
    kinds = [log_kind(path, path.name, frame_names(None), _joints_of(urdf, robot), chain) for path in tables]
    if any(kind.why_not for kind in kinds):
        return False
    roles = together([LoggingDevice(part) for kind in kinds for part in (kind, *kind.further)])
    lacking = lacking_signals(roles)
    # without times it may be a table of load states whose columns have other names, unless it is one instrument's alone
    over_time = all(kind.time is not None for kind in kinds)
    # tables of states that belong together are equally long; clocks of their own make logs that are not
    lengths = {len(kind.roles.time.values) for kind in kinds if kind.roles.time is not None}
    if over_time and len(kinds) > 1 and len(lengths) > 1:
        return True
    return len(lacking) >= (1 if over_time else 2) and not serves_absolute(roles)


def is_table_of_runs(table: Path, urdf: Path | None = None, robot: str | None = None) -> bool:
    """Return whether a file names the run of each of its rows: it is all of a campaign, and not the log of one run."""
    kind = log_kind(table, table.name, frame_names(None), _joints_of(urdf, robot), chain_of_given(urdf, robot))
    return not kind.why_not and kind.roles.run is not None


def draft_of_logs(
    files: Mapping[str, Path],
    place: str = RAW,
    *,
    urdf: Path | None = None,
    robot: str | None = None,
    tool: Sequence[float] | None = None,
    ask: Ask | None = None,
    given: str = "",
) -> Proposal:
    """Propose a campaign of load runs from logs; what the logs of further instruments have to hold is left to be added.

    Parameters
    ----------
    files : name in the campaign folder to the file, in natural order.
    given : the folder of the logs as it was given, for messages. Others as in `draft_from_folder`.

    Raises
    ------
    InputError
        There is no log, the files' names hold no run, or the joints do not fit the robot.
    """
    names = frame_names(tool)
    found = sorted_files(files, _joints_of(urdf, robot), names, chain_of_given(urdf, robot))
    devices, unused = with_patterns(*of_use(found, names), place)
    if not devices:
        reason = f"no log is recognised: {'; '.join(unused[:MOST_NAMED])}"
        mend = "give logs with a line of column names: A1 … A6, Fx, Fy, Fz, X, Y, Z"
        raise InputError.at(FaultCode.FILE_MISSING, given or place or "the folder", "", reason, mend)
    runs, unpaired = runs_of(devices)
    roles = together(devices)
    missing = [signal for signal in FURTHER if signal.name in lacking_signals(roles)]
    lines = [
        *map(ProposedLine, ('schema = "stiffcal/campaign/1"', 'robot = "robot.toml"')),
        *frames_of_logs(devices, missing, tool),
        *(line for device in devices for line in _source_lines(device)),
        *(ProposedLine(line) for signal in missing for line in signal.lines),
    ]
    lines = answered(lines, ask)
    if not any(device.pattern for device in devices):
        named = {device.name: device.files[0] for device in devices}
        lines += [
            *map(ProposedLine, ("", "[[runs]]", toml_text.pair("id", runs[0]))),
            ProposedLine(f"files = {{ {', '.join(toml_text.pair(*entry) for entry in named.items())} }}"),
        ]
    text, extra, rows = _robot(roles, urdf, robot)
    has_robot = urdf is not None or robot is not None
    guessed = _guessed(MANIFEST_FILE, lines)
    if has_robot:  # else the rows are to be written
        guessed += _guessed("robot.toml", rows)
    used = {file for device in devices for file in device.files}
    proposal = Proposal(
        as_text(lines),
        text,
        {file: path for file, path in files.items() if file in used} | extra,
        tuple(guessed),
        roles=roles,
        columns=_columns(devices),
        to_write=to_write_by_hand(lines, missing, has_robot),
        runs=tuple(runs),
        remarks=(*unpaired, *unused),
    )
    if roles.joints is not None:
        check_robot_fits(proposal, roles, urdf)
    return proposal


def _columns(devices: Sequence[LoggingDevice]) -> tuple[ExplainedColumn, ...]:
    """Return the columns of the devices' files, one entry each where a file is several sources."""
    columns = {
        (device.files[0], column.column): replace(column, file=device.files[0])
        for device in devices
        for column in device.kind.columns
    }
    return tuple(columns.values())


def _guessed(file: str, lines: Sequence[ProposedLine]) -> list[str]:
    """Return the lines that were guessed, with their file and table."""
    table, guessed = "", []
    for line in lines:
        table = line.toml if line.toml.startswith("[") else table
        if line.doubt is not None and line.question is None:
            guessed.append(f"{' '.join(filter(None, (file, table)))}: {line}")
    return guessed


def _joints_of(urdf: Path | None, robot: str | None) -> JointsOf:
    def joints_of(columns: Sequence[SniffedColumn]) -> Sequence[SniffedColumn]:
        try:
            return arm_of_given(urdf, robot, columns).columns
        except InputError:  # of another device: whether the joints fit is judged when all devices are known
            return ()

    return joints_of


def _robot(roles: Roles, urdf: Path | None, robot: str | None) -> tuple[str, dict[str, Path], Sequence[ProposedLine]]:
    if roles.joints is None:  # a URDF's chain is chosen by the columns of the joints
        return (robot_template() if robot is None else chosen_robot(robot)), {}, []
    return robot_text(roles, urdf, robot, arm_of_given(urdf, robot, roles.joints.columns))


def _place_in(folder: Path, logs: Path) -> str | None:
    """Return where the logs lie in the campaign folder, None where they lie elsewhere."""
    try:
        inside = logs.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError:
        return None
    return "" if inside == "." else inside


def _source_lines(device: LoggingDevice) -> list[ProposedLine]:
    kind = device.kind
    lines = [ProposedLine(""), ProposedLine(f"[sources.{device.name}]")]
    if device.pattern:
        lines.append(ProposedLine(toml_text.pair("file", device.pattern)))
    if format_of(device.files[0]) != kind.format:
        lines.append(ProposedLine(toml_text.pair("format", kind.format)))
    lines += [line for own in (kind, *device.also) for line in own.options_line]
    states = kind.roles.deflection is not None and kind.roles.time is None
    lines.append(ProposedLine('sampling = "states"') if states else kind.time or unfilled_time(device.name))
    lines += [kind.rows] if kind.rows is not None else []
    lines += [*kind.signals, *sigma_of_logs(kind.signals)]
    return [*lines, *(ProposedLine("", sentence) for sentence in open_columns(kind.roles))]

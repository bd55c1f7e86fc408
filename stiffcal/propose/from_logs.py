"""`init --kind clamped|friction --from`: a campaign proposed from logs of drives, every guess marked with ``# ?``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from stiffcal.campaign.model.model_file import default_model_text
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.drive_columns import (
    CURRENT,
    POSITION,
    TEMPERATURE,
    TORQUE,
    VELOCITY,
    DriveColumns,
    as_roles,
    drive_columns,
)
from stiffcal.propose.explained import explained
from stiffcal.propose.explained_column import ExplainedColumn
from stiffcal.propose.from_table import (
    Proposal,
    arm_of_given,
    check_robot_fits,
    remarks_of_tables,
    robot_text,
    write_proposal,
)
from stiffcal.propose.lines import FORCE_SENSOR, ProposedLine, as_text
from stiffcal.propose.other_tables import table_of
from stiffcal.propose.role_units import LARGEST_RADIAN, columns_text, unit_of_role
from stiffcal.propose.signal_lines import signal_lines
from stiffcal.propose.table_sniffing import SniffedTable
from stiffcal.propose.time_lines import time_line

CLAMPED, FRICTION = "clamped", "friction"
KINDS_OF_LOGS = (CLAMPED, FRICTION)
"""The kinds of experiment whose campaigns are proposed from logs of drives."""

# Of the travel of the joint that moves most: what another has to travel to have been moved too.
_TRAVEL_SHARE = 0.05
_ENDINGS = re.compile(r"(\.(csv|txt|dat|log|asc|tsv))?(\.gz)?$", re.IGNORECASE)
_SIMPLEST = "# The simplest model of these runs: `stiffcal improve` adds the effects that the logs show beyond it.\n"


@dataclass(frozen=True)
class _Log:
    """A file, and what its columns are."""

    path: Path
    table: SniffedTable
    drives: DriveColumns

    @property
    def stem(self) -> str:
        """The file's name without its endings."""
        return _ENDINGS.sub("", self.path.name)

    @property
    def layout(self) -> tuple[object, ...]:
        """What files of one source have in common: columns, and what the manifest says of their format."""
        return (*(column.header for column in self.table.columns), *sorted(self.table.options.items()))


@dataclass(frozen=True)
class _ProposedRun:
    """A run: its name, and the log of each source."""

    name: str
    logs: Mapping[str, _Log]


def propose_from_logs(
    folder: Path,
    kind: str,
    tables: Sequence[Path],
    *,
    urdf: Path | None = None,
    robot: str | None = None,
    overwrite: bool = False,
) -> Proposal:
    """Write a proposed campaign folder: manifest, robot file, the simplest model of the kind, and the logs in ``raw/``.

    Parameters
    ----------
    folder : made where it does not exist. overwrite : also files in it. Others as in `draft_from_logs`.

    Returns
    -------
    Proposal
        With the files that were written.

    Raises
    ------
    InputError
        As `draft_from_logs`; or the folder holds a campaign already.
    """
    return write_proposal(folder, draft_from_logs(kind, tables, urdf=urdf, robot=robot), overwrite=overwrite)


def draft_from_logs(
    kind: str, tables: Sequence[Path], *, urdf: Path | None = None, robot: str | None = None
) -> Proposal:
    r"""Propose a campaign of clamped or friction runs from their logs.

    Parameters
    ----------
    kind : "clamped" or "friction".
    tables : logs over time with a header. Each is a run where all have the same columns; logs of several devices
        (different columns) belong together by name: ``a_ft.csv`` and ``a_drive.csv`` are run ``a``.
    urdf : the robot as a URDF; not where `robot` is given too.
    robot : the name of a bundled robot. With neither, robot.toml is that of a bench with one joint, or holds rows to
        fill in.

    Raises
    ------
    InputError
        Columns that the kind needs are not recognised, the logs do not go together, or do not fit the robot.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "p1.csv"
    >>> _ = path.write_text("t [s],angle [deg],torque [Nm]\n0,0,1\n0.1,0.01,2\n")
    >>> print(draft_from_logs("clamped", [path]).manifest.splitlines()[6])
    position = ["angle [deg]"]
    """
    tables = list(tables)
    sniffed = [table_of(path) for path in tables]
    arm = arm_of_given(urdf, robot, [column for table in sniffed for column in table.columns])
    logs = [
        _Log(path, table, drive_columns(table.columns, [c for c in arm.columns if c in table.columns]))
        for path, table in zip(tables, sniffed, strict=True)
    ]
    sources = _sources(logs)
    _check_signals(kind, sources)
    runs = _runs(logs, sources)
    firsts = {name: members[0] for name, members in sources.items()}
    leading = next(log for log in firsts.values() if log.drives.signals)
    count = len(next(iter(leading.drives.signals.values())))
    moved = [_moved_joints(run) for run in runs]
    lines = [*map(ProposedLine, ('schema = "stiffcal/campaign/1"', 'robot = "robot.toml"'))]
    if any(log.drives.wrench.force is not None for log in firsts.values()):
        lines += [
            *map(ProposedLine, ("", f"[frames.{FORCE_SENSOR}]", 'parent = "flange"')),
            ProposedLine(
                "xyz_m = [0.0, 0.0, 0.0]", "where the sensor measures; add rpy_deg (or quaternion_wxyz) if turned"
            ),
        ]
    for name, log in firsts.items():
        lines += _source_lines(name, log)
    for run, joints in zip(runs, moved, strict=True):
        lines += _run_lines(kind, run, joints, count)
    motor = any(log.drives.motor for log in firsts.values())
    roles = as_roles(leading.drives)
    text, extra, rows = robot_text(roles, urdf, robot, arm)
    if count == 1 and urdf is None and robot is None:
        rows = _bench_lines(motor)
        text = as_text(rows)
    copies = {f"raw/{log.path.name}": log.path for log in logs}
    marked = [f"{MANIFEST_FILE}: {line}" for line in lines if line.doubt is not None]
    marked += [f"robot.toml: {line}" for line in rows if line.doubt is not None]
    measured = sorted({joint for joints in moved for joint in joints}) or list(range(1, count + 1))
    model = _model_text(kind, measured)
    proposal = Proposal(
        as_text(lines),
        text,
        copies | extra,
        tuple(marked),
        model=model,
        remarks=remarks_of_tables(sniffed),
        columns=tuple(column for log in firsts.values() for column in _explained(log)),
    )
    check_robot_fits(proposal, roles, urdf)
    return proposal


def _explained(log: _Log) -> list[ExplainedColumn]:
    """Return every column of a log with what it is taken for."""
    drives = log.drives
    unused = {CURRENT} if TORQUE in drives.signals else set()
    taken = {c.header: name for name, own in drives.signals.items() for c in own if name not in unused}
    taken |= {column.header: TEMPERATURE for column in drives.temperature}
    others = Roles(force=drives.wrench.force, moment=drives.wrench.moment, time=drives.time)
    return [
        replace(entry, taken_as=taken[entry.column], why="its name" + (", its unit" if entry.unit else ""))
        if entry.column in taken
        else entry
        for entry in explained([log.table], others)
    ]


def _model_text(kind: str, joints: Sequence[int]) -> str:
    """Return the default model of the kind, for the joints that were moved."""
    text = default_model_text({kind}).replace('joints = "all"', f"joints = {list(joints)}")
    return _SIMPLEST + text[text.index("schema") :]


def _sources(logs: Sequence[_Log]) -> dict[str, list[_Log]]:
    """Return the logs of each device, by the name of its source: logs of equal columns come from one device."""
    twice = {log.path.name for log in logs if sum(other.path.name == log.path.name for other in logs) > 1}
    if twice:
        name = min(twice)
        raise InputError.at(
            FaultCode.OPTION_CONFLICT, name, "--from", "two logs have this name", "give each log a unique name"
        )
    by_layout: dict[tuple[object, ...], list[_Log]] = {}
    for log in logs:
        by_layout.setdefault(log.layout, []).append(log)
    groups = list(by_layout.values())
    if len(groups) == 1:
        return {"log": groups[0]}
    named: dict[str, list[_Log]] = {}
    for group in groups:
        devices = {_device(log.stem) for log in group}
        device = next(iter(devices))
        if len(devices) > 1 or not device or device in named:
            other = groups[0][0] if group is not groups[0] else groups[1][0]
            reason = f"its columns differ from those of {other.path.name}"
            mend = (
                "name logs of several devices RUN_DEVICE (a_ft.csv, a_drive.csv), or export all with the same columns"
            )
            raise InputError.at(FaultCode.SHAPE_MISMATCH, group[0].path.name, "header", reason, mend)
        named[device] = group
    return named


def _device(stem: str) -> str:
    """Return what follows the last underscore of a file's name, as the name of a source; "" where there is none."""
    return _as_name(stem.rpartition("_")[2]) if "_" in stem else ""


def _as_name(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9_-]+", "-", text).strip("-")


def _runs(logs: Sequence[_Log], sources: Mapping[str, Sequence[_Log]]) -> list[_ProposedRun]:
    source_of = {id(log): name for name, members in sources.items() for log in members}
    members_of: dict[str, dict[str, _Log]] = {}
    for log in logs:
        name = _as_name(log.stem if len(sources) == 1 else log.stem.rpartition("_")[0]) or "run"
        members = members_of.setdefault(name, {})
        if source_of[id(log)] in members:
            raise InputError.at(
                FaultCode.KEY_CONFLICT, log.path.name, "", f'another log also gives a run "{name}"',
                "give each log a unique name, of letters and digits",
            )  # fmt: skip
        members[source_of[id(log)]] = log
    for name, members in members_of.items():
        lacking = sorted(set(sources) - set(members))
        if lacking:
            log = next(iter(members.values()))
            reason = f'run "{name}" has no log of {lacking[0]}'
            mend = f"add --from {name}_{lacking[0]}{_ENDINGS.search(log.path.name)[0]}"  # type: ignore[index]
            raise InputError.at(FaultCode.FILE_MISSING, log.path.name, "", reason, mend)
    return [_ProposedRun(name, members) for name, members in members_of.items()]


def _check_signals(kind: str, sources: Mapping[str, Sequence[_Log]]) -> None:
    """Raise where motion or load of the joints are not recognised in any of the logs."""
    drives = [members[0].drives for members in sources.values()]
    signals = {signal for columns in drives for signal in columns.signals}
    names = ", ".join(members[0].path.name for members in sources.values())
    has_force = kind == CLAMPED and any(columns.wrench.force is not None for columns in drives)
    moves = POSITION in signals or (kind == FRICTION and VELOCITY in signals)
    if not moves:
        raise _missing(names, "no joint angles are recognised", "name them angle, or A1 … A6, J1 …, q1 …")
    if not has_force and not signals & {TORQUE, CURRENT}:
        what = "torque or current" + (", or of forces (Fx, Fy, Fz, Tx, Ty, Tz)" if kind == CLAMPED else "")
        raise _missing(
            names, f"no columns of {what} are recognised", "name them torque or current, or T1 … T6, I1 … I6"
        )
    counts = {len(columns) for each in drives for columns in each.signals.values()}
    if len(counts) > 1:
        raise InputError.at(
            FaultCode.SHAPE_MISMATCH, names, "header", "signals have different numbers of joints",
            "export the same joints of every signal",
        )  # fmt: skip


def _missing(display_name: str, reason: str, mend: str) -> InputError:
    return InputError.at(FaultCode.COLUMN_MISSING, display_name, "header", reason, mend)


def _source_lines(name: str, log: _Log) -> list[ProposedLine]:
    lines = [ProposedLine(""), ProposedLine(f"[sources.{name}]")]
    if log.table.options:
        lines.append(ProposedLine(log.table.options_text))
    no_time = ProposedLine("time = { rate_hz = 1000 }", "no time column recognised: write the logging rate")
    lines.append(time_line(log.drives.time, log.table.rate_hz) or no_time)
    if log.drives.temperature:
        role = Role(log.drives.temperature)
        written, guessed = unit_of_role(role, TEMPERATURE, "degC")
        units = toml_text.pair("units", {TEMPERATURE: written})
        line = f"temperature = {{ columns = {columns_text(role)}, {units} }}"
        lines.append(ProposedLine(line, "degC" if guessed else None))
    if log.drives.wrench.force is not None:
        lines += signal_lines(replace(log.drives.wrench, joints=None, position=None, deflection=None))
    return [*lines, *(_joint_lines(name, log.drives) if log.drives.signals else [])]


def _joint_lines(name: str, drives: DriveColumns) -> list[ProposedLine]:
    lines = [ProposedLine(f"[sources.{name}.joints]")]
    units, doubts = [], []
    angle_unit = ""
    for signal, columns in drives.signals.items():
        role = Role(tuple(columns))
        if signal == CURRENT and TORQUE in drives.signals:
            continue
        lines.append(ProposedLine(f"{signal} = {columns_text(role)}"))
        size = max(column.size for column in columns)
        likely = {TORQUE: "N*m", CURRENT: "A", VELOCITY: f"{angle_unit or 'rad'}/s"}.get(signal, "")
        likely = likely or ("deg" if size > LARGEST_RADIAN else "rad")
        written, guessed = unit_of_role(role, "angle" if signal == POSITION else signal, likely)
        angle_unit = written if signal == POSITION and written in ("deg", "rad", "rev") else angle_unit
        units.append(f"{signal} = {toml_text.value(written)}")
        doubts += [f"{signal} in {written} (values up to {size:.3g})"] if guessed else []
    lines.append(ProposedLine(f"units = {{ {', '.join(units)} }}", ", ".join(doubts) if doubts else None))
    if CURRENT in drives.signals and TORQUE not in drives.signals:
        lines.append(
            ProposedLine("torque_constant = []", "to be filled in: N*m per ampere, one number or one per joint")
        )
    side = "motors, according to the column names" if drives.motor else "joints; true: motors"
    lines.append(ProposedLine(f"motor = {str(drives.motor).lower()}", f"angles and torques are of the {side}"))
    return lines


def _moved_joints(run: _ProposedRun) -> list[int]:
    """Return the joints that moved in a run, from 1, in the rows looked at; empty where angles are not logged."""
    for log in run.logs.values():
        columns = log.drives.signals.get(POSITION)
        if columns:
            travel = [max(column.values) - min(column.values) for column in columns]
            return [k + 1 for k, way in enumerate(travel) if way > _TRAVEL_SHARE * max(travel) and way > 0.0]
    return []


def _run_lines(kind: str, run: _ProposedRun, moved: Sequence[int], count: int) -> list[ProposedLine]:
    lines = [*map(ProposedLine, ("", "[[runs]]", toml_text.pair("id", run.name), toml_text.pair("experiment", kind)))]
    if count == 1 or len(moved) == 1:
        joint = moved[0] if len(moved) == 1 else 1
        lines.append(
            ProposedLine(f"moved_joint = {joint}", None if count == 1 else "the joint with the largest motion")
        )
    files = ", ".join(f"{source} = {toml_text.value(f'raw/{log.path.name}')}" for source, log in run.logs.items())
    lines.append(ProposedLine(f"files = {{ {files} }}"))
    if kind == CLAMPED:
        zeros = ", ".join(["0.0"] * count)
        lines.append(ProposedLine(f"# joints_deg = [{zeros}]   # the clamped pose, if the log does not contain it"))
    return lines


def _bench_lines(motor: bool) -> list[ProposedLine]:
    """Return the robot.toml of one joint on a bench."""
    lines = [
        ProposedLine('schema = "stiffcal/robot/1"'),
        ProposedLine('convention = "modified-dh"'),
        ProposedLine("gravity_mps2 = [0, 0, 0]", "one joint on a test bench, without torque of weight"),
        *map(ProposedLine, ("", "[[joints]]", 'name = "joint"')),
    ]
    return [*lines, ProposedLine("gear_ratio = 1.0", "to be filled in: motor turns per joint turn")] if motor else lines

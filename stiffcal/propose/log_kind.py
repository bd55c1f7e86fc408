"""What a log seems to be, and the manifest's lines for it: whose export, which signals, how its text is written.

The usual exports are known by words in their first lines: ATI's force-torque sensors, Beckhoff's TwinCAT Scope,
trackers of API, FARO, Leica and Nikon, traces of robot controllers. A column is guessed by its name; every guess is
marked with ``# ?``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from stiffcal.campaign.columns.column_headers import is_unit_of
from stiffcal.campaign.columns.column_words import words_of
from stiffcal.campaign.found.file_formats import format_of
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.mechanics.chain import Chain
from stiffcal.packed_files import UNPACKING_ERRORS, unpacked_stream
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.explained import explained, is_strain, unused_in_words
from stiffcal.propose.explained_column import ExplainedColumn
from stiffcal.propose.lines import FORCE_SENSOR, TOOL, TRACKER, FrameNames, ProposedLine, Question
from stiffcal.propose.other_tables import TEXT, tables_of
from stiffcal.propose.own_rows import by_rows, rows_line
from stiffcal.propose.recognising import recognise
from stiffcal.propose.signal_lines import signal_lines
from stiffcal.propose.table_sniffing import SniffedColumn, SniffedTable
from stiffcal.propose.time_lines import time_line
from stiffcal.propose.unnamed_columns import are_numbered, missing_names, roles_by_values
from stiffcal.readers import Reader, WantedColumns, find_reader
from stiffcal.table_layout.text import encoding_of

FIRST_BYTES = 1 << 14
XML = "rsi"

# Words of a maker in the name or the first lines, what it is called here, and the name of the source.
MAKERS: tuple[tuple[str, str, str], ...] = (
    (r"\bATI\b|Net ?F/?T|RDT ?Sequence|F/T ?Sequence|Counts per Unit (Force|Torque)", "ATI force-torque sensor", "ft"),
    (r"TwinCAT|Beckhoff|SampleTime ?\[|Starttime of export|\.svdx?\b", "Beckhoff TwinCAT Scope", "scope"),
    (r"\bFARO\b|\bVantage\b|\bCAM2\b", "FARO tracker", "tracker"),
    (r"\bAPI\b.{0,40}(tracker|Radian|OT2|T3)|\bRadian (Pro|Plus|Core)\b|Automated Precision", "API tracker", "tracker"),
    (
        r"\bLeica\b|Spatial ?Analyzer|\bAT9[36]0\b|T-?Mac\b|T-?Probe\b|Tracker Pilot|OTG Applied",
        "Leica tracker",
        "tracker",
    ),
    (r"\bNikon\b|\bMetris\b|K-?Series|\bK[46]\d0\b|\biGPS\b|Space ?Probe", "Nikon tracker", "tracker"),
    (r"\bKUKA\b|\bKRC\d?\b|\$(AXIS|POS|TORQUE)_ACT|AxisPos", "KUKA controller trace", "controller"),
    (r"\bABB\b|RobotStudio|Test ?Signal Viewer|\bIRC5\b", "ABB controller trace", "controller"),
    (r"\bOptiTrack\b|Format Version,.{0,200}Take Name", "OptiTrack Motive", "tracker"),
    (r"\bQualisys\b|NO_OF_MARKERS|MARKER_NAMES", "Qualisys QTM", "tracker"),
    (r"\bVicon\b|(?m:^Trajectories\s*$)", "Vicon Nexus", "tracker"),
    (r"\bPolaris\b|\bNDI\b|(?m:^Tools,Port|^Tool ID,Timestamp)", "NDI tracker", "tracker"),
    (r"LabVIEW Measurement", "LabVIEW measurement file", "daq"),
    (r"actual_TCP_force_|\btarget_q_0\b|\bactual_q_0\b", "Universal Robots RTDE recorder", "controller"),
    (r"\btau_J\[0\]|\bO_T_EE\[0\]", "libfranka log", "controller"),
    (r"\bFANUC\b|\bSt(ä|ae|a)ubli\b|\bYaskawa\b|\bMotoman\b|\bUR1?\d\b", "robot controller trace", "controller"),
)
# The frames that proposed signals are in, where the campaign has none of the name.
FRAMES: dict[str, tuple[ProposedLine, ...]] = {
    FORCE_SENSOR: (
        *(ProposedLine(f"[frames.{FORCE_SENSOR}]"), ProposedLine('parent = "flange"')),
        ProposedLine("xyz_m = [0.0, 0.0, 0.0]", "position and rotation of the sensor"),
    ),
    TRACKER: (
        *(ProposedLine(f"[frames.{TRACKER}]"), ProposedLine('parent = "base"')),
        ProposedLine("estimate = true", "found from the unloaded poses; or give xyz_m and a rotation"),
    ),
    TOOL: (
        *(ProposedLine(f"[frames.{TOOL}]"), ProposedLine('parent = "flange"')),
        ProposedLine("xyz_m = [0.0, 0.0, 0.0]", "position of the target"),
    ),
}
# Repetitions are bounded: these are searched in a log's first lines, which anybody may have written
_NUMBER = r"[^0-9\n]{0,30}([0-9]{1,30}(?:[.,][0-9]{1,30})?)"
_LARGEST_FORCE = 1e5
_COUNTS = re.compile(r"counts per (?:unit )?(force|torque)" + _NUMBER, re.IGNORECASE)
# Counts per N and per N·m of which each is a unit of its own.
_SMALL = {1e3: "m", 1e6: "u"}
_SI_SENSOR = re.compile(r"Force Units?[^A-Za-z\n]{0,10}(?:N|Newtons?)\b")
_STATED = re.compile(
    r"\b(force|torque|moment) units?[\"]?[:;,\t =\"]{1,9}([A-Za-z][A-Za-z .*·/-]{0,15})", re.IGNORECASE
)
_NO_NAMES = "export it with one header line, one time column and names like A1 … A6, Fx, X"


@dataclass(frozen=True)
class LogKind:
    """What a log seems to be."""

    device: str
    """Whose export, "" not known."""
    name: str
    """For its source."""
    format: str = ""
    """Of the file."""
    options: Mapping[str, str | int | bool] = field(default_factory=dict)
    """What the format has to be given for the file to be read."""
    time: ProposedLine | None = None
    """The line of its time; None where the log shows none."""
    signals: tuple[ProposedLine, ...] = ()
    """The lines of its signals."""
    roles: Roles = field(default_factory=Roles)
    """What its columns are."""
    headers: tuple[str, ...] = ()
    """The names of all columns."""
    columns: tuple[ExplainedColumn, ...] = ()
    """Every column, with what it is taken for."""
    why_not: str = ""
    """Why no signal was found; "" where one was."""
    rows: ProposedLine | None = None
    """The condition on rows, where not every row has a reading."""
    further: tuple[LogKind, ...] = ()
    """Other sources in the same log: signals in rows of their own, and its further tables."""
    not_understood: tuple[str, ...] = ()
    """Tables of the same log in which no signal is recognised, each with its first columns."""

    @property
    def options_line(self) -> list[ProposedLine]:
        """The line of the format's options; none where the defaults hold."""
        options = ", ".join(f"{key} = {toml_text.value(value)}" for key, value in self.options.items())
        return [ProposedLine(f"{self.format} = {{ {options} }}")] if options else []

    @property
    def lines(self) -> tuple[ProposedLine, ...]:
        """The lines of a source, or a comment on why there are none."""
        if self.why_not:
            return (ProposedLine(f"# {self.why_not}"),)
        layout = (ProposedLine(toml_text.pair("format", self.format)), *self.options_line)
        rows = () if self.rows is None else (self.rows,)
        time = self.time or unfilled_time(self.name)
        return (*layout, ProposedLine('sampling = "time"'), time, *rows, *self.signals)


def no_joints(columns: Sequence[SniffedColumn]) -> Sequence[SniffedColumn]:
    """Return no column: the joints' are found by their own names."""
    return ()


def log_kind(
    path: Path,
    display_name: str,
    names: FrameNames,
    joints_of: Callable[[Sequence[SniffedColumn]], Sequence[SniffedColumn]] = no_joints,
    chain: Chain | None = None,
) -> LogKind:
    """Return what a log seems to be.

    Parameters
    ----------
    path : the file.
    display_name : as the user knows it, for messages.
    names : the frames to name in the lines.
    joints_of : returns those of a log's columns that hold the joints, base to tip, by the names of a robot's joints.
    chain : of the robot, by which columns without names are judged; None: it is not known.
    """
    found_format = format_of(display_name)
    text = _first_words(path)
    device, name = _maker(path.name.replace("_", " ") + "\n" + (text if found_format in (None, TEXT, XML) else ""))
    try:
        reader = find_reader(path, found_format, display_name)
        tables = tables_of(reader, path, display_name)
        shown = text if reader.name == TEXT else ""
        found, unclear = [], []
        for table in tables:
            kinds = _kinds(table, reader.name, device, names, joints_of, chain, shown)
            unclear += [_table_in_words(table)] if all(kind.why_not for kind in kinds) else []
            found += [_even(reader, path, display_name, kind) for kind in kinds] if table.uneven else kinds
    except InputError as error:
        fault = error.faults[0]
        why = _written_otherwise((), text) or f"{fault.reason}: {fault.mend}"
        return LogKind(device, name, found_format or "", why_not=why)
    understood = [kind for kind in found if not kind.why_not]
    if not understood:
        return found[0]
    apart = [
        replace(kind, name=name if name and len(understood) == 1 else source_name(kind.roles)) for kind in understood
    ]
    return replace(apart[0], further=tuple(apart[1:]), not_understood=tuple(unclear))


_MOST_COLUMNS = 4
_OF_ALL_MESSAGES = ("header.", "name[")
"""Of messages of ROS: when they were sent, and the names that their other columns are called by."""


def _table_in_words(table: SniffedTable) -> str:
    """Return a table by the option that chooses it, with the first of its columns that hold numbers."""
    headers = [column.header for column in table.columns if column.values]
    columns = [header for header in headers if header != "time" and not header.startswith(_OF_ALL_MESSAGES)]
    more = ", …" if len(columns) > _MOST_COLUMNS else ""
    return f"{next(iter(table.options.values()), '')} ({', '.join(columns[:_MOST_COLUMNS])}{more})"


def _even(reader: Reader, path: Path, display_name: str, kind: LogKind) -> LogKind:
    """Return the source, without its lines where its columns are of unequal length."""
    roles = [role for role in vars(kind.roles).values() if isinstance(role, Role)]
    time = [kind.roles.time] if kind.roles.time is not None else []
    time += [kind.roles.time_fraction[0]] if kind.roles.time_fraction is not None else []
    columns = tuple(dict.fromkeys(column.header for column in (*time, *(c for role in roles for c in role.columns))))
    try:
        next(iter(reader.read_batches(path, kind.options, WantedColumns(columns), display_name)), None)
    except InputError as error:
        if error.code is FaultCode.FILE_INCOMPLETE:
            why = f"its columns have different lengths ({', '.join(columns[:12])}): save what was logged at other times"
            return replace(kind, why_not=kind.why_not or f"{why} in a file, or a group, of its own")
    return kind


def _kinds(
    table: SniffedTable,
    log_format: str,
    device: str,
    names: FrameNames,
    joints_of: Callable[[Sequence[SniffedColumn]], Sequence[SniffedColumn]],
    chain: Chain | None,
    text: str,
) -> list[LogKind]:
    """Return what a table of a log seems to be: an entry for each source in it, or one that says why there is none.

    Parameters
    ----------
    text : the log's first lines, "" where it is no text. Others as in `log_kind`.
    """
    unnamed = are_numbered([column.header for column in table.columns])
    roles = roles_by_values(table.columns, chain) if unnamed else recognise(table.columns, joints_of(table.columns))
    roles = _in_stated_units(roles, text)
    headers = tuple(column.header for column in table.columns)
    parts = [part for part in by_rows(roles) if signal_lines(part, names)]
    if not parts:
        listed = ", ".join(headers[:12])
        why = f"no signal recognised in its columns ({listed}): {_NO_NAMES}"
        doubted = [column for column in table.columns if column.doubt is not None and not column.values]
        if doubted:
            why = f"column {doubted[0].header}: {doubted[0].doubt}"
        elif any(map(is_strain, table.columns)):
            strains = {column.header for column in table.columns if is_strain(column)}
            why = "; ".join(unused_in_words(own for own in explained([table], roles) if own.column in strains))
        elif table.left_out:
            why = f"{table.left_out[0][1]}: give each column a unique name, such as that of its tool in front"
        if unnamed:
            why = (
                f"it has no line of names: write one at its top, {missing_names(table.columns, roles)} (each ? is open)"
            )
        why = _written_otherwise(headers, text) or why
        return [LogKind(device, "", log_format, headers=headers, columns=tuple(explained([table], roles)), why_not=why)]
    return [
        LogKind(
            device,
            "",
            log_format,
            table.options,
            time_line(roles.time, table.rate_hz, roles.time_fraction),
            (*signal_lines(part, names), *_counts_lines(part, text)),
            part,
            headers,
            tuple(explained([table], roles)),
            rows=rows_line(part, len(parts) > 1),
        )
        for part in parts
    ]


_STRUCTURES = re.compile(r"\{\s{0,9}(?:E6AXIS|AXIS)?\s{0,9}:?\s{0,9}A1\s{1,9}-?[0-9]")
_DIRECTIONS = frozenset(("azimuth", "azimut", "zenith", "zenit", "zenithal", "elevation", "hz", "vz", "v"))
_DISTANCES = frozenset(("distance", "dist", "range", "radius", "d", "distanz", "schragstrecke", "sd"))


def _written_otherwise(headers: Sequence[str], text: str) -> str:
    """Return why readings that are there are not taken, with what to do; "" where none are known to be there.

    Parameters
    ----------
    text : as in `_kinds`.
    """
    if _STRUCTURES.search(text):
        return (
            "angles stand in structures of KRL ({E6AXIS: A1 …, A2 …}): write each into a column of its own, "
            "A1 to A6, as $AXIS_ACT.A1 and so on in the trace or in CWRITE"
        )
    words = {header: set(words_of(header)[0]) for header in headers}
    polar = [header for header, own in words.items() if own & (_DIRECTIONS | _DISTANCES)]
    # a direction is two angles: Hz alone is also the unit of a rate
    angles = sum(bool(own & _DIRECTIONS) for own in words.values())
    if angles > 1 and any(own & _DISTANCES for own in words.values()):
        return (
            f"directions and a distance ({', '.join(polar)}) are not read, as programs count them from different axes: "
            "have the instrument's program write X, Y, Z"
        )
    return ""


def source_name(roles: Roles) -> str:
    """Return a name for the source of signals whose maker is not known."""
    return "ft" if roles.force is not None else "tracker" if roles.position is not None else "controller"


def _in_stated_units(roles: Roles, text: str) -> Roles:
    """Return the roles with forces and moments in the units that the log's head states, of counts in that of one."""
    if not _are_counts(roles):
        stated = {what.lower(): written.strip() for what, written in _STATED.findall(text)}
        force, moment = stated.get("force", ""), stated.get("torque", stated.get("moment", ""))
        return replace(
            roles,
            force=_counted(roles.force, force) if is_unit_of(force, "force") else roles.force,
            moment=_counted(roles.moment, moment) if is_unit_of(moment, "moment") else roles.moment,
        )
    per_unit = {what.lower(): float(number.replace(",", ".")) for what, number in _COUNTS.findall(text)}
    force, moment = (_SMALL.get(per_unit.get(what, 0.0)) for what in ("force", "torque"))
    if not force or (roles.moment is not None and not moment) or not _SI_SENSOR.search(text):
        return roles
    return replace(roles, force=_counted(roles.force, f"{force}N"), moment=_counted(roles.moment, f"{moment}N*m"))


def _counted(role: Role | None, unit: str) -> Role | None:
    """Return a role with a unit for the columns that state none."""
    if role is None:
        return None
    columns = (replace(column, unit=unit) if column.unit is None else column for column in role.columns)
    return replace(role, columns=tuple(columns))


def _are_counts(roles: Roles) -> bool:
    """Return whether forces without a unit are as large as counts of a sensor's electronics."""
    columns = () if roles.force is None else roles.force.columns
    return any(column.size > _LARGEST_FORCE and column.unit is None for column in columns)


def _counts_lines(roles: Roles, text: str) -> list[ProposedLine]:
    """Return a question where forces are counts, and the head of the log states no unit that one of them is."""
    if roles.force is None or not _are_counts(roles):
        return []
    counts = _COUNTS.search(text)
    per_unit = f", {counts[2]} per unit" if counts is not None else ""
    largest = max(column.size for column in roles.force.columns)
    return [ProposedLine("", f"up to {largest:.3g}: counts{per_unit}? Log or write units, not counts")]


def with_doubt(line: ProposedLine, names: FrameNames) -> ProposedLine:
    """Mark a line that names a frame which was taken for want of one called `TOOL`."""
    taken = [name for name in (names.body, names.point) if name != TOOL and name in line.frames]
    return replace(line, doubt=f"or another frame than {taken[0]!r}") if taken and line.doubt is None else line


def _first_words(path: Path) -> str:
    """Return the beginning of a text, unpacked and decoded; of other files what their bytes look like."""
    try:
        with open_regular(path) as file:
            content = unpacked_stream(file).read(FIRST_BYTES)
    except (*UNPACKING_ERRORS, InputError):
        return ""
    return content.decode(encoding_of(content), "replace")


def _maker(text: str) -> tuple[str, str]:
    for words, device, name in MAKERS:
        if re.search(words, text):
            return device, name
    return "", ""


def unfilled_time(source: str) -> ProposedLine:
    """Return the line of the time of a log that has no column of it and states no rate."""
    what = 'rows per second; or the column of the time, { column = "…", unit = "s" }'
    question = Question(f"sources.{source}", "time", what, ("rate",), "{{ rate_hz = {} }}")
    return ProposedLine("time = {}", "to be filled in: rate_hz, rows per second, or column and unit", question=question)

"""Lines of campaign.toml and robot.toml that `init --from` and `check` propose for a table's columns."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stiffcal.campaign.column_names import is_unit_of
from stiffcal.campaign.source import TIMES_IN_WORDS
from stiffcal.campaign.typed import expand_columns
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.table_purpose import serves_absolute
from stiffcal.propose.table_sniffing import SniffedColumn, SniffedTable
from stiffcal.quantities import UnknownUnitError, unit

GUESS = "# ?"
"""Begins the comment of a line that was guessed."""
TOOL = "tool"
FORCE_SENSOR = "ft_sensor"
TRACKER = "tracker"
PAYLOAD = "payload"

LARGEST_RADIAN = 6.6
# no linear axis of a robot is longer, m: larger numbers are mm
LONGEST_M = 50.0
"""A joint angle beyond one turn and a bit is not in radians."""
# A robot's give is below 5 cm; no reach is above 20 m.
_LARGEST_DEFLECTION_M = 0.05
_LARGEST_POSITION_M = 20.0
_LARGEST_SIGMA_M = 5e-3
"""An instrument that is less certain than this shows no elasticity."""
_SIGMA_DOUBT = "sigma: one standard uncertainty of each reading"


@dataclass(frozen=True)
class Question:
    """A value that no log states."""

    table: str
    """The table of the line, as ``frames.tool``."""
    key: str
    """Of the line."""
    text: str
    """What the value is, in words."""
    numbers: tuple[str, ...] = ("x", "y", "z")
    """Of which numbers it is made."""
    form: str = "[{}]"
    """How they are written, by `str.format`."""

    def line(self, numbers: Sequence[float | str]) -> str:
        """Return the line with numbers in it.

        Examples
        --------
        >>> Question("frames.tool", "xyz_m", "where it is").line([0.0, 0.0, 0.2])
        'xyz_m = [0.0, 0.0, 0.2]'
        """
        return f"{self.key} = {self.form.format(', '.join(map(str, numbers)))}"


@dataclass(frozen=True)
class ProposedLine:
    """A line of a proposed file; as text it ends with `GUESS` and the doubt, where it was guessed."""

    toml: str
    """What stands before the comment, "" of a comment alone."""
    doubt: str | None = None
    """What a person should check, "" where the value itself shows it; None where nothing was guessed."""
    frames: tuple[str, ...] = ()
    """The frames that it names."""
    question: Question | None = None
    """What a person is asked where nothing can be guessed: the line's value is then still to be written."""

    def __str__(self) -> str:
        comment = None if self.doubt is None else f"{GUESS} {self.doubt}".rstrip()
        return "  ".join(piece for piece in (self.toml, comment) if piece)


@dataclass(frozen=True)
class FrameNames:
    """The names of the frames that proposed lines use."""

    body: str = TOOL
    """Where the displacement is measured."""
    point: str = TOOL
    """Where a force without moments acts."""
    axes: str = "base"
    """In whose axes a force without moments is measured, unless its columns' names say it."""


DEFAULT_NAMES = FrameNames()


def as_text(lines: Sequence[ProposedLine]) -> str:
    """Return the lines as the text of a file."""
    return "".join(f"{line}\n" for line in lines)


def source_lines(
    tables: Sequence[SniffedTable], roles: Roles, prismatic: Collection[SniffedColumn] = ()
) -> list[ProposedLine]:
    """Return the source that reads the tables, every guess marked.

    Parameters
    ----------
    prismatic : columns that hold positions of prismatic joints.

    Raises
    ------
    InputError
        A unit is not known, columns of a signal differ in theirs, or a signal lies in several files.
    """
    texts = ["[sources.table]"]
    if len(tables) == 1:
        texts.append(f"file = {toml_text.value(f'raw/{tables[0].path.name}')}")
    else:
        texts.append(f"files = {{ {', '.join(_file_of_signals(tables, roles))} }}")
    if tables[0].options:
        texts.append(tables[0].options_text)
    absolute = serves_absolute(roles)
    lines = [*map(ProposedLine, texts), ProposedLine('sampling = "states"') if absolute else _run_line(roles)]
    if not _needs_no_time(roles):
        time = time_line(roles.time, None)
        lines += [time] if time is not None else []
    if absolute:
        payload = _payload_lines(roles)
        places = _target_tables(roles) if roles.targets else _moved_lines(roles, TOOL)
        return [*lines, _joints_line(roles, prismatic), *payload, *places]
    question = _question_lines(roles)
    return [*lines, _joints_line(roles, prismatic), *_load_lines(roles, TOOL), *question, *_moved_lines(roles, TOOL)]


def _question_lines(roles: Roles) -> list[ProposedLine]:
    """Return a question about columns that may be moments or rotations, where no displacement takes the latter."""
    if roles.rotation is None or not roles.rotation.is_open or roles.deflection is not None:
        return []
    names = ", ".join(column.header for column in roles.rotation.columns)
    return [ProposedLine("", f"{names} are not used: moments (add them to the columns of wrench), or rotations?")]


def run_lines(roles: Roles) -> list[ProposedLine]:
    """Return the runs that a table must list: those of absolute places; else none, each row names its own."""
    if not serves_absolute(roles):
        return []
    return [ProposedLine(text) for text in ("", "[[runs]]", 'id = "poses"', 'experiment = "absolute"')]


def _is_loaded(roles: Roles) -> bool:
    """Return whether a column of payloads holds any: the payload's position is of use only then."""
    return roles.mass is not None and any(column.size > 0.0 for column in roles.mass.columns)


def _payload_lines(roles: Roles) -> list[ProposedLine]:
    if roles.mass is None or _is_loaded(roles):
        return [] if roles.mass is None else _load_lines(roles, PAYLOAD)
    column = toml_text.value(roles.mass.columns[0].header)
    return [ProposedLine("", f"{column} is 0 in the rows that were looked at: no payload")]


def time_line(time: SniffedColumn | None, rate_hz: float | None) -> ProposedLine | None:
    """Return the line of a log's time: its column, or the rate where the column stands still; None without both.

    Parameters
    ----------
    time : the column; None where there is none. rate_hz : as the log states it, where it does.
    """
    if time is not None and (rate_hz is None or not _stands_still(time)):
        known = time.unit in TIMES_IN_WORDS or (time.unit is not None and is_unit_of(time.unit, "time"))
        written = str(time.unit) if known else _likely_time_unit(time)
        written = written if written in TIMES_IN_WORDS else unit(written, "time").name
        line = toml_text.pair("time", {"column": time.header, "unit": written})
        return ProposedLine(line, time.doubt if known else f"{written}, judged by the values (up to {time.size:.10g})")
    if rate_hz is None:
        return None
    why = "as stated in its first lines"
    if time is not None:
        why += f"; {time.header} repeats values: its resolution is lower than the rate"
    return ProposedLine(f"time = {{ rate_hz = {rate_hz:g} }}", why)


def _needs_no_time(roles: Roles) -> bool:
    """Return whether the times of a table of states give no order of its rows, or there are none."""
    return roles.time is None or (serves_absolute(roles) and _stands_still(roles.time))


def _likely_time_unit(time: SniffedColumn) -> str:
    """Return the unit of a time without one: seconds, unless they count from 1970 in finer steps."""
    size = time.size
    finer = [name for name, least in (("ns", 1e17), ("us", 1e14), ("ms", 1e11)) if size > least]
    return finer[0] if finer else "s"


def _stands_still(time: SniffedColumn) -> bool:
    """Return whether a column of times gives no order of the rows, rounded to the same value as it is."""
    return any(later <= earlier for earlier, later in pairwise(time.values))


def signal_lines(roles: Roles, names: FrameNames = DEFAULT_NAMES) -> list[ProposedLine]:
    """Return the lines of those signals that a log holds, every guess marked; empty where none is recognised."""
    lines = [_joints_line(roles)] if roles.joints is not None else []
    lines += _load_lines(roles, names.point, names.axes) if roles.force is not None else []
    moved = roles.deflection is not None or roles.position is not None
    return [*lines, *_question_lines(roles), *(_moved_lines(roles, names.body) if moved else [])]


def _file_of_signals(tables: Sequence[SniffedTable], roles: Roles) -> list[str]:
    """Return in which file the columns of each signal lie."""
    signals: dict[str, list[Role | None]] = {
        "joints": [roles.joints],
        "wrench": [roles.force, roles.moment],
        "dead_weight": [roles.mass if roles.force is None else None],
        "deflection": [roles.deflection, roles.rotation if roles.deflection is not None else None],
        "pose": [roles.position, roles.quaternion] if roles.deflection is None and not roles.targets else [None],
    }
    signals |= {f"poses.{name}": [role] for name, role in roles.targets}
    single = {"run": roles.run, "time": None if _needs_no_time(roles) else roles.time}
    signals |= {name: [Role((column,))] for name, column in single.items() if column is not None}
    sentences = []
    for signal, signal_roles in signals.items():
        columns = {column for role in signal_roles if role is not None for column in role.all_columns}
        files = [table.path.name for table in tables if columns & set(table.columns)]
        if len(files) > 1:
            raise InputError.at(
                FaultCode.SHAPE_MISMATCH,
                files[1],
                "header",
                f"the {signal} is also in {files[0]}",
                "put it into one file",
            )
        sentences += [f"{signal} = {toml_text.value(f'raw/{files[0]}')}"] if files else []
    return sentences


def _run_line(roles: Roles) -> ProposedLine:
    if roles.run is not None:
        return ProposedLine(f"run = {{ column = {toml_text.value(roles.run.header)} }}")
    if roles.deflection is not None:
        return ProposedLine('run = { each = "row" }')
    return ProposedLine('run = { column = "run" }', "add a column with the pose of each row")


def _joints_line(roles: Roles, prismatic: Collection[SniffedColumn] = ()) -> ProposedLine:
    assert roles.joints is not None
    if prismatic:  # one unit for each column
        return _line_of_mixed_joints(roles.joints, prismatic)
    size = max(column.size for column in roles.joints.columns)
    likely = "deg" if size > LARGEST_RADIAN else "rad"
    written, guessed = unit_of_role(roles.joints, "angle", likely)
    line = f"joints = {{ position = {columns_text(roles.joints)}, {toml_text.pair('units', {'position': written})} }}"
    doubts = [f"{written}, judged by the values (up to {size:.3g})"] if guessed else []
    doubts += [roles.joints.doubt] if roles.joints.doubt else []
    return ProposedLine(line, ", ".join(doubts) if doubts else None)


def _line_of_mixed_joints(joints: Role, prismatic: Collection[SniffedColumn]) -> ProposedLine:
    turns = Role(tuple(column for column in joints.columns if column not in prismatic))
    likely = "deg" if max((column.size for column in turns.columns), default=0.0) > LARGEST_RADIAN else "rad"
    angle, guessed = unit_of_role(turns, "angle", likely) if turns.columns else ("", False)
    units, doubts = [angle] * len(joints.columns), [f"{angle}, judged by the values"] if guessed else []
    for k, column in enumerate(joints.columns):
        if column in prismatic:
            units[k], guessed = unit_of_role(Role((column,)), "length", "m" if column.size < LONGEST_M else "mm")
            doubts += [f"{column.header} in {units[k]} (values up to {column.size:.3g})"] if guessed else []
    line = f"joints = {{ position = {columns_text(joints)}, {toml_text.pair('units', {'position': units})} }}"
    return ProposedLine(line, ", ".join(doubts) if doubts else None)


def _load_lines(roles: Roles, tool: str, axes: str = DEFAULT_NAMES.axes) -> list[ProposedLine]:
    if roles.force is None:
        assert roles.mass is not None
        written, _ = unit_of_role(roles.mass, "mass", "kg")
        column = toml_text.value(roles.mass.columns[0].header)
        units = f"{{ mass = {toml_text.value(written)} }}"
        line = f"dead_weight = {{ mass_column = {column}, point = {toml_text.value(tool)}, units = {units} }}"
        return [ProposedLine(line, frames=(tool,))]
    doubts = []
    force, guessed = unit_of_role(roles.force, "force", "N")
    doubts += ["N"] if guessed else []
    units, columns = f"force = {toml_text.value(force)}", roles.force.columns
    if roles.moment is not None:
        moment, guessed = unit_of_role(roles.moment, "moment", "N*m")
        doubts += ["N*m"] if guessed else []
        units += f", moment = {toml_text.value(moment)}"
        columns += roles.moment.columns
    in_base = bool({"base", "world", "robot"} & roles.force.places)
    if roles.moment is not None and not in_base:
        frame = FORCE_SENSOR
        where = f"frame = {toml_text.value(frame)}"
        doubts.append("in the sensor's axes")
    else:
        frame = tool if roles.moment is None else FORCE_SENSOR
        axes = "base" if in_base or roles.moment is not None else axes
        where = f"{toml_text.pair('axes', axes)}, {toml_text.pair('point', frame)}"
        doubts += [] if in_base else [f"in {axes} axes"]
    doubts.append("acts on the robot")
    doubts += [roles.force.doubt] if roles.force.doubt else []
    line = f"wrench = {{ columns = {columns_text(Role(columns))}, units = {{ {units} }}, {where} }}"
    frames = (frame,) if axes in ("base", frame) else (axes, frame)
    return [ProposedLine(line, ", ".join(doubts), frames)]


def _moved_lines(roles: Roles, body: str) -> list[ProposedLine]:
    doubts = []
    if roles.deflection is not None:
        size = max(column.size for column in roles.deflection.columns)
        likely = "m" if size < _LARGEST_DEFLECTION_M else "mm" if size < _LARGEST_DEFLECTION_M * 1e3 else "um"
        written, guessed = unit_of_role(roles.deflection, "translation", likely)
        doubts += [f"{written}, judged by the values (up to {size:.3g})"] if guessed else []
        units, rotation = f"translation = {toml_text.value(written)}", ""
        if roles.rotation is not None:
            turned = max(column.size for column in roles.rotation.columns)
            angle, guessed = unit_of_role(roles.rotation, "angle", "rad" if turned < _LARGEST_DEFLECTION_M else "deg")
            if roles.rotation.is_open:
                doubts.append(
                    f"{', '.join(column.header for column in roles.rotation.columns)}: rotations, not moments"
                )
            doubts += [f"turns in {angle}"] if guessed else []
            units, rotation = (
                f"{units}, {toml_text.pair('rotation', angle)}",
                f", rotation = {columns_text(roles.rotation)}",
            )
        doubts += [] if roles.deflection.places else ["in base axes"]
        doubts += [roles.deflection.doubt] if roles.deflection.doubt else []
        columns = f"translation = {columns_text(roles.deflection)}{rotation}"
        sigma, why = _sigma(roles.deflection, "translation", written)
        of_body = toml_text.pair("body", body)
        line = f'deflection = {{ {columns}, units = {{ {units} }}{sigma}, {of_body}, axes = "base" }}'
        frames: tuple[str, ...] = (body,)
    else:
        assert roles.position is not None
        size = max(column.size for column in roles.position.columns)
        written, guessed = unit_of_role(roles.position, "position", "m" if size < _LARGEST_POSITION_M else "mm")
        doubts += [f"{written}, judged by the values (up to {size:.4g})"] if guessed else []
        columns = f"position = {columns_text(roles.position)}"
        doubts += [roles.position.doubt] if roles.position.doubt else []
        doubts += [f"or of {', '.join(roles.position.others)}"] if roles.position.others else []
        for key, role in (("quaternion_wxyz", roles.quaternion), ("matrix", roles.matrix)):
            if role is not None and role.stands_still:
                doubts.append(f"{', '.join(c.header for c in role.columns)} never change: no measured orientation")
            elif role is not None:
                columns += f", {key} = {columns_text(role)}"
                break
        units = f"{{ position = {toml_text.value(written)} }}"
        sigma, why = _sigma(roles.position, "position", written)
        of_body = f"{toml_text.pair('frame', TRACKER)}, {toml_text.pair('body', body)}"
        line = f"pose = {{ {of_body}, {columns}, units = {units}{sigma} }}"
        frames = (TRACKER, body)
    doubts += [_SIGMA_DOUBT] if sigma else []
    return [ProposedLine(line, ", ".join(doubts) if doubts else None, frames), *why]


def _target_tables(roles: Roles) -> list[ProposedLine]:
    """Return a table for each of several targets."""
    lines = []
    for name, role in roles.targets:
        size = max(column.size for column in role.columns)
        written, guessed = unit_of_role(role, "position", "m" if size < _LARGEST_POSITION_M else "mm")
        sigma, why = _sigma(role, "position", written)
        doubt = f"{written}, judged by the values (up to {size:.4g})" if guessed else None
        lines += [
            ProposedLine(f"[sources.table.poses.{name}]"),
            ProposedLine(f"frame = {toml_text.value(TRACKER)}", frames=(TRACKER, name)),
            ProposedLine(f"position = {columns_text(role)}"),
            ProposedLine(f"units = {{ position = {toml_text.value(written)} }}", doubt),
            *([ProposedLine(sigma.removeprefix(", "), _SIGMA_DOUBT)] if sigma else []),
            *why,
        ]
    return lines


def _sigma(role: Role, key: str, written: str) -> tuple[str, list[ProposedLine]]:
    """Return the entry with the columns of a signal's uncertainty, "" without; or why the columns are left out.

    Parameters
    ----------
    role : readings. key : of `sigma`. written : the unit of the readings.
    """
    if role.sigma is None:
        return "", []
    columns = role.sigma.columns
    headers = [column.header for column in columns]
    stated_sigma: dict[str, toml_text.TomlValue] = {key: headers[0] if len(headers) == 1 else headers}
    factor = unit(written, "length").factor / role.sigma.coverage
    typical = float(np.nanmedian([value for column in columns for value in column.values])) * factor
    if role.sigma.coverage != 1.0:
        stated_sigma["coverage"] = role.sigma.coverage
    stated = sorted({column.unit for column in columns if column.unit is not None} - {written})
    if stated:
        why = f"is in {', '.join(stated)}, the readings in {written}"
    elif typical > _LARGEST_SIGMA_M:
        why = f"would be {1e3 * typical:.3g} mm"
    elif not role.sigma.steady:
        why = "varies as the scatter within single readings does; places may be uncertain by more"
    elif role.sigma.zero_rows:
        why = f"is 0 in {role.sigma.zero_rows} of the rows that were looked at, which states nothing"
    else:
        return f", {toml_text.pair('sigma', stated_sigma)}", []
    return "", [ProposedLine("", f"{toml_text.pair('sigma', stated_sigma)} left out: it {why}")]


def frame_lines(roles: Roles, tool: Sequence[float] | None) -> list[ProposedLine]:
    """Return the frames that `source_lines` name.

    Parameters
    ----------
    roles : what the columns are.
    tool : the tool point, m, in the flange frame; None: it is left to be written, as no value can be guessed.
    """
    reason = "measured point" if roles.moment is not None else "point of load application and displacement measurement"
    where = f"{reason}, x, y, z in m in the flange frame"
    known = None if tool is None else f"xyz_m = [{', '.join(map(repr, tool))}]"
    point = ProposedLine(known) if known is not None else ProposedLine("xyz_m = []", f"to be filled in: {where}")
    if serves_absolute(roles):
        return _frames_to_estimate(roles, known)
    lines = [*_table(TOOL, "flange"), point]
    if roles.moment is not None:
        origin = ProposedLine("xyz_m = [0.0, 0.0, 0.0]", "assumed at the flange; add rpy_deg if rotated")
        lines += [*_table(FORCE_SENSOR, "flange"), origin]
    if roles.deflection is None:
        lines += [*_table(TRACKER, "base"), ProposedLine("estimate = true")]
    return lines


def _frames_to_estimate(roles: Roles, known: str | None) -> list[ProposedLine]:
    """Return the target and the tracker, both found by the fit, and the position of a payload."""
    roughly = ProposedLine("xyz_m = [0.0, 0.0, 0.0]", "approximate position of the target: it is estimated")
    place = ProposedLine(known) if known else roughly
    names = [name for name, _ in roles.targets] or [TOOL]
    target = [line for name in names for line in [*_table(name, "flange"), ProposedLine("estimate = true"), place]]
    if _is_loaded(roles):
        centre = ProposedLine("xyz_m = []", "to be filled in: centre of mass of the payload, m, in the flange frame")
        target += [*_table(PAYLOAD, "flange"), centre]
    return [*target, *_table(TRACKER, "base"), ProposedLine("estimate = true")]


def _table(frame: str, parent: str) -> list[ProposedLine]:
    return [ProposedLine(text) for text in ("", f"[frames.{frame}]", f"parent = {toml_text.value(parent)}")]


def unit_of_role(role: Role, quantity: str, likely: str) -> tuple[str, bool]:
    """Return the unit of a signal's columns and whether it was guessed.

    Parameters
    ----------
    role : the columns. quantity : as in `stiffcal.quantities`. likely : the unit where none is written.

    Raises
    ------
    InputError
        The header names a unit that is not known for the quantity, or the columns differ.
    """
    written = {column.unit for column in role.columns}
    if written == {None}:
        return likely, True
    names = set()
    for column in role.columns:
        place = f'column "{column.header}"'
        if column.unit is None:
            raise InputError.at(
                FaultCode.UNIT_CONFLICT,
                "",
                place,
                "it has no unit, but neighbouring columns do",
                "write the unit into the header",
            )
        try:
            names.add(unit(column.unit, quantity).name)
        except UnknownUnitError as error:
            raise InputError.at(FaultCode.UNIT_UNKNOWN, "", place, error.reason, error.mend) from None
    if len(names) > 1:
        units = ", ".join(sorted(names))
        raise InputError.at(
            FaultCode.UNIT_CONFLICT, "", f'column "{role.columns[0].header}"', f"units differ: {units}", "use one unit"
        )
    return names.pop(), False


def columns_text(role: Role) -> str:
    """Write column names: as a range where that means the same, else as a list."""
    headers = [column.header for column in role.columns]
    if len(headers) > 3:
        text = f"{headers[0]}..{headers[-1]}"
        try:
            if expand_columns(text) == tuple(headers):
                return toml_text.value(text)
        except ValueError:
            pass
    return "[" + ", ".join(toml_text.value(header) for header in headers) + "]"

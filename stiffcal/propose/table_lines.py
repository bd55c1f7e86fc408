"""The source, runs and frames that `init --from` proposes for a table of states."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.lines import FORCE_SENSOR, PAYLOAD, TOOL, TRACKER, ProposedLine, frame_table, question_line
from stiffcal.propose.other_tables import TEXT, rows_that_are_no_readings
from stiffcal.propose.signal_lines import joints_line, load_lines, moved_lines, question_lines, target_tables
from stiffcal.propose.table_purpose import serves_absolute
from stiffcal.propose.table_sniffing import SniffedColumn, SniffedTable
from stiffcal.propose.time_lines import stands_still, time_line


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
        time = time_line(roles.time, None, roles.time_fraction)
        lines += [time] if time is not None else []
    if absolute:
        payload = _payload_lines(roles)
        places = target_tables(roles) if roles.targets else moved_lines(roles, TOOL)
        return [*lines, joints_line(roles, prismatic), *payload, *places]
    question = question_lines(roles)
    return [*lines, joints_line(roles, prismatic), *load_lines(roles, TOOL), *question, *moved_lines(roles, TOOL)]


def run_lines(roles: Roles) -> list[ProposedLine]:
    """Return the runs that a table must list: those of absolute places; else none, each row names its own."""
    if not serves_absolute(roles):
        return []
    return [ProposedLine(text) for text in ("", "[[runs]]", 'id = "poses"', 'experiment = "absolute"')]


def excluded_rows(tables: Sequence[SniffedTable], roles: Roles) -> list[ProposedLine]:
    """Return the entry that leaves out blank rows and remarks; nothing of tables whose rows belong together."""
    if len(tables) != 1:
        return []
    (table,) = tables
    words = dict(table.no_readings)
    named = ", ".join(dict.fromkeys(repr(word) if word else "blank" for word in words.values()))
    if table.log_format != TEXT:
        signals = (roles.joints, roles.force, roles.moment, roles.deflection)
        columns = [column.header for role in signals if role is not None for column in role.columns]
        words, named = dict.fromkeys(rows_that_are_no_readings(table, columns), ""), "a cell is no number"
    if not words:
        return []
    return [
        *map(ProposedLine, ("", "[[exclude]]", toml_text.pair("source", "table"))),
        ProposedLine(toml_text.pair("rows", list(words)), named),
        ProposedLine(toml_text.pair("why", "no readings")),
    ]


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
    point = ProposedLine(known) if known is not None else question_line(TOOL, "xyz_m", where)
    if serves_absolute(roles):
        return _frames_to_estimate(roles, known)
    lines = [*frame_table(TOOL, "flange"), point]
    if roles.moment is not None:
        origin = ProposedLine(
            "xyz_m = [0.0, 0.0, 0.0]", "assumed at the flange; add rpy_deg (or quaternion_wxyz) if rotated"
        )
        lines += [*frame_table(FORCE_SENSOR, "flange"), origin]
    if roles.deflection is None:
        lines += [*frame_table(TRACKER, "base"), ProposedLine("estimate = true")]
    return lines


def _frames_to_estimate(roles: Roles, known: str | None) -> list[ProposedLine]:
    """Return the target and the tracker, both found by the fit, and the position of a payload."""
    roughly = ProposedLine("xyz_m = [0.0, 0.0, 0.0]", "approximate position of the target: it is estimated")
    place = ProposedLine(known) if known else roughly
    names = [name for name, _ in roles.targets] or [TOOL]
    target = [line for name in names for line in [*frame_table(name, "flange"), ProposedLine("estimate = true"), place]]
    if _is_loaded(roles):
        centre = question_line(PAYLOAD, "xyz_m", "centre of mass of the payload, x, y, z in m in the flange frame")
        target += [*frame_table(PAYLOAD, "flange"), centre]
    return [*target, *frame_table(TRACKER, "base"), ProposedLine("estimate = true")]


def _is_loaded(roles: Roles) -> bool:
    """Return whether a column of payloads holds any: the payload's position is of use only then."""
    return roles.mass is not None and any(column.size > 0.0 for column in roles.mass.columns)


def _payload_lines(roles: Roles) -> list[ProposedLine]:
    if roles.mass is None or _is_loaded(roles):
        return [] if roles.mass is None else load_lines(roles, PAYLOAD)
    column = toml_text.value(roles.mass.columns[0].header)
    return [ProposedLine("", f"{column} is 0 in the rows that were looked at: no payload")]


def _needs_no_time(roles: Roles) -> bool:
    """Return whether the times of a table of states give no order of its rows, or there are none."""
    return roles.time is None or (serves_absolute(roles) and stands_still(roles.time))


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
                f"{signal}: also in {files[0]}",
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

"""`init --from`: a campaign proposed from a table's header and values, every guess marked with ``# ?``."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from stiffcal.campaign.column_roles import Role, Roles, recognise
from stiffcal.campaign.naming import MANIFEST_FILE
from stiffcal.campaign.robot_checks import outline_of
from stiffcal.campaign.robot_file import RobotFile
from stiffcal.campaign.table_sniffing import SniffedTable, sniff_table
from stiffcal.campaign.templates import bundled_robot, write_folder
from stiffcal.campaign.typed import expand_columns
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.quantities import UnknownUnitError, unit

GUESS = "# ?"

# A joint angle beyond one turn and a bit is not in radians; a robot's give is below 5 cm; no reach is above 20 m.
_LARGEST_RADIAN = 6.6
_LARGEST_DEFLECTION_M = 0.05
_LARGEST_POSITION_M = 20.0


@dataclass(frozen=True)
class Proposal:
    """A campaign folder as proposed."""

    manifest: str
    """The texts of campaign.toml and robot.toml."""
    robot: str
    """The texts of campaign.toml and robot.toml."""
    copies: dict[str, Path]
    """Name under the campaign folder to the file it is copied from."""
    guessed: tuple[str, ...]
    """The lines that are marked, each with its file."""
    unused: tuple[str, ...]
    """Columns that nothing was seen in."""
    files: list[Path] = field(default_factory=list)
    """What was written; empty for a draft."""


def draft_campaign(tables: Sequence[Path], *, urdf: Path | None = None, robot: str | None = None) -> Proposal:
    r"""Propose a campaign from one table, or from several of equal length that belong together.

    Parameters
    ----------
    tables : CSV files with a header; one row per load state.
    urdf : the robot as a URDF;
    robot : the name of a bundled robot. Neither: rows to fill in.

    Raises
    ------
    InputError
        A table cannot be understood: no joint columns, no load, nothing that moved; or it does not fit the robot.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "table.csv"
    >>> _ = path.write_text("A1,A2,A3,Fx,Fy,Fz,dx,dy,dz\n10,20,30,0,0,100,0,0,-0.2\n")
    >>> print(draft_campaign([path]).manifest.splitlines()[7][:67])
    wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "N" }, a
    """
    sniffed = [sniff_table(path) for path in tables]
    _check_together(sniffed)
    roles = recognise(column for table in sniffed for column in table.columns)
    _check_roles(roles, ", ".join(table.path.name for table in sniffed))
    lines = _source_lines(sniffed, roles) + _frame_lines(roles)
    manifest = "\n".join(['schema = "stiffcal/campaign/1"', 'robot = "robot.toml"', "", *lines]) + "\n"
    copies = {f"raw/{table.path.name}": table.path for table in sniffed}
    text, extra = _robot_text(roles, urdf, robot)
    marked = [f"{MANIFEST_FILE}: {line}" for line in lines if GUESS in line]
    marked += [f"robot.toml: {line}" for line in text.splitlines() if GUESS in line]
    unused = tuple(column.header for column in roles.unused)
    proposal = Proposal(manifest, text, copies | extra, tuple(marked), unused)
    _check_robot_fits(proposal, roles, urdf)
    return proposal


def propose_campaign(
    folder: Path, tables: Path | Sequence[Path], *, urdf: Path | None = None, robot: str | None = None
) -> Proposal:
    """Write a proposed campaign folder: manifest, robot file, and the tables copied into ``raw/``.

    Parameters
    ----------
    folder : made where it does not exist; nothing in it is overwritten. Others as in `draft_campaign`.

    Returns
    -------
    Proposal
        With the files that were written.

    Raises
    ------
    InputError
        As `draft_campaign`; or the folder holds a campaign already.
    """
    proposal = draft_campaign([tables] if isinstance(tables, Path) else tables, urdf=urdf, robot=robot)
    for name, source in proposal.copies.items():
        target = folder / name
        if target.exists() and target.resolve() != source.resolve():
            raise InputError.at(
                FaultCode.FILE_EXISTS, str(target), "", "the file is there already", "name another folder"
            )
    copies = {name: source for name, source in proposal.copies.items() if not (folder / name).exists()}
    texts = {MANIFEST_FILE: proposal.manifest, "robot.toml": proposal.robot}
    written = write_folder(folder, texts, copies)
    return replace(proposal, files=written)


def _check_together(tables: Sequence[SniffedTable]) -> None:
    first = tables[0]
    headers: dict[str, str] = {}
    for table in tables:
        display_name = table.path.name
        if table.n_rows != first.n_rows:
            reason = f"{table.n_rows} rows against {first.n_rows} in {first.path.name}"
            raise InputError.at(
                FaultCode.SHAPE_MISMATCH, display_name, "", reason, "tables that belong together have equally many rows"
            )
        if table.options != first.options:
            reason = f"it is written in another way than {first.path.name}"
            raise InputError.at(
                FaultCode.SHAPE_MISMATCH,
                display_name,
                "",
                reason,
                "save both with the same delimiter, decimal mark and header lines",
            )
        for column in table.columns:
            if column.header in headers:
                reason = f'column "{column.header}" stands in {headers[column.header]} too'
                raise InputError.at(
                    FaultCode.COLUMN_DUPLICATE, display_name, "", reason, "give each column a name of its own"
                )
            headers[column.header] = display_name


def _check_roles(roles: Roles, display_name: str) -> None:
    if roles.joints is None:
        raise InputError.at(
            FaultCode.COLUMN_MISSING,
            display_name,
            "header",
            "no joint columns are seen",
            "name them A1 … A6, J1 …, q1 … or theta1 …",
        )
    if roles.force is None and roles.mass is None:
        raise InputError.at(
            FaultCode.COLUMN_MISSING,
            display_name,
            "header",
            "no force columns are seen",
            "name them Fx, Fy, Fz, or kg for dead weights",
        )
    if roles.deflection is None and roles.position is None:
        mend = "name them dx, dy, dz (loaded minus unloaded) or X, Y, Z"
        raise InputError.at(
            FaultCode.COLUMN_MISSING, display_name, "header", "no displacement or position columns are seen", mend
        )


def _source_lines(tables: Sequence[SniffedTable], roles: Roles) -> list[str]:
    lines = ["[sources.table]"]
    if len(tables) == 1:
        lines.append(f"file = {_quoted(f'raw/{tables[0].path.name}')}")
    else:
        lines.append("files = { " + ", ".join(_file_of_signals(tables, roles)) + " }")
    if tables[0].options:
        options = ", ".join(f"{key} = {_quoted(value)}" for key, value in tables[0].options.items())
        lines.append(f"csv = {{ {options} }}")
    lines.append(_run_line(roles))
    if roles.time is not None:
        written, guessed = _unit(Role((roles.time,)), "time", "s")
        line = f"time = {{ column = {_quoted(roles.time.header)}, unit = {_quoted(written)} }}"
        lines.append(line + (f"  {GUESS} seconds" if guessed else ""))
    lines += [_joints_line(roles), *_load_lines(roles), _moved_line(roles)]
    return lines


def signal_lines(roles: Roles) -> list[str]:
    """Return the lines of those signals that a log holds, every guess marked; empty where none is recognised."""
    lines = [_joints_line(roles)] if roles.joints is not None else []
    lines += _load_lines(roles) if roles.force is not None else []
    return lines + ([_moved_line(roles)] if roles.deflection is not None or roles.position is not None else [])


def _file_of_signals(tables: Sequence[SniffedTable], roles: Roles) -> list[str]:
    """Say in which file the columns of each signal lie."""
    signals = {
        "joints": [roles.joints],
        "wrench": [roles.force, roles.moment],
        "dead_weight": [roles.mass if roles.force is None else None],
        "deflection": [roles.deflection, roles.rotation if roles.deflection is not None else None],
        "pose": [roles.position, roles.quaternion] if roles.deflection is None else [None],
    }
    sentences = []
    for signal, signal_roles in signals.items():
        columns = {column for role in signal_roles if role is not None for column in role.columns}
        files = [table.path.name for table in tables if columns & set(table.columns)]
        if len(files) > 1:
            raise InputError.at(
                FaultCode.SHAPE_MISMATCH,
                files[1],
                "header",
                f"the {signal} lies in {files[0]} too",
                "put it into one file",
            )
        sentences += [f"{signal} = {_quoted(f'raw/{files[0]}')}"] if files else []
    return sentences


def _run_line(roles: Roles) -> str:
    if roles.run is not None:
        return f"run = {{ column = {_quoted(roles.run.header)} }}"
    if roles.deflection is not None:
        return 'run = { each = "row" }'
    return f'run = {{ column = "run" }}  {GUESS} add a column that names the pose each row belongs to'


def _joints_line(roles: Roles) -> str:
    assert roles.joints is not None
    size = max(column.size for column in roles.joints.columns)
    likely = "deg" if size > _LARGEST_RADIAN else "rad"
    written, guessed = _unit(roles.joints, "angle", likely)
    line = f"joints = {{ position = {_columns(roles.joints)}, units = {{ position = {_quoted(written)} }} }}"
    return line + (f"  {GUESS} {written}, by their size (up to {size:.3g})" if guessed else "")


def _load_lines(roles: Roles) -> list[str]:
    if roles.force is None:
        assert roles.mass is not None
        written, _ = _unit(roles.mass, "mass", "kg")
        column = _quoted(roles.mass.columns[0].header)
        return [f'dead_weight = {{ mass_column = {column}, point = "tool", units = {{ mass = {_quoted(written)} }} }}']
    doubts = []
    force, guessed = _unit(roles.force, "force", "N")
    doubts += ["N"] if guessed else []
    units, columns = f"force = {_quoted(force)}", roles.force.columns
    if roles.moment is not None:
        moment, guessed = _unit(roles.moment, "moment", "N*m")
        doubts += ["N*m"] if guessed else []
        units += f", moment = {_quoted(moment)}"
        columns += roles.moment.columns
    in_base = bool({"base", "world", "robot"} & roles.force.places)
    if roles.moment is not None and not in_base:
        where = 'frame = "ft_sensor"'
        doubts.append("in the sensor's axes")
    else:
        where = f'axes = "base", point = {_quoted("tool" if roles.moment is None else "ft_sensor")}'
        doubts += [] if in_base else ["in base axes"]
    doubts.append("acts on the robot")
    line = f"wrench = {{ columns = {_columns(Role(columns))}, units = {{ {units} }}, {where} }}"
    return [f"{line}  {GUESS} {', '.join(doubts)}"]


def _moved_line(roles: Roles) -> str:
    doubts = []
    if roles.deflection is not None:
        size = max(column.size for column in roles.deflection.columns)
        likely = "m" if size < _LARGEST_DEFLECTION_M else "mm" if size < _LARGEST_DEFLECTION_M * 1e3 else "um"
        written, guessed = _unit(roles.deflection, "translation", likely)
        doubts += [f"{written}, by their size (up to {size:.3g})"] if guessed else []
        units, rotation = f"translation = {_quoted(written)}", ""
        if roles.rotation is not None:
            turned = max(column.size for column in roles.rotation.columns)
            angle, guessed = _unit(roles.rotation, "angle", "rad" if turned < _LARGEST_DEFLECTION_M else "deg")
            doubts += [f"turns in {angle}"] if guessed else []
            units, rotation = f"{units}, rotation = {_quoted(angle)}", f", rotation = {_columns(roles.rotation)}"
        doubts += [] if roles.deflection.places else ["in base axes"]
        columns = f"translation = {_columns(roles.deflection)}{rotation}"
        line = f'deflection = {{ {columns}, units = {{ {units} }}, body = "tool", axes = "base" }}'
    else:
        assert roles.position is not None
        size = max(column.size for column in roles.position.columns)
        written, guessed = _unit(roles.position, "position", "m" if size < _LARGEST_POSITION_M else "mm")
        doubts += [f"{written}, by their size (up to {size:.4g})"] if guessed else []
        columns = f"position = {_columns(roles.position)}"
        if roles.quaternion is not None:
            columns += f", quaternion_wxyz = {_columns(roles.quaternion)}"
        line = f'pose = {{ frame = "tracker", body = "tool", {columns}, units = {{ position = {_quoted(written)} }} }}'
    return line + (f"  {GUESS} {', '.join(doubts)}" if doubts else "")


def _frame_lines(roles: Roles) -> list[str]:
    reason = (
        "where it is measured" if roles.moment is not None else "where the load acts and the displacement is measured"
    )
    lines = [
        "",
        "[frames.tool]",
        'parent = "flange"',
        f"xyz_m = [0.0, 0.0, 0.0]  {GUESS} {reason}, in the flange frame",
    ]
    if roles.moment is not None:
        lines += [
            "",
            "[frames.ft_sensor]",
            'parent = "flange"',
            f"xyz_m = [0.0, 0.0, 0.0]  {GUESS} add rpy_deg if turned",
        ]
    if roles.deflection is None:
        lines += ["", "[frames.tracker]", 'parent = "base"', "estimate = true"]
    return lines


def _robot_text(roles: Roles, urdf: Path | None, robot: str | None) -> tuple[str, dict[str, Path]]:
    """Return robot.toml and the files to copy beside it."""
    assert roles.joints is not None
    if robot is not None:
        return bundled_robot(robot), {}
    if urdf is not None:
        if not urdf.is_file():
            raise InputError.at(FaultCode.FILE_MISSING, str(urdf), "", "no such file", "correct the name after --urdf")
        return f'schema = "stiffcal/robot/1"\nurdf = {_quoted(urdf.name)}\n', {urdf.name: urdf}
    rows = [
        f"[[joints]]\nname = {_quoted(column.name)}\na_m = 0.0  {GUESS}\nalpha_deg = 0.0  {GUESS}\nd_m = 0.0  {GUESS}\n"
        f"theta_deg = 0.0  {GUESS}\n"
        for column in roles.joints.columns
    ]
    head = (
        f'schema = "stiffcal/robot/1"\nconvention = "modified-dh"  {GUESS} or "dh"; fill in the rows, '
        "or start again with --robot NAME or --urdf FILE\n"
    )
    return "\n".join([head, *rows, f"[flange]\nxyz_m = [0.0, 0.0, 0.0]  {GUESS}\n"]), {}


def _check_robot_fits(proposal: Proposal, roles: Roles, urdf: Path | None) -> None:
    """Compare the robot's joints with the table's joint columns, before anything is written."""
    assert roles.joints is not None
    document = tomllib.loads(proposal.robot)
    path = urdf if urdf is not None else Path("robot.toml")
    count = len(outline_of(RobotFile.model_validate(document), path).joint_names)
    columns = len(roles.joints.columns)
    if count != columns:
        reason = f"{columns} joint columns against the {count} joints of the robot"
        raise InputError.at(
            FaultCode.JOINT_COUNT,
            "",
            "--robot" if urdf is None else "--urdf",
            reason,
            "name the robot that was measured",
        )


def _unit(role: Role, quantity: str, likely: str) -> tuple[str, bool]:
    """Return the unit of a signal's columns and whether it was guessed.

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
                "it has no unit, but its neighbours do",
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


def _columns(role: Role) -> str:
    """Write column names: as a range where that says the same, else as a list."""
    headers = [column.header for column in role.columns]
    if len(headers) > 3:
        text = f"{headers[0]}..{headers[-1]}"
        try:
            if expand_columns(text) == tuple(headers):
                return _quoted(text)
        except ValueError:
            pass
    return "[" + ", ".join(_quoted(header) for header in headers) + "]"


def _quoted(value: str | int | bool) -> str:
    """Write a value as TOML; JSON's strings are TOML's."""
    return json.dumps(value, ensure_ascii=False)

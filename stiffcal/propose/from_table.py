"""`init --from`: a campaign proposed from a table's header and values, every guess marked with ``# ?``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from stiffcal.campaign.model.model_file import MODEL_FILE
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_checks import outline_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.campaign.robot.urdf.chain import PRISMATIC
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.toml_reading import parse_toml
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.propose.answers import Ask, answered, to_write_by_hand
from stiffcal.propose.column_roles import Roles
from stiffcal.propose.explained import explained
from stiffcal.propose.explained_column import ExplainedColumn
from stiffcal.propose.joint_columns import columns_of_joints
from stiffcal.propose.lines import ProposedLine, as_text
from stiffcal.propose.noise import with_noise_lines
from stiffcal.propose.other_tables import TEXT, table_of
from stiffcal.propose.recognising import recognise
from stiffcal.propose.robot import robot_lines
from stiffcal.propose.table_lines import excluded_rows, frame_lines, run_lines, source_lines
from stiffcal.propose.table_purpose import check_purpose
from stiffcal.propose.table_sniffing import SniffedColumn, SniffedTable
from stiffcal.propose.templates import chosen_robot, write_folder
from stiffcal.propose.unnamed_columns import are_numbered, missing_names, open_columns, roles_by_values
from stiffcal.propose.urdf_arm import UrdfArm, arm_of_table


@dataclass(frozen=True)
class Proposal:
    """A campaign folder as proposed."""

    manifest: str
    """The text of campaign.toml."""
    robot: str
    """The text of robot.toml."""
    copies: dict[str, Path]
    """Name under the campaign folder to the file it is copied from."""
    guessed: tuple[str, ...]
    """The lines that are marked, each with its file."""
    files: list[Path] = field(default_factory=list)
    """What was written; empty for a draft."""
    model: str = ""
    """The text of model.toml; empty: none is written."""
    roles: Roles | None = None
    """What the columns of the tables are; None of logs."""
    columns: tuple[ExplainedColumn, ...] = ()
    """Every column of the files, with what it is taken for; of files of one device those of the first."""
    to_write: tuple[str, ...] = ()
    """What no log states: lines to write, each with its file and table."""
    runs: tuple[str, ...] = ()
    """The names of the runs that files make by patterns."""
    remarks: tuple[str, ...] = ()
    """Sentences on files: on each that is not used, on what a spreadsheet hides."""

    @property
    def unused(self) -> tuple[ExplainedColumn, ...]:
        """Columns that are not used."""
        return tuple(column for column in self.columns if not column.taken_as)


def draft_campaign(
    tables: Sequence[Path],
    *,
    urdf: Path | None = None,
    robot: str | None = None,
    tool: Sequence[float] | None = None,
    ask: Ask | None = None,
) -> Proposal:
    r"""Propose a campaign from one table, or from several of equal length that belong together.

    Parameters
    ----------
    tables : CSV files with a header; one row per load state.
    urdf : the robot as a URDF; not where `robot` is given too.
    robot : the name of a bundled robot, or the path of a robot file. With neither, robot.toml holds rows to fill in.
    tool : where the load acts and the displacement is measured, m, in the flange frame; None: a line to fill in,
        without which no command computes anything.
    ask : called with what no table states, returns the answer or ""; None: the lines are left to be written.

    Raises
    ------
    InputError
        A table cannot be understood: no joint columns, nothing that moved, displacements without loads, loads on poses
        of which none is measured twice; or it does not fit the robot.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "table.csv"
    >>> _ = path.write_text("A1,A2,A3,Fx,Fy,Fz,dx,dy,dz\n10,20,30,0,0,100,0,0,-0.2\n")
    >>> print(draft_campaign([path]).manifest.splitlines()[7][:67])
    wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "N" }, a
    """
    sniffed = [table_of(path) for path in tables]
    _check_together(sniffed)
    columns = [column for table in sniffed for column in table.columns]
    arm = arm_of_given(urdf, robot, columns)
    if are_numbered([column.header for column in columns]):
        roles = roles_by_values(columns, chain_of_given(urdf, robot), tool)
        _check_decided(sniffed[0], roles)
    else:
        roles = recognise(columns, arm.columns)
    if roles.joints is None:
        _check_names(sniffed)
    check_purpose(roles, ", ".join(table.path.name for table in sniffed))
    opening = ('schema = "stiffcal/campaign/1"', 'robot = "robot.toml"', "")
    lines = [
        *map(ProposedLine, opening),
        *with_noise_lines(source_lines(sniffed, roles, arm.prismatic), roles),
        *(ProposedLine("", sentence) for sentence in open_columns(roles)),
        *run_lines(roles),
        *frame_lines(roles, tool),
        *excluded_rows(sniffed, roles),
    ]
    lines = answered(lines, ask)
    manifest = as_text(lines)
    copies = {f"raw/{table.path.name}": table.path for table in sniffed}
    text, extra, rows = robot_text(roles, urdf, robot, arm)
    marked = [f"{MANIFEST_FILE}: {line}" for line in lines if line.doubt is not None and line.question is None]
    has_robot = urdf is not None or robot is not None
    if has_robot:  # else the rows are to be written
        marked += [f"robot.toml: {str(line).strip()}" for line in rows if line.doubt is not None]
    proposal = Proposal(
        manifest,
        text,
        copies | extra,
        tuple(marked),
        remarks=remarks_of_tables(sniffed),
        to_write=to_write_by_hand(lines, (), has_robot),
        roles=roles,
        columns=tuple(explained(sniffed, roles, arm.prismatic)),
    )
    check_robot_fits(proposal, roles, urdf)
    return proposal


def remarks_of_tables(tables: Sequence[SniffedTable]) -> tuple[str, ...]:
    """Return what a person should know of the files, each remark with its file."""
    return tuple(f"{table.path.name}: {remark}" for table in tables for remark in table.remarks)


def arm_of_given(urdf: Path | None, robot: str | None, columns: Sequence[SniffedColumn]) -> UrdfArm:
    """Return the columns of a robot's joints, by the names in its URDF or in its robot file, as far as these are there.

    Raises
    ------
    InputError : there is no such file, or the chain does not fit the columns.
    """
    if robot is not None:
        joints = RobotFile.model_validate(parse_toml(chosen_robot(robot), "robot.toml")).joints
        names = [entry.name for entry in joints]
        found = columns_of_joints(columns, names)
        prismatic = frozenset(found[entry.name] for entry in joints if entry.type == PRISMATIC and entry.name in found)
        return UrdfArm(tuple(found[name] for name in names) if len(found) == len(names) else (), (), prismatic)
    if urdf is None:
        return UrdfArm((), ())
    if not urdf.is_file():
        raise InputError.at(FaultCode.FILE_MISSING, str(urdf), "", "no such file", "correct the path after --urdf")
    return arm_of_table(urdf, columns)


def propose_campaign(
    folder: Path,
    tables: Path | Sequence[Path],
    *,
    urdf: Path | None = None,
    robot: str | None = None,
    tool: Sequence[float] | None = None,
    ask: Ask | None = None,
    overwrite: bool = False,
) -> Proposal:
    """Write a proposed campaign folder: manifest, robot file, and the tables copied into ``raw/``.

    Parameters
    ----------
    folder : made where it does not exist. overwrite : also files in it. Others as in `draft_campaign`.

    Returns
    -------
    Proposal
        With the files that were written.

    Raises
    ------
    InputError
        As `draft_campaign`; or the folder holds a campaign already.
    """
    files = [tables] if isinstance(tables, Path) else tables
    proposal = draft_campaign(files, urdf=urdf, robot=robot, tool=tool, ask=ask)
    return write_proposal(folder, proposal, overwrite=overwrite)


def write_proposal(folder: Path, proposal: Proposal, *, overwrite: bool = False) -> Proposal:
    """Write a proposed campaign folder, and return the proposal with the files that were written.

    Raises
    ------
    InputError
        A file is there already, and is not to be overwritten.
    """
    for name, source in proposal.copies.items():
        target = folder / name
        if not overwrite and target.exists() and target.resolve() != source.resolve():
            raise InputError.at(
                FaultCode.FILE_EXISTS, str(target), "", "the file already exists", "choose another folder"
            )
    copies = {name: source for name, source in proposal.copies.items() if (folder / name).resolve() != source.resolve()}
    texts = {MANIFEST_FILE: proposal.manifest, "robot.toml": proposal.robot}
    texts |= {MODEL_FILE: proposal.model} if proposal.model else {}
    written = write_folder(folder, texts, copies, overwrite=overwrite)
    return replace(proposal, files=written)


def _check_together(tables: Sequence[SniffedTable]) -> None:
    first = tables[0]
    headers: dict[str, str] = {}
    for table in tables:
        display_name = table.path.name
        if table.n_rows != first.n_rows:
            reason = f"{table.n_rows} rows, but {first.n_rows} in {first.path.name}"
            raise InputError.at(
                FaultCode.SHAPE_MISMATCH,
                display_name,
                "",
                reason,
                "tables that belong together have the same number of rows",
            )
        if (table.log_format, table.options) != (first.log_format, first.options):
            reason = f"its format differs from that of {first.path.name}"
            raise InputError.at(
                FaultCode.SHAPE_MISMATCH,
                display_name,
                "",
                reason,
                "save both with the same delimiter, decimal mark and header lines",
            )
        for column in table.columns:
            if column.header in headers:
                reason = f'column "{column.header}" is also in {headers[column.header]}'
                raise InputError.at(
                    FaultCode.COLUMN_DUPLICATE, display_name, "", reason, "give each column a unique name"
                )
            headers[column.header] = display_name


def chain_of_given(urdf: Path | None, robot: str | None) -> Chain | None:
    """Return the chain of the robot that was given, None where none was, or its file leaves it open."""
    try:
        if robot is not None:
            return chain_of(RobotFile.model_validate(parse_toml(chosen_robot(robot), "robot.toml")), Path())
        if urdf is not None:
            lines = [ProposedLine(toml_text.pair("urdf", urdf.name)), *arm_of_table(urdf, ()).lines]
            text = 'schema = "stiffcal/robot/1"\n' + as_text(lines)
            return chain_of(RobotFile.model_validate(parse_toml(text, "robot.toml")), urdf.parent)
    except InputError:  # said where the robot's own file is written
        return None
    return None


def _check_decided(table: SniffedTable, roles: Roles) -> None:
    """Raise where the values of a table without a header leave open what its columns are.

    Raises
    ------
    InputError
        They do.
    """
    loads = roles.force is not None and (roles.deflection is not None or roles.position is not None)
    if roles.joints is not None and (loads or roles.position is not None):
        return
    reason = "the table has no header line, and its values do not show what each column is"
    is_text = table.log_format == TEXT
    where = "write a line of names at its top" if is_text else "save it with a name for each column"
    mend = f"{where}, with a name for each ? that is used: {missing_names(table.columns, roles)}"
    if roles.joints is None:
        mend += "; or name the robot, whose kinematics show which column is which: --robot, --urdf"
    raise InputError.at(FaultCode.HEADER_MISSING, table.path.name, "line 1" if is_text else "", reason, mend)


def _check_names(tables: Sequence[SniffedTable]) -> None:
    """Raise where the joints may be columns that cannot be named, as several have one name.

    Raises
    ------
    InputError
        They may.
    """
    for table in tables:
        for name, why in table.left_out:
            raise InputError.at(
                FaultCode.COLUMN_DUPLICATE, table.path.name, f'column "{name}"', why, "give each column a unique name"
            )


def robot_text(
    roles: Roles, urdf: Path | None, robot: str | None, arm: UrdfArm
) -> tuple[str, dict[str, Path], list[ProposedLine]]:
    """Return the text of robot.toml, the files to copy with it, and its lines where they are proposed here.

    Parameters
    ----------
    roles : what the columns are; joints among them. urdf, robot : as in `draft_campaign`. arm : of the URDF.

    Raises
    ------
    InputError : no such robot comes with stiffcal.
    """
    assert roles.joints is not None
    if robot is not None:
        return chosen_robot(robot), {}, []
    if urdf is not None:
        rows = [
            ProposedLine('schema = "stiffcal/robot/1"'),
            ProposedLine(toml_text.pair("urdf", urdf.name)),
            *arm.lines,
        ]
        return as_text(rows), {urdf.name: urdf}, rows
    lines = robot_lines([column.name for column in roles.joints.columns])
    return as_text(lines), {}, lines


def check_robot_fits(proposal: Proposal, roles: Roles, urdf: Path | None) -> None:
    """Compare the robot's joints with the table's joint columns, before anything is written.

    Raises
    ------
    InputError : their numbers differ.
    """
    assert roles.joints is not None
    document = parse_toml(proposal.robot, "robot.toml")
    path = urdf if urdf is not None else Path("robot.toml")
    count = len(outline_of(RobotFile.model_validate(document), path).joint_names)
    columns = len(roles.joints.columns)
    if count != columns:
        reason = f"{columns} joint columns, but the robot has {count} joints"
        mend = "choose the robot that was measured"
        if urdf is not None:
            mend += ", or use the joint names of the URDF as column names"
        raise InputError.at(FaultCode.JOINT_COUNT, "", "--robot" if urdf is None else "--urdf", reason, mend)

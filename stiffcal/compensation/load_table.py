"""Tables that a person writes for a command: joints, forces and moments, positions and more, one state a row.

The only reading of such tables: `predict`, `compensate` and `plan` take files through `read_table`, the Python
interface takes arrays through `load_table_of`, and both go through the same names, units and doubts. Columns are known
by the names that people give them (`stiffcal.campaign.columns.column_names`); a unit stands by the name or in a row
under the header, else it is that of `table_columns.QUANTITIES`. Columns that are not read are named, and nothing is
guessed.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.toml.toml_reading import LARGEST
from stiffcal.compensation.table_columns import (
    ANGLES,
    AXES,
    FORCES,
    MOMENTS,
    POSITION,
    columns_of,
    joints_in_words,
)
from stiffcal.compensation.table_doubts import angle_doubts, position_doubts
from stiffcal.compensation.written_table import WrittenTable, _written, read_table
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.wording import listing


@dataclass(frozen=True)
class LoadTable:
    """Poses and loads."""

    joints: Floats
    """(n, L) logged joint angles, rad."""
    wrench: Floats
    """(n, 6) N and N·m; zero where the table has no such column."""
    doubts: tuple[str, ...] = ()
    """What was read and may not have been meant, and columns that were not read, in words."""
    where: str = "poses"
    """What the loads are from, as messages call it."""
    unit_mend: str = ""
    """What to do where the forces are in another unit; empty: the table states it."""


def read_load_table(
    file: Path, joint_names: Sequence[str], joints_needed: bool, prismatic: Collection[str] = ()
) -> LoadTable:
    """Read a table of poses and loads, in any format of logs: degrees, N and N·m unless the header states others.

    Parameters
    ----------
    file : the table.
    joint_names : the L joints of the robot.
    joints_needed : raise where a joint has no column; otherwise it stands at zero.
    prismatic : those of the joints whose positions are in mm unless the header states another unit.

    Raises
    ------
    InputError : the file is missing, a column or a cell is wrong.
    """
    table = read_table(file, joint_names, (*joint_names, *AXES), prismatic=prismatic)
    return _load_table(table, joint_names, joints_needed, prismatic)


def load_table_of(
    columns: Mapping[str, Floats], joint_names: Sequence[str], shown: str = "poses", prismatic: Collection[str] = ()
) -> LoadTable:
    """Return poses and loads from arrays by the names that the columns of such a table have.

    Parameters
    ----------
    columns : (n,) each, as the columns of `read_load_table`.
    joint_names : the L joints of the robot; each needs a column.
    shown : what the table is called in messages. prismatic : as of `read_load_table`.

    Raises
    ------
    InputError : a joint has no column, or a value is no finite number.
    """
    known = columns_of(list(columns), (), joint_names, (*joint_names, *AXES), shown, "columns", prismatic)
    numbers = {}
    for column in known:
        if column.name is None:
            continue
        values = np.asarray(columns[column.header], dtype=np.float64)
        if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > LARGEST:
            row = int(np.argmin(np.isfinite(values) & (np.abs(values) <= LARGEST))) + 1
            reason = "not a finite number, or larger than anything that is measured"
            place = f"row {row}, column {column.header}"
            raise InputError.at(FaultCode.NUMBER_INVALID, shown, place, reason, "correct the value")
        numbers[column.name] = column.factor * values
    count = max(map(len, numbers.values()), default=0)
    table = _written(shown, numbers, {}, np.arange(1, count + 1), known)
    return _load_table(table, joint_names, True, prismatic, "columns")


def _load_table(
    table: WrittenTable,
    joint_names: Sequence[str],
    joints_needed: bool,
    prismatic: Collection[str],
    place: str = "line 1",
) -> LoadTable:
    lacking = [name for name in joint_names if name not in table.numbers]
    if joints_needed and lacking:
        mend = f"the table needs a column for each of {joints_in_words(joint_names, prismatic)}"
        raise InputError.at(FaultCode.COLUMN_MISSING, table.file, place, f"no column {lacking[0]}", mend)
    doubts = [*table.unused_words, *joint_doubts(table, joint_names, prismatic)]
    doubts += load_doubts(table)
    if not any(name in table.numbers for name in AXES):
        doubts.append(f"{table.file}: no column of a force or moment: all loads are taken as zero")
    return LoadTable(table.block(joint_names), table.block(AXES), tuple(doubts), table.file, force_mend(table))


def joint_doubts(table: WrittenTable, joint_names: Sequence[str], prismatic: Collection[str]) -> list[str]:
    """Return a warning where angles that state no unit look like radians."""
    turning = [name for name in joint_names if name not in prismatic and name in table.numbers]
    if not turning or any(name in table.stated for name in turning):
        return []
    return angle_doubts(table.block(turning), table.file, _mend(turning[0], "rad", "deg"))


def place_doubts(table: WrittenTable) -> list[str]:
    """Return a warning where positions that state no unit look like metres, and one where angles look like radians."""
    doubts = []
    if table.has(POSITION) and not table.stated.intersection(POSITION):
        doubts += position_doubts(table.block(POSITION), table.file, _mend(POSITION[0], "m", "mm"))
    if table.has(ANGLES) and not table.stated.intersection(ANGLES):
        angles = table.block(ANGLES)  # most paths leave two of them at zero
        doubts += angle_doubts(angles, table.file, _mend(ANGLES[0], "rad", "deg"), "angles of the orientation", 1)
    return doubts


def load_doubts(table: WrittenTable) -> list[str]:
    """Return a warning where one of a force's or moment's components has no column next to the two others."""
    present = table.numbers.keys()
    lacking = [
        name
        for components in (FORCES, MOMENTS)
        if len(present & set(components)) == len(components) - 1
        for name in components
        if name not in present
    ]
    many = len(lacking) > 1
    return [f"{table.file}: no column{'s' * many} {listing(lacking)}: taken as zero"] if lacking else []


def force_mend(table: WrittenTable) -> str:
    """Return what to do where the forces of a table are in another unit, "" where it states theirs."""
    return "" if table.stated.intersection(FORCES) else _mend(FORCES[0], "kN", "N")


def _mend(name: str, other: str, default: str) -> str:
    return f'write the unit after the names, "{name} [{other}]", or "{name} [{default}]" if not'

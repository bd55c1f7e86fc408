"""Tables that a person writes for a command: joints, forces and moments, positions and more, one state a row.

The only reading of such tables: `predict`, `compensate` and `plan` take files through `read_table`, the Python
interface takes arrays through `load_table_of`, and both go through the same names, units and doubts. Columns are known
by the names that people give them (`stiffcal.campaign.column_names`); a unit stands by the name or in a row under the
header, else it is that of `table_columns.QUANTITIES`. Columns that are not read are named, and nothing is guessed.
"""

from __future__ import annotations

import csv
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.campaign.column_names import bare_unit, is_unit_row
from stiffcal.campaign.reach import check_given, read_given
from stiffcal.campaign.toml_reading import LARGEST
from stiffcal.compensation.table_columns import (
    AXES,
    FORCES,
    POSITION,
    ReadColumn,
    columns_of,
    joints_in_words,
)
from stiffcal.compensation.table_doubts import angle_doubts
from stiffcal.errors import InputError
from stiffcal.escapes import csv_cell
from stiffcal.fault_codes import FaultCode
from stiffcal.files import is_given
from stiffcal.limits import TABLE
from stiffcal.log_columns import WantedColumns
from stiffcal.propose.other_tables import reader_of
from stiffcal.readers import Reader
from stiffcal.wording import unused_columns

DATA_ROW = "data row"
"""What is counted in files without lines: rows below the names, in sheets without the blank ones."""


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


@dataclass(frozen=True)
class WrittenTable:
    """Any such table, SI."""

    file: str
    """As it is called in messages."""
    numbers: Mapping[str, Floats]
    """Column name, as `table_columns` has it, to (n,)."""
    words: Mapping[str, tuple[str, ...]]
    """Column name to n words."""
    lines: NDArray[np.int64]
    """(n,) line of each row in the file, or its number among the rows of data."""
    stated: frozenset[str] = frozenset()
    """Columns whose unit stands in the table."""
    unused: tuple[str, ...] = ()
    """Headers of the columns that were not read."""
    remarks: tuple[str, ...] = ()
    """What a person should know of the file, in words: rows that a spreadsheet hides."""
    line_word: str = "line"
    """What `lines` counts."""

    def __len__(self) -> int:
        return len(self.lines)

    def place(self, row: int) -> str:
        """Return where a row (from 0) stands in the file."""
        return f"{self.line_word} {self.lines[row]}"

    def has(self, names: Iterable[str]) -> bool:
        """Return whether all these columns of numbers stand in the table."""
        return all(name in self.numbers for name in names)

    def block(self, names: Sequence[str]) -> Floats:
        """Return (n, k) columns side by side; zero where there is none of that name."""
        zero = np.zeros(len(self))
        return np.stack([self.numbers.get(name, zero) for name in names], axis=1)

    @property
    def unused_words(self) -> list[str]:
        """Sentences on what a spreadsheet hides, and on the columns that were not read; none where all were."""
        return [f"{self.file}: {words}" for words in (*self.remarks, *unused_columns(self.unused))]


def read_load_table(
    file: Path, joint_names: Sequence[str], joints_needed: bool, prismatic: Collection[str] = ()
) -> LoadTable:
    """Read a CSV of poses and loads: commas or semicolons; degrees, N and N·m unless the header states others.

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
    if not any(name in table.numbers for name in AXES):
        doubts.append(f"{table.file}: no column of a force or moment: all loads are taken as zero")
    return LoadTable(table.block(joint_names), table.block(AXES), tuple(doubts), table.file, force_mend(table))


def joint_doubts(table: WrittenTable, joint_names: Sequence[str], prismatic: Collection[str]) -> list[str]:
    """Return a warning where angles that state no unit look like radians."""
    turning = [name for name in joint_names if name not in prismatic and name in table.numbers]
    if not turning or any(name in table.stated for name in turning):
        return []
    return angle_doubts(table.block(turning), table.file, _mend(turning[0], "rad", "deg"))


def force_mend(table: WrittenTable) -> str:
    """Return what to do where the forces of a table are in another unit, "" where it states theirs."""
    return "" if table.stated.intersection(FORCES) else _mend(FORCES[0], "kN", "N")


def place_mend() -> str:
    """Return what to do where the positions of a table are in metres."""
    return _mend(POSITION[0], "m", "mm")


def _mend(name: str, other: str, default: str) -> str:
    return f'write the unit after the names, "{name} [{other}]", or "{name} [{default}]" if not'


def read_table(
    file: Path,
    joint_names: Sequence[str],
    asked: Sequence[str],
    words: Sequence[str] = (),
    prismatic: Collection[str] = (),
) -> WrittenTable:
    """Read a table of named columns; the names of those that are not asked for are kept.

    Parameters
    ----------
    file : the table: commas, semicolons or tabs between the cells, and the second line may hold units; or a workbook
        or another file that names its columns itself.
    joint_names : the L joints of the robot, whose columns are in degrees where no unit is stated.
    asked : names of columns of numbers: joints, and names of `table_columns`.
    words : names of columns of words. prismatic : as of `read_load_table`.

    Raises
    ------
    InputError : the file is missing, a column or a cell is wrong.
    """
    display_name = str(file)
    if not is_given(file):
        raise InputError.at(FaultCode.FILE_MISSING, display_name, "", "no such file", "correct the path")
    check_given(file)
    reader = reader_of(file) if file.is_file() else None
    if reader is not None:
        return _read_other(reader, file, joint_names, asked, words, prismatic)
    numbered = _numbered_lines(file)
    lines = [line for _, line in numbered]
    if len(lines) < 2:
        raise InputError.at(
            FaultCode.FILE_EMPTY, display_name, "line 1", "the table is empty", "write a header and at least one row"
        )
    delimiter = ";" if ";" in lines[0] else "\t" if "\t" in lines[0] else ","
    try:
        header, *rows = list(csv.reader(lines, delimiter=delimiter))
    except csv.Error as error:
        mend = "close every quotation mark, with one number per cell"
        raise InputError.at(FaultCode.SYNTAX_INVALID, display_name, "", f"not a table: {error}", mend) from error
    units: list[str] = []
    if len(rows) > 1 and len(rows[0]) == len(header) and is_unit_row(rows[0]):
        units, rows, numbered = [bare_unit(cell) for cell in rows[0]], rows[1:], [numbered[0], *numbered[2:]]
    place = f"line {numbered[0][0]}"
    headers = [csv_cell.original(word) for word in header]
    columns = columns_of(headers, units, joint_names, (*asked, *words), display_name, place, prismatic)
    at = np.array([number for number, _ in numbered[1:]], dtype=np.int64)
    numbers = {
        column.name: np.zeros(len(rows)) for column in columns if column.name is not None and column.name in asked
    }
    texts: dict[str, list[str]] = {column.name: [] for column in columns if column.name in words and column.name}
    for number, row in enumerate(rows):
        if len(row) != len(columns):
            reason = f"{len(row)} cells, the header has {len(columns)}"
            raise InputError.at(
                FaultCode.SHAPE_MISMATCH, display_name, f"line {at[number]}", reason, "complete the line"
            )
        for column, cell in zip(columns, row, strict=True):
            if column.name in numbers:
                value = _number(cell, display_name, f"line {at[number]}", column.header, delimiter)
                numbers[column.name][number] = column.factor * value
            elif column.name in texts:
                texts[column.name].append(csv_cell.original(cell.strip()))
    # a delimiter at the end of every line makes a column without a name and without a cell
    held = [k for k, column in enumerate(columns) if column.header.strip() or any(row[k].strip() for row in rows)]
    return _written(display_name, numbers, texts, at, [columns[k] for k in held])


def _read_other(
    reader: Reader,
    file: Path,
    joint_names: Sequence[str],
    asked: Sequence[str],
    words: Sequence[str],
    prismatic: Collection[str],
) -> WrittenTable:
    """Read the table in a file of another format than text; the parameters and errors are those of `read_table`."""
    display_name = str(file)
    header = reader.read_header(file, {}, display_name)
    units = [header.units.get(name, "") for name in header.columns]
    place = f"{reader.name} {header.options['sheet']}" if "sheet" in header.options else "columns"
    columns = columns_of(header.columns, units, joint_names, (*asked, *words), display_name, place, prismatic)
    in_file = {column.name: column for column in columns if column.name is not None}
    of_numbers = {name: column for name, column in in_file.items() if name in asked}
    of_words = {name: column for name, column in in_file.items() if name in words}
    wanted = WantedColumns(
        tuple(column.header for column in of_numbers.values()), tuple(column.header for column in of_words.values())
    )
    parts = list(reader.read_batches(file, {}, wanted, display_name)) if in_file else []
    count = sum(map(len, parts))
    numbers = {}
    for name, column in of_numbers.items():
        values = np.concatenate([part.numbers[column.header] for part in parts])
        if np.any(large := np.abs(values) > LARGEST):
            row = int(np.argmax(large))
            raise _too_large(values[row], display_name, f"{DATA_ROW} {row + 1}, column {column.header}")
        numbers[name] = column.factor * values
    texts = {name: [word for part in parts for word in part.texts[column.header]] for name, column in of_words.items()}
    named = [column for column in columns if column.header]
    table = _written(display_name, numbers, texts, np.arange(1, count + 1), named)
    return replace(table, remarks=header.remarks, line_word=DATA_ROW)


def _written(
    display_name: str,
    numbers: Mapping[str, Floats],
    texts: Mapping[str, Sequence[str]],
    lines: NDArray[np.int64],
    columns: Iterable[ReadColumn],
) -> WrittenTable:
    stated = frozenset(column.name for column in columns if column.name is not None and column.stated)
    unused = tuple(column.header.strip() or "without a name" for column in columns if column.name is None)
    words = {name: tuple(cells) for name, cells in texts.items()}
    return WrittenTable(display_name, numbers, words, lines, stated, unused)


def _numbered_lines(file: Path) -> list[tuple[int, str]]:
    """Return the lines of a file that hold something, each with its number."""
    try:
        text = read_given(file, TABLE).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError.at(
            FaultCode.FILE_UNREADABLE, str(file), "", f"cannot be read: {error}", "give a CSV file in UTF-8"
        ) from error
    return [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]


def _number(cell: str, display_name: str, line: str, header: str, delimiter: str) -> float:
    text = cell.strip().replace(",", ".") if delimiter != "," else cell.strip()
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    place = f"{line}, column {header.strip()}"
    if not np.isfinite(value):
        reason = f"{cell!r} is not a number"
        raise InputError.at(FaultCode.NUMBER_INVALID, display_name, place, reason, "correct the cell")
    if abs(value) > LARGEST:
        raise _too_large(value, display_name, place)
    return value


def _too_large(value: float, display_name: str, place: str) -> InputError:
    reason = f"{value:g} is larger than any plausible value"
    return InputError.at(FaultCode.NUMBER_INVALID, display_name, place, reason, "correct the cell")

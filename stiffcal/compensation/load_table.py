"""Tables that a person writes: joints by name, Fx … Tz, positions and more, a unit in brackets where it is another."""

from __future__ import annotations

import csv
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.campaign.reach import read_given
from stiffcal.campaign.toml_reading import LARGEST
from stiffcal.errors import InputError
from stiffcal.escapes import csv_cell
from stiffcal.fault_codes import FaultCode
from stiffcal.files import is_given
from stiffcal.limits import TABLE
from stiffcal.quantities import unit

AXES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
_HEADER = re.compile(r"\s*+(?P<name>[^\[\]]++)(?:\[\s*+(?P<unit>[^\]]++)\]\s*+)?")


POSITION = ("X", "Y", "Z")
QUATERNION, ANGLES = ("qw", "qx", "qy", "qz"), ("roll", "pitch", "yaw")
# quantity and unit of the columns that are known by name; joints are added by theirs
QUANTITIES: dict[str, tuple[str, str]] = (
    {name: ("force", "N") if name.startswith("F") else ("moment", "N*m") for name in AXES}
    | dict.fromkeys(POSITION, ("position", "mm"))
    | dict.fromkeys(ANGLES, ("angle", "deg"))
    | {"t": ("time", "s")}
)


@dataclass(frozen=True)
class LoadTable:
    """Poses and loads."""

    joints: Floats
    """(n, L) logged joint angles, rad."""
    wrench: Floats
    """(n, 6) N and N·m; zero where the table has no such column."""


@dataclass(frozen=True)
class WrittenTable:
    """Any such table, SI."""

    file: str
    """As it is called in messages."""
    numbers: Mapping[str, Floats]
    """Column name to (n,)."""
    words: Mapping[str, tuple[str, ...]]
    """Column name to n words."""
    lines: NDArray[np.int64]
    """(n,) line of each row in the file."""

    def __len__(self) -> int:
        return len(self.lines)

    def has(self, names: Sequence[str]) -> bool:
        """Return whether all these columns of numbers stand in the table."""
        return all(name in self.numbers for name in names)

    def block(self, names: Sequence[str]) -> Floats:
        """Return (n, k) columns side by side; zero where there is none of that name."""
        zero = np.zeros(len(self))
        return np.stack([self.numbers.get(name, zero) for name in names], axis=1)


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
    lacking = [name for name in joint_names if name not in table.numbers]
    if joints_needed and lacking:
        mend = f"the table needs a column for each of {joints_in_words(joint_names, prismatic)}"
        raise InputError.at(FaultCode.COLUMN_MISSING, table.file, "line 1", f"no column {lacking[0]}", mend)
    return LoadTable(table.block(joint_names), table.block(AXES))


def load_table_of(
    columns: Mapping[str, Floats], joint_names: Sequence[str], shown: str = "poses", prismatic: Collection[str] = ()
) -> LoadTable:
    """Return poses and loads from arrays by the names that the columns of such a table have.

    Parameters
    ----------
    columns : (n,) each: joints in degrees, Fx … Tz in N and N·m, another unit in brackets (``A1 [rad]``); other names
        are passed over.
    joint_names : the L joints of the robot; each needs a column.
    shown : what the table is called in messages. prismatic : as of `read_load_table`.

    Raises
    ------
    InputError : a joint has no column, or a value is no finite number.
    """
    columns_read = {word: _column(word, joint_names, (*joint_names, *AXES), shown, prismatic) for word in columns}
    known = {name: (word, factor) for word, (name, factor) in columns_read.items() if name in (*joint_names, *AXES)}
    lacking = [name for name in joint_names if name not in known]
    if lacking:
        mend = f"give a column for each of {joints_in_words(joint_names, prismatic)}"
        raise InputError.at(FaultCode.COLUMN_MISSING, shown, "columns", f"no column {lacking[0]}", mend)
    numbers = {}
    for name, (word, factor) in known.items():
        values = np.asarray(columns[word], dtype=np.float64)
        if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > LARGEST:
            place = f"row {int(np.argmin(np.isfinite(values) & (np.abs(values) <= LARGEST))) + 1}, column {word}"
            reason = "not a finite number, or larger than anything that is measured"
            raise InputError.at(FaultCode.NUMBER_INVALID, shown, place, reason, "correct the value")
        numbers[name] = factor * values
    count = len(numbers[joint_names[0]])
    nothing = np.zeros(count)
    return LoadTable(
        np.stack([numbers[name] for name in joint_names], axis=1),
        np.stack([numbers.get(name, nothing) for name in AXES], axis=1),
    )


def joints_in_words(joint_names: Sequence[str], prismatic: Collection[str]) -> str:
    """Return the joints and the unit of their columns, as in a mend."""
    lengths = [name for name in joint_names if name in prismatic]
    unit = f"degrees; {', '.join(lengths)}: mm" if lengths else "degrees"
    return f"{', '.join(joint_names)} ({unit})"


def read_table(
    file: Path,
    joint_names: Sequence[str],
    asked: Sequence[str],
    words: Sequence[str] = (),
    prismatic: Collection[str] = (),
) -> WrittenTable:
    """Read a CSV of named columns; columns that are not asked for are passed over.

    Parameters
    ----------
    file : the table: commas, semicolons or tabs between the cells.
    joint_names : the L joints of the robot, whose columns are in degrees where no unit is stated.
    asked : names of columns of numbers: joints, and names of `QUANTITIES` and `QUATERNION`.
    words : names of columns of words. prismatic : as of `read_load_table`.

    Raises
    ------
    InputError : the file is missing, a column or a cell is wrong.
    """
    display_name = str(file)
    if not is_given(file):
        raise InputError.at(FaultCode.FILE_MISSING, display_name, "", "no such file", "correct the path")
    try:
        text = read_given(file, TABLE).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError.at(
            FaultCode.FILE_UNREADABLE, display_name, "", f"cannot be read: {error}", "give a CSV file in UTF-8"
        ) from error
    numbered = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
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
    known = (*asked, *words)
    columns = [_column(csv_cell.original(word), joint_names, known, display_name, prismatic) for word in header]
    at = np.array([number for number, _ in numbered[1:]], dtype=np.int64)
    numbers = {name: np.zeros(len(rows)) for name, _ in columns if name in asked}
    texts: dict[str, list[str]] = {name: [] for name, _ in columns if name in words}
    for number, row in enumerate(rows):
        if len(row) != len(columns):
            reason = f"{len(row)} cells, the header has {len(columns)}"
            raise InputError.at(
                FaultCode.SHAPE_MISMATCH, display_name, f"line {at[number]}", reason, "complete the line"
            )
        for (name, factor), cell in zip(columns, row, strict=True):
            if name in numbers:
                numbers[name][number] = factor * _number(cell, display_name, int(at[number]), name, delimiter)
            elif name in texts:
                texts[name].append(csv_cell.original(cell.strip()))
    return WrittenTable(display_name, numbers, {name: tuple(cells) for name, cells in texts.items()}, at)


def _column(
    word: str, joint_names: Sequence[str], asked: Sequence[str], display_name: str, prismatic: Collection[str]
) -> tuple[str, float]:
    """Return a column's name and the factor to SI; 1 for a column that is not asked for."""
    match = _HEADER.fullmatch(word)
    name, named_unit = (match["name"].strip(), (match["unit"] or "").strip()) if match else (word.strip(), "")
    if name not in asked:
        plain = {_plain(known): known for known in asked}
        if _plain(name) in plain:  # a load or an angle that would silently be taken as zero
            reason = f"unknown column {name}"
            raise InputError.at(
                FaultCode.COLUMN_MISSING, display_name, "line 1", reason, f"did you mean {plain[_plain(name)]}?"
            )
        return name, 1.0
    quantity, default = ("angle", "deg") if name in joint_names else QUANTITIES.get(name, ("", ""))
    if name in prismatic:
        quantity, default = "length", "mm"
    if not quantity:
        return name, 1.0
    try:
        return name, unit(named_unit or default, quantity).factor
    except ValueError as error:
        raise InputError.at(
            FaultCode.UNIT_UNKNOWN, display_name, f"line 1, column {name}", str(error), f"write it in {default}"
        ) from error


def _plain(name: str) -> str:
    return re.sub(r"[\W_]", "", name).casefold()


def _number(cell: str, display_name: str, line: int, name: str, delimiter: str) -> float:
    text = cell.strip().replace(",", ".") if delimiter == ";" else cell.strip()
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise InputError.at(
            FaultCode.NUMBER_INVALID,
            display_name,
            f"line {line}, column {name}",
            f"{cell!r} is not a number",
            "correct the cell",
        )
    if abs(value) > LARGEST:
        reason = f"{value:g} is larger than any plausible value"
        raise InputError.at(
            FaultCode.NUMBER_INVALID, display_name, f"line {line}, column {name}", reason, "correct the cell"
        )
    return value

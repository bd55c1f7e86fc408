"""Tables of poses and loads that a person writes: joints by name, Fx … Tz, a unit in brackets where it is another."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.quantities import unit

Floats = NDArray[np.float64]

AXES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
_HEADER = re.compile(r"^\s*(?P<name>[^\[\]]+?)\s*(?:\[\s*(?P<unit>[^\]]+?)\s*\])?\s*$")


@dataclass(frozen=True)
class LoadTable:
    """Poses and loads.

    Attributes
    ----------
    joints : (n, L) logged joint angles, rad.
    wrench : (n, 6) N and N·m; zero where the table has no such column.
    """

    joints: Floats
    wrench: Floats


def read_load_table(file: Path, joint_names: Sequence[str], joints_needed: bool) -> LoadTable:
    """Read a CSV of poses and loads: commas or semicolons; degrees, N and N·m unless the header says otherwise.

    Parameters
    ----------
    file : the table.
    joint_names : the L joints of the robot.
    joints_needed : raise where a joint has no column; otherwise it stands at zero.

    Raises
    ------
    InputError : the file is missing, a column or a cell is wrong.
    """
    shown = str(file)
    if not file.is_file():
        raise InputError.at(shown, "", "no such file", "correct its name")
    try:
        text = file.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError.at(shown, "", f"cannot be read: {error}", "give a CSV file in UTF-8") from error
    numbered = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    lines = [line for _, line in numbered]
    if len(lines) < 2:
        raise InputError.at(shown, "line 1", "the table is empty", "write a header and at least one row")
    delimiter = ";" if ";" in lines[0] else "\t" if "\t" in lines[0] else ","
    header, *rows = list(csv.reader(lines, delimiter=delimiter))
    columns = [_column(word, joint_names, shown) for word in header]
    found = {name for name, _ in columns}
    lacking = [name for name in joint_names if name not in found]
    if joints_needed and lacking:
        mend = f"the table needs a column for each of {', '.join(joint_names)} (degrees)"
        raise InputError.at(shown, "line 1", f"no column {lacking[0]}", mend)
    joints, wrench = np.zeros((len(rows), len(joint_names))), np.zeros((len(rows), 6))
    for number, row in enumerate(rows):
        line = numbered[number + 1][0]
        if len(row) != len(columns):
            reason = f"{len(row)} cells, the header has {len(columns)}"
            raise InputError.at(shown, f"line {line}", reason, "complete the line")
        for (name, factor), cell in zip(columns, row, strict=True):
            if name in joint_names:
                joints[number, joint_names.index(name)] = factor * _number(cell, shown, line, name, delimiter)
            elif name in AXES:
                wrench[number, AXES.index(name)] = factor * _number(cell, shown, line, name, delimiter)
    return LoadTable(joints, wrench)


def _column(word: str, joint_names: Sequence[str], shown: str) -> tuple[str, float]:
    """Return a column's name and the factor to SI; 1 for a column that is not asked for."""
    match = _HEADER.match(word)
    name, named_unit = (match["name"], match["unit"]) if match else (word.strip(), None)
    if name in joint_names:
        quantity, default = "angle", "deg"
    elif name in AXES:
        quantity, default = ("force", "N") if name.startswith("F") else ("moment", "N*m")
    else:
        plain = {_plain(known): known for known in (*joint_names, *AXES)}
        if _plain(name) in plain:  # a load or an angle that would silently be taken as zero
            reason = f"no column is called {name} here"
            raise InputError.at(shown, "line 1", reason, f"did you mean {plain[_plain(name)]}?")
        return name, 1.0
    try:
        return name, unit(named_unit or default, quantity).factor
    except ValueError as error:
        raise InputError.at(shown, f"line 1, column {name}", str(error), f"write it in {default}") from error


def _plain(name: str) -> str:
    return re.sub(r"[\W_]", "", name).casefold()


def _number(cell: str, shown: str, line: int, name: str, delimiter: str) -> float:
    text = cell.strip().replace(",", ".") if delimiter == ";" else cell.strip()
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise InputError.at(shown, f"line {line}, column {name}", f"{cell!r} is no number", "correct the cell")
    return value

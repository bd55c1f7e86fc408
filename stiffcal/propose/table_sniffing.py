"""Looking at a table of unknown make: encoding, delimiter, decimal mark, header, unit row, values.

For `init --from` alone, which only proposes; the readers then read exactly what the manifest states.
"""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from stiffcal.campaign.column_names import bare_unit, header_parts, is_unit_row
from stiffcal.errors import InputError
from stiffcal.escapes import csv_cell
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.scope_export import PROPERTIES, TIME, TIME_UNIT, is_scope_header, scope_columns, scope_units
from stiffcal.measurements.timestamps import seconds_of_times
from stiffcal.packed_files import UNPACKING_ERRORS, unpacked_stream

# So many rows show a column's unit by their size; a longer log is not read to its end.
ROWS_LOOKED_AT = 5000
BYTES_LOOKED_AT = 1 << 22

_DELIMITERS = (";", "\t", ",", "|")


@dataclass(frozen=True)
class SniffedColumn:
    """One column of a table."""

    header: str
    """As it stands in the file."""
    name: str
    """Without the unit."""
    unit: str | None
    """As written in header or unit row, or None."""
    values: tuple[float, ...]
    """Its numbers; empty where the column holds words."""

    @property
    def size(self) -> float:
        """Largest absolute value of those that are finite; 0 where there is none."""
        return max((abs(value) for value in self.values if math.isfinite(value)), default=0.0)


@dataclass(frozen=True)
class SniffedTable:
    """What was found in the first rows of a table."""

    path: Path
    """The file."""
    columns: tuple[SniffedColumn, ...]
    """In order."""
    n_rows: int
    """Data rows, as far as looked at."""
    options: dict[str, str | int | bool]
    """What the manifest must say under `csv` for the file to be read; empty where the defaults hold."""


def sniff_table(path: Path) -> SniffedTable:
    """Read the columns of a table, with proposals for their units.

    Raises
    ------
    InputError
        Not there, empty, no text, no table, or no header.
    """
    display_name = path.name
    text, encoding = _decoded(path, display_name)
    lines = re.split("\r\n|[\n\r]", text)[: ROWS_LOOKED_AT + 100]  # not what else Unicode takes for an end of a line
    try:
        delimiter = _delimiter(lines, display_name)
        rows = [[cell.strip() for cell in row] for line in lines for row in csv.reader([line], delimiter=delimiter)]
    except csv.Error as error:
        mend = "give a table with one row per load state"
        raise InputError.at(FaultCode.SYNTAX_INVALID, display_name, "", f"not a table: {error}", mend) from error
    width = _width(rows)
    decimal = "," if delimiter != "," and _decimal_commas(rows) else "."
    scope_header = _scope_header(rows)
    first_after_header = scope_header[3] if scope_header is not None else 0
    first = next(
        (k for k, row in enumerate(rows) if k >= first_after_header and len(row) == width and _is_data(row, decimal)),
        None,
    )
    if first is None:
        raise InputError.at(
            FaultCode.FILE_EMPTY,
            display_name,
            "",
            "the file has no line of numbers",
            "give a table with one row per load state",
        )
    header, names, units = scope_header[:3] if scope_header is not None else _header(rows, first, width, display_name)
    data = [row for row in rows[first:] if len(row) == width]
    names = [csv_cell.original(name) for name in names]
    columns = tuple(_column(names[k], units[k], [row[k] for row in data], decimal) for k in range(width))
    _check_names(columns, display_name, header + 1)
    options: dict[str, str | int | bool] = {}
    if delimiter != ",":
        options["delimiter"] = "tab" if delimiter == "\t" else delimiter
    if decimal != ".":
        options["decimal"] = decimal
    if encoding != "utf-8":
        options["encoding"] = encoding
    if header:
        options["skip_rows"] = header
    return SniffedTable(path, columns, len(data), options)


def _header(rows: list[list[str]], first: int, width: int, display_name: str) -> tuple[int, list[str], list[str]]:
    """Return the row of names above the first row of data, the names, and the units below them."""
    above = [k for k in range(first) if len(rows[k]) == width]
    if not above:
        raise InputError.at(
            FaultCode.HEADER_MISSING,
            display_name,
            f"line {first + 1}",
            "the table has no header line",
            "add a line with the column names",
        )
    header = above[-1]
    if len(above) > 1 and is_unit_row(rows[header]):
        return above[-2], rows[above[-2]], rows[header]
    return header, rows[header], [""] * width


def _scope_header(rows: list[list[str]]) -> tuple[int, list[str], list[str], int] | None:
    """Return the row of names, names, units and first row below of a scope's export; None where it is none."""
    for k in range(len(rows) - 1):
        names = rows[k]
        if is_scope_header(names, rows[k + 1]):
            columns = scope_columns(names)
            below = next(
                (n for n, row in enumerate(rows) if n > k and any(row) and row[0] not in PROPERTIES), len(rows)
            )
            written = next((row for row in rows[k:below] if row and row[0] == "Unit"), [])
            units = scope_units(names, columns, written)
            return k, list(columns), [units.get(column, "") for column in columns], below
    return None


def _decoded(path: Path, display_name: str) -> tuple[str, str]:
    try:
        with path.open("rb") as file:
            content = unpacked_stream(file).read(BYTES_LOOKED_AT)
        if len(content) == BYTES_LOOKED_AT:  # a long log: whole lines of its beginning
            content = content[: content.rfind(b"\n") + 1]
    except FileNotFoundError:
        raise InputError.at(
            FaultCode.FILE_MISSING, str(path), "", "no such file", "correct the path after --from"
        ) from None
    except UNPACKING_ERRORS as error:
        if not isinstance(error, OSError) or error.errno is None:
            reason = "the compressed file is damaged or incomplete"
            raise InputError.at(FaultCode.FILE_INCOMPLETE, str(path), "", reason, "copy it again") from None
        raise InputError.at(
            FaultCode.FILE_UNREADABLE, str(path), "", f"cannot be read: {error.strerror}", "give a table"
        ) from None
    if not content.strip():
        raise InputError.at(
            FaultCode.FILE_EMPTY, display_name, "", "the file is empty", "give a table with a header and rows"
        )
    if b"\0" in content[:4096]:
        raise InputError.at(
            FaultCode.FORMAT_UNKNOWN, display_name, "", "this is not a text file", "save the table as CSV"
        )
    try:
        return content.decode("utf-8-sig"), "utf-8"
    except UnicodeDecodeError:
        return content.decode("latin-1"), "latin-1"


def _delimiter(lines: list[str], display_name: str) -> str:
    """Choose the delimiter that cuts most lines into the same number of cells, three or more."""
    best, score = "", 0
    for delimiter in _DELIMITERS:
        counts = Counter(len(next(csv.reader([line], delimiter=delimiter), [])) for line in lines if line.strip())
        often = max((times for width, times in counts.items() if width >= 3), default=0)
        if often > score:  # at a tie the earlier one: decimal commas cut evenly too
            best, score = delimiter, often
    if not best:
        raise InputError.at(
            FaultCode.FORMAT_UNKNOWN,
            display_name,
            "",
            "no columns found",
            "separate them by commas, semicolons or tabs",
        )
    return best


def _width(rows: list[list[str]]) -> int:
    return Counter(len(row) for row in rows if len(row) >= 3).most_common(1)[0][0]


def _decimal_commas(rows: list[list[str]]) -> bool:
    cells = [cell for row in rows for cell in row]
    commas = sum(1 for cell in cells if re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell))
    points = sum(1 for cell in cells if re.fullmatch(r"[+-]?\d*\.\d+([eE][+-]?\d+)?", cell))
    return commas > points


def _number(cell: str, decimal: str) -> float | None:
    try:
        return float(cell.replace(",", ".") if decimal == "," else cell)
    except ValueError:
        return None


def _is_data(row: list[str], decimal: str) -> bool:
    """Three cells or most are numbers: names of a run, a group, a point, a date may stand between them."""
    numbers = sum(_number(cell, decimal) is not None for cell in row)
    return numbers >= 0.6 * len(row) or 3 <= numbers >= 0.4 * len(row)


def _column(header: str, unit_cell: str, cells: list[str], decimal: str) -> SniffedColumn:
    numbers = [_number(cell, decimal) for cell in cells]
    values = tuple(number for number in numbers if number is not None)
    if not values and (moments := _moments(cells)):
        return SniffedColumn(header, header, "iso8601", moments)
    parts = header_parts(header)
    name, written = parts.name, parts.unit or bare_unit(unit_cell) or None
    if header.startswith(f"{TIME} ") and written == TIME_UNIT:  # of one channel of a scope
        name = TIME
    filled = sum(1 for cell in cells if cell)  # a target is hidden at times
    return SniffedColumn(header, name, written, values if len(values) > 0.5 * filled else ())


def _moments(cells: list[str]) -> tuple[float, ...]:
    """Return dates with times as seconds; empty where the column holds other words."""
    try:
        return tuple(seconds_of_times(cells[:ROWS_LOOKED_AT], "", "", 1).tolist())
    except InputError:
        return ()


def _check_names(columns: tuple[SniffedColumn, ...], display_name: str, line: int) -> None:
    twice = [name for name, count in Counter(column.header for column in columns).items() if count > 1 and name]
    if twice:
        reason = f'two columns have the name "{twice[0]}"'
        raise InputError.at(
            FaultCode.COLUMN_DUPLICATE, display_name, f"line {line}", reason, "give each column a unique name"
        )

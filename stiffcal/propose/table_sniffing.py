"""Looking at a table of unknown make: its layout as the reader of text recognises it, and what its columns hold."""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from stiffcal.campaign.columns.column_headers import header_parts, is_unit
from stiffcal.errors import InputError
from stiffcal.escapes import csv_cell, toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.scope_export import TIME, TIME_UNIT
from stiffcal.measurements.timestamps import DAY_FIRST, seconds_of_times, unit_of_times
from stiffcal.packed_files import UNPACKING_ERRORS, unpacked_stream
from stiffcal.readers import check_is_log
from stiffcal.table_layout.cells import is_gap, is_time, number
from stiffcal.table_layout.layout import Layout
from stiffcal.table_layout.sections import first_table, title_line
from stiffcal.table_layout.text import FIRST_BYTES, encoding_of, rows_of_lines, text_layout

# So many rows show a column's unit by their size; a longer log is not read to its end.
ROWS_LOOKED_AT = 5000
BYTES_LOOKED_AT = 1 << 22


@dataclass(frozen=True)
class SniffedColumn:
    """One column of a table."""

    header: str
    """Its name for the manifest."""
    name: str
    """Without the unit."""
    unit: str | None
    """As written in header or unit row, or None."""
    values: tuple[float, ...]
    """Its numbers; empty where the column holds words."""
    has_reading: tuple[bool, ...] = field(default=(), compare=False)
    """Of each row, whether there is a number; empty where that was not looked at."""
    doubt: str | None = field(default=None, compare=False)
    """What is open about its unit, for a person to look at; None where nothing is."""

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
    """Those with a name of their own, in order."""
    n_rows: int
    """Data rows, as far as looked at."""
    options: Mapping[str, str | int | bool] = field(default_factory=dict)
    """What the manifest must say of the file's format for the file to be read; empty where the defaults hold."""
    log_format: str = "csv"
    """The format, after which the manifest's table of options is named."""
    rate_hz: float | None = None
    """Rows per second, where the file states it."""
    left_out: tuple[tuple[str, str], ...] = ()
    """Columns that no manifest can name, each with the reason."""
    remarks: tuple[str, ...] = ()
    """What a person should know of the file, in words."""
    uneven: bool = False
    """Whether columns are known to be of different lengths, which no source holds together."""
    no_readings: Mapping[int, str] = field(default_factory=dict)
    """Data rows (from 1) that are no readings: blank ones, "", and those below with a word among numbers: "mean"."""

    @property
    def options_text(self) -> str:
        """The manifest's line of the options, "" where the defaults hold."""
        options = ", ".join(f"{key} = {toml_text.value(value)}" for key, value in self.options.items())
        return f"{self.log_format} = {{ {options} }}" if options else ""


def sniff_table(path: Path, section: str = "") -> SniffedTable:
    """Read the columns of a text table.

    Parameters
    ----------
    section : the name of the table, where the text holds several; "" where it is one.

    Raises
    ------
    InputError
        Not there, empty, no text, no table.
    """
    display_name = path.name
    text, encoding = _decoded(path, display_name, section)
    layout = text_layout(text[: text.rfind("\n", 0, FIRST_BYTES) + 1] or text, encoding)
    lines = text.split("\n")[layout.first_data_line - 1 :][:ROWS_LOOKED_AT]
    if len(layout.columns) < _FEWEST_COLUMNS:
        raise InputError.at(
            FaultCode.FORMAT_UNKNOWN,
            display_name,
            "",
            "no columns found",
            "separate them by commas, semicolons, tabs or blanks",
        )
    limit = csv.field_size_limit()
    if any(len(line) > limit for line in lines):
        reason = f"not a table: field larger than field limit ({limit})"
        mend = "give a table with one row per load state"
        raise InputError.at(FaultCode.SYNTAX_INVALID, display_name, "", reason, mend)
    rows, _ = rows_of_lines(lines, layout.delimiter)
    options = {"section": section} if section else {}
    return sniffed_table(path, [row for row in rows if len(row) > 1 or any(row)], layout.rows, options)


# Of a table that a signal of three components, or a joint and what loads it, can be in.
_FEWEST_COLUMNS = 2


def sniffed_table(
    path: Path,
    rows: Sequence[Sequence[str]],
    layout: Layout,
    options: Mapping[str, str | int | bool] | None = None,
) -> SniffedTable:
    """Return what the columns of a table hold.

    Parameters
    ----------
    path : of the file. rows : of data, as cells. layout : of the table. options : that the manifest has to state.

    Raises
    ------
    InputError
        There is no row of numbers.
    """
    width = len(layout.columns)
    numbered = {
        k: [*row, *[""] * (width - len(row))]
        for k, row in enumerate(rows, start=1)
        if layout.shortest <= len(row) <= width
    }
    no_readings = _no_readings(numbered, layout)
    data = [row for k, row in numbered.items() if not no_readings.get(k)]
    count = dict.fromkeys(layout.columns, 0)
    for name in layout.columns:
        count[name] += 1
    columns = []
    for k, name in enumerate(layout.columns):
        if name and count[name] == 1:
            columns.append(_column(csv_cell.original(name), layout, [row[k] for row in data]))
    repeated = tuple(
        (name, f'{"two" if n == 2 else n} columns have the name "{name}"')
        for name, n in count.items()
        if name and n > 1
    )
    if repeated and not any(column.values for column in columns):
        raise InputError.at(
            FaultCode.COLUMN_DUPLICATE, path.name, "header", repeated[0][1], "give each column a unique name"
        )
    if not any(column.values for column in columns):
        raise InputError.at(
            FaultCode.FILE_EMPTY,
            path.name,
            "",
            "the file has no line of numbers",
            "give a table with one row per load state",
        )
    return SniffedTable(
        path,
        tuple(columns),
        sum(map(any, data)),
        dict(options or {}),
        rate_hz=layout.rate_hz,
        left_out=repeated,
        no_readings=no_readings,
    )


_MOST_REMARKS = 20
"""Rows below the readings that are remarks; more are readings of another kind."""


def _no_readings(rows: Mapping[int, Sequence[str]], layout: Layout) -> dict[int, str]:
    """Return the blank rows, and the last ones that hold a word where the first row holds a number, with the word."""
    filled = {k: row for k, row in rows.items() if any(row)}
    first = next(iter(filled.values()), ())
    remarks: dict[int, str] = {}
    for k, row in reversed(filled.items()):
        word = next((cell for cell, above in zip(row, first, strict=True) if _in_place(cell, above, layout)), "")
        if not word:
            break
        remarks[k] = word
    remarks = remarks if len(remarks) < min(_MOST_REMARKS, len(filled)) else {}
    return dict(sorted((remarks | {k: "" for k in rows if k not in filled}).items()))


def _in_place(cell: str, above: str, layout: Layout) -> bool:
    """Return whether a cell holds a word in place of a number."""
    return cell[:1].isalpha() and not is_gap(cell) and not _is_number(cell, layout) and _is_number(above, layout)


def _is_number(cell: str, layout: Layout) -> bool:
    return number(cell, layout.decimal, layout.thousands) is not None


def _decoded(path: Path, display_name: str, section: str) -> tuple[str, str]:
    """Return the beginning of a text, or of one table in it, and its encoding."""
    try:
        with path.open("rb") as file:
            stream = unpacked_stream(file)
            content = stream.read(BYTES_LOOKED_AT)
            encoding = encoding_of(content[:FIRST_BYTES])
            text = _from_title(content, stream, section, encoding) if section else content.decode(encoding, "replace")
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
    check_is_log(path, display_name, content)
    text = re.sub("\r\n?", "\n", text.removeprefix("\ufeff"))
    if "\0" in text[:4096]:
        raise InputError.at(
            FaultCode.FORMAT_UNKNOWN, display_name, "", "this is not a text file", "save the table as CSV"
        )
    if len(content) == BYTES_LOOKED_AT:  # a long log: whole lines of its beginning
        text = text[: text.rfind("\n") + 1]
    return first_table(text) if section else text, encoding


def _from_title(content: bytes, stream: IO[bytes], section: str, encoding: str) -> str:
    """Return the beginning of a table in a text, from the line that names it on."""
    pattern = title_line(section)
    decoder = codecs.getincrementaldecoder(encoding)("replace")
    ends = io.IncrementalNewlineDecoder(None, translate=True)
    text, is_there = b"", False
    while content and len(text) < BYTES_LOOKED_AT:
        text += ends.decode(decoder.decode(content)).encode("utf-8")
        if not is_there:
            found = pattern.search(text)
            is_there = found is not None
            text = text[text.rfind(b"\n") + 1 :][-FIRST_BYTES:] if found is None else text[found.start() :]
        content = stream.read(BYTES_LOOKED_AT)
    return text[:BYTES_LOOKED_AT].decode("utf-8", "replace")


def _column(header: str, layout: Layout, cells: list[str]) -> SniffedColumn:
    numbers = [number(cell, layout.decimal, layout.thousands) for cell in cells]
    values = tuple(found for found in numbers if found is not None)
    has_reading = tuple(found is not None for found in numbers)
    if not values and (times := column_of_times(header, cells)) is not None:
        return times
    if not values and (with_unit := next((cell for cell in cells if _holds_unit(cell)), None)) is not None:
        doubt = f"units stand in its cells ({with_unit!r}): write the unit into its name, and numbers alone below"
        return SniffedColumn(header, header, None, (), has_reading, doubt)
    parts = header_parts(header)
    name, written = parts.name, parts.unit or layout.units.get(header)
    if header.startswith(f"{TIME} ") and written == TIME_UNIT:  # of one channel of a scope
        name = TIME
    filled = [cell for cell in cells if not is_gap(cell)]  # a target is hidden at times
    if len(values) > 0.5 * len(filled):
        return SniffedColumn(header, name, written, values, has_reading)
    other = next((cell for cell in filled if number(cell, layout.decimal, layout.thousands) is None), None)
    if other is None or not all(map(_IN_DIGITS.fullmatch, filled)):
        return SniffedColumn(header, name, written, (), has_reading)
    doubt = f"its cells are no numbers ({other!r}): write digits with one decimal mark, and a minus sign in front"
    return SniffedColumn(header, name, written, (), has_reading, doubt)


_NUMBER_AND_UNIT = re.compile(r"[+-]?\d[\d.,]{0,20}(?:[eE][+-]?\d{1,3})? {0,2}(?P<unit>[^\s\d.,;]{1,6})")


_IN_DIGITS = re.compile(r"[-+(\u2212]?\d[\d., '\u00a0\u202f\u2019]{0,40}[-)]?")
"""Digits and marks, as accountants write them (1.5-, (1.5)), or in groups that are not of three."""


def _holds_unit(cell: str) -> bool:
    match = _NUMBER_AND_UNIT.fullmatch(cell)
    return match is not None and is_unit(match["unit"])


def column_of_times(header: str, cells: list[str]) -> SniffedColumn | None:
    """Return a column of dates or times of day, as seconds; None where it holds other words."""
    words = [cell for cell in cells if cell]
    if not words or not all(map(is_time, words)):
        return None
    has_reading = tuple(bool(cell) for cell in cells)
    try:
        seconds = seconds_of_times(words, "", "", 1)
        return SniffedColumn(header, header, unit_of_times(words), tuple(seconds.tolist()), has_reading)
    except InputError as error:
        if error.faults[0].code is not FaultCode.TIME_AMBIGUOUS:
            return None
        seconds = seconds_of_times(words, "", "", 1, DAY_FIRST)
        values = tuple(seconds.tolist())
        return SniffedColumn(header, header, DAY_FIRST, values, has_reading, f"{error.faults[0].reason}: month-first?")

"""Where a text log is broken: a slow pass over its lines that names line, column and value.

It runs only after the fast parser has refused the file, so that its cost does not matter, and judges every line by the
same rules.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from stiffcal.campaign.signals.row_filter import condition_text
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import WantedColumns
from stiffcal.readers.csv.lines import TAIL, LogText
from stiffcal.table_layout.cells import is_gap, number
from stiffcal.table_layout.sections import GAP_LINE
from stiffcal.table_layout.text import TextLayout

_OF_A_SEGMENT = ("Channels", "***Start_Special***", "***End_of_Header***")
CUT_OFF = "log again, or delete the last line in a copy of the file"


def find_fault(
    path: Path, layout: TextLayout, wanted: WantedColumns, rows_read: int, display_name: str
) -> InputError | None:
    """Return the first fault after data row `rows_read`, or None where every line is sound.

    Parameters
    ----------
    rows_read : data rows that are known to be good; they are passed over.
    """
    with LogText(path, layout.encoding, display_name) as text:
        row = empty_line = 0
        lines = text.lines()
        for line in lines:
            if text.line_number < layout.first_data_line:
                continue
            if layout.section and GAP_LINE.fullmatch(line + b"\n"):
                break
            if not line:
                empty_line = empty_line or text.line_number
                continue
            if empty_line and len(layout.columns) == 1:
                # With one column an empty line is an empty cell; at the end of the file it is nothing.
                place = f"line {empty_line}, column {layout.columns[0]}"
                return InputError.at(
                    FaultCode.CELL_EMPTY,
                    display_name,
                    place,
                    "the cell is empty",
                    "delete the line in a copy of the file",
                )
            row += 1
            if row > rows_read:
                fault = _line_fault(line, text, layout, wanted, display_name, row)
                if fault is not None:
                    return _with_further_rows(fault, line, lines, text, layout, wanted, display_name, row)
    return None


# Of rows that one [[exclude]] leaves out: more are no remarks below a table, and another column is meant.
_MOST_LISTED = 20


def _with_further_rows(
    first: InputError,
    line: bytes,
    below: Iterator[bytes],
    text: LogText,
    layout: TextLayout,
    wanted: WantedColumns,
    display_name: str,
    row: int,
) -> InputError:
    """Return a fault whose mend leaves out every row with words among the numbers, where that is the fault."""
    if not _holds_words(line, layout, wanted):
        return first
    place, rows, number_of_row = text.line_number, [row], row
    for further in below:
        if not further:
            continue
        number_of_row += 1
        if not _holds_words(further, layout, wanted):
            if _line_fault(further, text, layout, wanted, display_name, number_of_row) is not None:
                break  # another fault, which is named once this one is mended
            continue
        rows.append(number_of_row)
        if len(rows) > _MOST_LISTED:
            return first
    return _line_fault(line, text, layout, wanted, display_name, row, rows, place) or first


def _holds_words(line: bytes, layout: TextLayout, wanted: WantedColumns) -> bool:
    """Return whether a whole row has a cell of words where a number is wanted."""
    try:
        cells = layout.split(line.decode("utf-8", "replace"), strict=True)
    except csv.Error:
        return False
    if len(cells) != len(layout.columns):
        return False
    held = [cells[layout.columns.index(name)] for name in wanted.names if name in wanted.numbers]
    return any(not is_gap(cell) and not layout.is_number(cell) for cell in held)


def _line_fault(
    line: bytes,
    text: LogText,
    layout: TextLayout,
    wanted: WantedColumns,
    display_name: str,
    row: int,
    rows: Sequence[int] = (),
    line_number: int = 0,
) -> InputError | None:
    place = f"line {line_number or text.line_number}"
    cut_off = text.unfinished
    if b"\0" in line:
        reason = "the line contains NUL bytes: writing the log was interrupted"
        return InputError.at(
            FaultCode.FILE_INCOMPLETE,
            display_name,
            place,
            reason,
            "log again, or delete the line in a copy of the file",
        )
    try:
        cells = layout.split(line.decode("utf-8", "replace"), strict=True)
    except csv.Error as error:
        reason = "a quotation mark is not closed, or not followed by the end of the cell"
        if b'"' not in line:
            reason = f"not a table: {error}"
        return InputError.at(
            FaultCode.SYNTAX_INVALID, display_name, place, reason, "correct the line in a copy of the file"
        )
    if cells and cells[0] in _OF_A_SEGMENT:  # its values look like rows of data
        reason = "a second segment of LabVIEW begins, with a head of its own"
        mend = 'log with "Segment Headers: One header only", or put each segment into a file of its own'
        return InputError.at(FaultCode.SHAPE_MISMATCH, display_name, place, reason, mend)
    if len(cells) != len(layout.columns):
        return _count_fault(cells, line, layout, display_name, place, cut_off, row)
    for name in wanted.names:
        cell = cells[layout.columns.index(name)]
        at = f"{place}, column {name}"
        if name not in wanted.numbers:
            if not cell and name not in wanted.gaps:
                return InputError.at(FaultCode.CELL_EMPTY, display_name, at, "the cell is empty", "fill it in")
            if "\ufffd" in cell:
                reason = f"{cell!r} is not {layout.encoding}"
                return InputError.at(
                    FaultCode.ENCODING_WRONG, display_name, at, reason, 'set csv.encoding, e.g. "latin-1" or "cp1252"'
                )
        elif name not in wanted.unjudged and not (name in wanted.gaps and is_gap(cell)):
            fault = _number_fault(cell, name, layout, row, rows or (row,))
            if fault is not None:
                reason, mend = fault
                if cut_off and name == layout.columns[-1]:
                    reason, mend = f"the file is cut off in the middle of a line ({cell!r})", CUT_OFF
                return InputError.at(FaultCode.FILE_INCOMPLETE, display_name, at, reason, mend)
    return None


def _count_fault(
    cells: list[str], line: bytes, layout: TextLayout, display_name: str, place: str, cut_off: bool, row: int
) -> InputError:
    expected, n_cells = len(layout.columns), len(cells)
    if cut_off and n_cells < expected:
        reason = f"the file is cut off in the middle of a line ({n_cells} of {expected} cells)"
        return InputError.at(FaultCode.FILE_INCOMPLETE, display_name, place, reason, CUT_OFF)
    reason = f"{n_cells} cell{'s' * (n_cells != 1)}, the header has {expected}"
    if not line.strip():
        reason = "the line contains only blanks"
    mend = "log again, or delete the line in a copy of the file"
    if line.strip(b" \t\r") == b"EOF":
        reason, mend = (
            "the export marks its end",
            "export without the EOF tag, or delete this line in a copy of the file",
        )
    elif row == 1:
        mend = "check csv.skip_rows and csv.delimiter"
        if layout.delimiter == "," and n_cells > expected:
            mend += "; decimal commas need another delimiter or quotation marks"
    return InputError.at(FaultCode.SHAPE_MISMATCH, display_name, place, reason, mend)


def _number_fault(cell: str, name: str, layout: TextLayout, row: int, rows: Sequence[int]) -> tuple[str, str] | None:
    """Return reason and mend where the cell of a row is no finite number; ``rows`` are those with such a fault."""
    found = number(cell, layout.rows.decimal, layout.rows.thousands)
    if found is not None:
        if math.isfinite(found):
            return None
        return f"{cell!r} is too large for a number", "log again, or delete the line in a copy of the file"
    only_readings = toml_text.pair("rows", condition_text(name, "!=", ""))
    exclude = f"[[exclude]] with {toml_text.pair('rows', list(rows))}"
    left_out = (
        f"give it, keep only rows that have one ({only_readings} in the source), or leave this one out: {exclude}"
    )
    if not cell:
        return "the cell is empty", left_out
    other_mark = "," if layout.rows.decimal == "." else "."
    if re.fullmatch(r"[+-]?\d*" + re.escape(other_mark) + r"\d+([eE][+-]?\d+)?", cell):
        reason = f"{cell!r} has a decimal mark other than {layout.rows.decimal!r}"
        if row > 1:  # the rows before have the layout's
            return reason, f"correct the cell in a copy, or leave the row out: {exclude}"
        return reason, f"set csv.{toml_text.pair('decimal', other_mark)}"
    if re.fullmatch(r"[+-]?\d{1,3}([., '\u00a0]\d{3})+([.,]\d+)?", cell):
        return f"{cell!r} has thousands separators", "write numbers without separators"
    if cell == name:
        return f"the header is repeated here ({cell!r})", "the log was started twice: split it into two files"
    if is_gap(cell):
        return f"{cell!r} is not a finite number", left_out
    if cell.lower().lstrip("+-") in ("inf", "infinity"):
        return f"{cell!r} is not a finite number", f"give the reading, or leave the row out: {exclude}"
    return (
        f"{cell!r} is not a number",
        f"name another column, correct the cell in a copy, or leave the row{'s' * (len(rows) > 1)} out: {exclude}",
    )


def check_last_line(text: LogText, layout: TextLayout, wanted: WantedColumns, display_name: str) -> None:
    """Raise `InputError` where the file's last line has no line end and its last number may be cut.

    It is whole for certain where the last column is not wanted, or stands in quotation marks, or has as many decimals
    as in all lines before it.
    """
    last_column = layout.columns[-1]
    if not text.unfinished or last_column not in wanted.names:
        return
    *before, last = text.tail.split(b"\n")
    if len(text.tail) == TAIL:
        # The first of these begins somewhere in its line.
        del before[0]
    cell = _last_cell(last, layout)
    earlier = [_last_cell(line, layout) for line in before[-50:]]
    if cell.endswith('"'):
        return
    if last_column in wanted.numbers:
        shape = _decimals(cell, layout.rows.decimal)
        complete = (
            shape is not None
            and bool(earlier)
            and all(_decimals(earlier_cell, layout.rows.decimal) == shape for earlier_cell in earlier)
        )
    else:
        complete = cell in earlier
    if not complete:
        place = f"last line, column {last_column}"
        reason = f"the file ends without a line end after {cell!r}: it may be cut off in the middle of a number"
        raise InputError.at(
            FaultCode.FILE_INCOMPLETE,
            display_name,
            place,
            reason,
            "log again; if the number is whole, end the line in a copy of the file",
        )


def _last_cell(line: bytes, layout: TextLayout) -> str:
    return line.decode("utf-8", "replace").rpartition(layout.delimiter)[2].strip(" \t")


def _decimals(cell: str, decimal: str) -> tuple[int, int] | None:
    """Return the number of digits after the decimal mark and in the exponent; None without a decimal mark."""
    match = re.fullmatch(r"[+-]?\d*" + re.escape(decimal) + r"(\d+)(?:[eEdD]([+-]?\d+))?", cell)
    return (len(match[1]), len(match[2] or "")) if match else None

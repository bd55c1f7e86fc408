"""Tables as workbooks of Excel: numbers are numbers, and no text is a formula."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

ENDING = ".xlsx"
MOST_ROWS, MOST_COLUMNS, LONGEST_TEXT = 1_048_576, 16_384, 32_767
"""What a sheet holds (Microsoft, "Excel specifications and limits")."""
_CREATED = datetime(1980, 1, 1)  # one for all: the same table gives the same bytes


def check_size(display_name: str, n_rows: int, n_columns: int) -> None:
    """Raise an `InputError` where a table has more rows, names included, or columns than a sheet."""
    for amount, most, what in ((n_rows + 1, MOST_ROWS, "rows"), (n_columns, MOST_COLUMNS, "columns")):
        if amount > most:
            reason, mend = f"a sheet holds {most} {what}, the table has {amount}", "write *.csv or *.parquet"
            raise InputError.at(FaultCode.SIZE_EXCEEDED, display_name, "", reason, mend)


def write_workbook(file: Path, names: Sequence[str], rows: Iterable[Sequence[object]], sheet: str) -> None:
    """Write a table as a workbook with one sheet.

    Parameters
    ----------
    file : to write. names : of the columns. sheet : its name.
    rows : numbers, words and truth values; a number that is missing (None, NaN) is an empty cell.

    Raises
    ------
    OSError : the file cannot be written.
    """
    import xlsxwriter

    options = {"constant_memory": True, "strings_to_formulas": False, "strings_to_urls": False}
    with xlsxwriter.Workbook(str(file), options) as book:
        book.set_properties({"created": _CREATED})
        page = book.add_worksheet(sheet)
        page.freeze_panes(1, 0)
        bold = book.add_format({"bold": True})
        for column, name in enumerate(names):
            page.write_string(0, column, _text(name), bold)
        for number, row in enumerate(rows, start=1):
            for column, value in enumerate(row):
                if isinstance(value, bool):
                    page.write_boolean(number, column, value)
                elif isinstance(value, int | float) and math.isfinite(value):
                    page.write_number(number, column, value)
                elif not _is_missing(value):
                    page.write_string(number, column, _text(str(value)))


def _is_missing(value: object) -> bool:
    return value is None or value == "" or (isinstance(value, float) and math.isnan(value))


def _text(words: str) -> str:
    """Return a text as a sheet can hold it."""
    return words[:LONGEST_TEXT].encode("utf-8", "replace").decode("utf-8")

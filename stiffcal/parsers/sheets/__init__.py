"""Sheets of workbooks: the cells of one sheet as a table. calamine gives their values, `outlines` what it leaves out.

A library of values alone would give a cell that was never computed, or that holds an error, as an empty one, and rows
that the person has hidden like all others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.limits import COLUMNS
from stiffcal.log_columns import (
    Options,
    damaged_file_errors,
    nearest_name,
)
from stiffcal.parsers.sheets.open_sheet import ROWS_FOR_LAYOUT, Cell, OpenSheet, Sheet
from stiffcal.parsers.sheets.outlines import Outline, OutlineOf
from stiffcal.table_layout.layout import layout_of_rows

if TYPE_CHECKING:
    from python_calamine import CalamineSheet, CalamineWorkbook

LIBRARIES = ("python_calamine",)
"""Imported before the limits of a log hold."""
SAVE_AS_XLSX = 'save it as "Excel workbook (.xlsx)" in a spreadsheet program'


@contextmanager
def open_sheet(
    path: Path, options: Options, display_name: str, log_format: str, outline_of: OutlineOf
) -> Iterator[OpenSheet]:
    """Open a sheet of a workbook.

    Parameters
    ----------
    path : of the file. options : checked. display_name : how to call it in a fault.
    log_format : whose options they are. outline_of : reads what the values of a sheet do not show.

    Raises
    ------
    InputError
        For a damaged file, a sheet that is not there, several that may be meant.
    """
    with _opened(path, display_name, outline_of) as (book, outlines, hidden):
        sheet = _chosen(book, outlines, hidden, options, display_name, log_format)
        yield OpenSheet(sheet, options, display_name, hidden)


def tables_of_sheets(path: Path, display_name: str, outline_of: OutlineOf) -> list[Options]:
    """Return the options that choose each visible sheet that holds numbers; errors as of `open_sheet`."""
    with _opened(path, display_name, outline_of) as (book, outlines, hidden):
        found = _with_numbers(book, outlines, hidden, display_name)
    return [{"sheet": sheet.name} for sheet in found] if len(found) > 1 else [{}]


@contextmanager
def _opened(
    path: Path, display_name: str, outline_of: OutlineOf
) -> Iterator[tuple[CalamineWorkbook, dict[str, Outline], list[str]]]:
    """Open a workbook: yield it, the outlines of its sheets by name, and the names of those that are hidden."""
    from python_calamine import CalamineWorkbook, SheetVisibleEnum

    mend = "open it in a spreadsheet program, and save it again"
    with damaged_file_errors("workbook", display_name, mend), open_regular(path, display_name) as file:
        _check_kind(file.read(8), display_name)
        file.seek(0)
        outlines = outline_of(file, path.stat().st_size, display_name)
        for name, outline in outlines.items():
            outline.check_size(display_name, f"sheet {name!r}")
        file.seek(0)
        with CalamineWorkbook.from_filelike(file) as book:
            hidden = [sheet.name for sheet in book.sheets_metadata if sheet.visible != SheetVisibleEnum.Visible]
            yield book, outlines, hidden


def _check_kind(first_bytes: bytes, display_name: str) -> None:
    if first_bytes.startswith(b"\xd0\xcf\x11\xe0"):
        reason = "a workbook of Excel 97 to 2003 (.xls), or one that is protected by a password"
        mend = f"{SAVE_AS_XLSX}, without a password"
        raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, display_name, "", reason, mend)


def _chosen(
    book: CalamineWorkbook,
    outlines: dict[str, Outline],
    hidden: Sequence[str],
    options: Options,
    display_name: str,
    log_format: str,
) -> Sheet:
    """Return the sheet that the options name, else the only visible one that holds numbers."""
    requested = options.get("sheet")
    if requested is not None:
        if str(requested) not in outlines:
            mend = nearest_name(str(requested), list(outlines))
            place = f"{log_format}.sheet"
            raise InputError.at(FaultCode.LOG_PART_MISSING, display_name, place, f"no sheet {requested!r}", mend)
        return _sheet(book, str(requested), outlines, display_name)
    with_numbers = _with_numbers(book, outlines, hidden, display_name)
    if len(with_numbers) == 1:
        return with_numbers[0]
    if not with_numbers:
        reason = "no visible sheet holds numbers"
        raise InputError.at(FaultCode.FILE_EMPTY, display_name, "", reason, "fill the table in, or leave the file out")
    reason = f"{len(with_numbers)} sheets hold numbers"
    listed = ", ".join(repr(sheet.name) for sheet in with_numbers[:12])
    raise InputError.at(
        FaultCode.LOG_PART_AMBIGUOUS, display_name, f"{log_format}.sheet", reason, f"state which: {listed}"
    )


def _with_numbers(
    book: CalamineWorkbook, outlines: dict[str, Outline], hidden: Sequence[str], display_name: str
) -> list[Sheet]:
    """Return the visible sheets that hold numbers; where none does, those whose texts are numbers."""
    sheets = [_sheet(book, name, outlines, display_name) for name in outlines if name not in hidden]
    found = [sheet for sheet in sheets if any(isinstance(cell, float) for row in sheet.rows for cell in row)]
    return found or [sheet for sheet in sheets if layout_of_rows(sheet.texts()[:ROWS_FOR_LAYOUT]).holds_numbers]


def _sheet(book: CalamineWorkbook, name: str, outlines: dict[str, Outline], display_name: str) -> Sheet:
    COLUMNS.check(outlines[name].n_columns, display_name, f"sheet {name!r}")
    return Sheet(name, _rows(book.get_sheet_by_name(name)), outlines[name])


def _rows(sheet: CalamineSheet) -> list[list[Cell]]:
    """Return the rows of a sheet, from its first row and column on."""
    rows: Any = sheet.to_python(skip_empty_area=False)
    return list(rows)

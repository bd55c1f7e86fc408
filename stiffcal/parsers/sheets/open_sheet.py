"""One sheet of a workbook as a log: its header found, its cells read as numbers or as they stand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import date, datetime, time, timedelta
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.log_columns import (
    Batch,
    Options,
    WantedColumns,
    check_columns,
    first_not_finite,
)
from stiffcal.measurements.timestamps import seconds_of_times
from stiffcal.parsers.open_log import FIRST_ROWS, OpenLog
from stiffcal.parsers.sheets.outlines import Outline, cell_name
from stiffcal.table_layout.cells import is_gap, number
from stiffcal.table_layout.layout import Layout, layout_of_rows

if TYPE_CHECKING:
    pass

Cell: TypeAlias = str | float | bool | datetime | date | time | timedelta
ROWS_FOR_LAYOUT = 1000
"""So many rows show where the names stand, and how numbers are written."""
_MOST_LISTED = 20
"""Of rows that one [[exclude]] leaves out: more are no remarks below a table, and another column is meant."""
_NUMBERED_ROWS = 4
"""Rows of which a remark names each; of more it names the first and says how many."""


@dataclass(frozen=True)
class Sheet:
    """The cells of one sheet.

    Attributes
    ----------
    name : of the sheet. rows : of its cells, from the first row and column on. outline : what the values do not show.
    """

    name: str
    rows: list[list[Cell]]
    outline: Outline

    def texts(self) -> list[list[str]]:
        """Return the cells as text; what was merged stands in each cell that it covers."""
        texts = [[text_of_cell(cell) for cell in row] for row in self.rows]
        for top, left, bottom, right in self.outline.merged:
            for row in texts[top : bottom + 1]:
                row[left : right + 1] = [texts[top][left]] * len(row[left : right + 1])
        return texts


class OpenSheet(OpenLog):
    """The table in a sheet."""

    def __init__(self, sheet: Sheet, options: Options, display_name: str, hidden_sheets: Sequence[str]) -> None:
        self.display_name, self.place = display_name, f"sheet {sheet.name!r}"
        self._sheet, self._given = sheet, options
        self._texts = sheet.texts()
        layout = self._layout(())
        self.columns, self.units = layout.columns, dict(layout.units)
        self.n_rows = len(self._data_rows(layout))
        self.options = {**options, "sheet": sheet.name}
        self.remarks = tuple(self._remarks(layout, hidden_sheets))

    def _layout(self, wanted: Sequence[str]) -> Layout:
        skip, decimal, unit_row = (self._given.get(key) for key in ("skip_rows", "decimal", "unit_row"))
        return layout_of_rows(
            self._texts[:ROWS_FOR_LAYOUT],
            wanted=wanted,
            header_row=skip if isinstance(skip, int) else None,
            unit_row=unit_row if isinstance(unit_row, bool) else None,
            decimal=str(decimal) if decimal else None,
        )

    def _data_rows(self, layout: Layout) -> list[int]:
        """Return the numbers of the rows, from 0, that hold something under the names."""
        count = len(layout.columns)
        return [
            row
            for row in range(layout.first_data_row, len(self._texts))
            if any(map(str.strip, self._texts[row][:count]))
        ]

    def _remarks(self, layout: Layout, hidden_sheets: Sequence[str]) -> Iterator[str]:
        outline, place = self._sheet.outline, self.place
        hidden = [row for row in self._data_rows(layout) if row in outline.hidden_rows]
        if hidden:
            listed = ", ".join(str(row + 1) for row in hidden[:_NUMBERED_ROWS])
            more = f" and {len(hidden) - _NUMBERED_ROWS} more" if len(hidden) > _NUMBERED_ROWS else ""
            rows = f"row {listed} is" if len(hidden) == 1 else f"rows {listed}{more} are"
            yield f"{place}: {rows} hidden in the spreadsheet, and read like all others"
        columns = [name for k, name in enumerate(layout.columns) if name and (k in outline.hidden_columns)]
        if columns:
            listed = ", ".join(map(repr, columns))
            plural = "s" * (len(columns) > 1)
            yield f"{place}: hidden in the spreadsheet, and read where wanted: column{plural} {listed}"
        others = [name for name in hidden_sheets if name != self._sheet.name]
        if others:
            listed = ", ".join(map(repr, others))
            yield f"not read, as hidden in the spreadsheet: sheet{'s' * (len(others) > 1)} {listed}"
        if self._sheet.name in hidden_sheets:
            yield f"{place} is hidden in the spreadsheet"

    def check(self, wanted: WantedColumns) -> None:
        """Raise an `InputError` for each wanted column that is not there."""
        check_columns(wanted, self._layout(wanted.names).columns, self.display_name, self.place)

    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            A cell is empty, merged with others, an error, not computed, or not of the column's kind.
        """
        layout = self._layout(wanted.names)
        rows = self._data_rows(layout)
        if not rows:
            raise InputError.at(
                FaultCode.FILE_EMPTY, self.display_name, self.place, "no data below the names", "fill the table in"
            )
        at = {name: layout.columns.index(name) for name in wanted.names}
        merged = {
            (row, column)
            for top, left, bottom, right in self._sheet.outline.merged
            for row in range(max(top, layout.first_data_row), min(bottom + 1, len(self._texts)))
            for column in set(at.values()) & set(range(left, right + 1))
            if (row, column) != (top, left)
        }
        for start in range(0, len(rows), self.BATCH_ROWS):
            yield self._batch(rows[start : start + self.BATCH_ROWS], start, wanted, at, layout, merged)

    def _batch(
        self,
        rows: list[int],
        start: int,
        wanted: WantedColumns,
        at: dict[str, int],
        layout: Layout,
        merged: set[tuple[int, int]],
    ) -> Batch:
        numbers: dict[str, Floats] = {}
        texts: dict[str, list[str]] = {}
        for name in wanted.names:
            column = at[name]
            if name in wanted.numbers:
                numbers[name] = self._numbers(rows, start, column, name, wanted, layout, merged)
                continue
            for row in rows:
                self._check_cell(row, column, name)
            cells = [self._texts[row][column].strip() if column < len(self._texts[row]) else "" for row in rows]
            if "" in cells:
                raise self._fault(
                    FaultCode.CELL_EMPTY, rows[cells.index("")], column, name, "the cell is empty", "fill it in"
                )
            if name in wanted.times:
                numbers[name] = seconds_of_times(cells, self.display_name, name, start + 1)
            else:
                texts[name] = cells
        bad = first_not_finite(numbers, wanted, 0)
        if bad is not None:
            reason = f"{bad[2]} is not a finite number"
            mend = "give the reading, or leave the row out with [[exclude]]"
            raise self._fault(FaultCode.NUMBER_INVALID, rows[bad[0]], at[bad[1]], bad[1], reason, mend)
        return Batch(start + 1, numbers, texts)

    def _numbers(
        self,
        rows: list[int],
        start: int,
        column: int,
        name: str,
        wanted: WantedColumns,
        layout: Layout,
        merged: set[tuple[int, int]],
    ) -> Floats:
        """Return a column's numbers, of one in which any cell may stand infinite ones for what is none."""
        values, faults = np.full(len(rows), np.inf), dict[int, InputError]()
        for k, row in enumerate(rows):
            try:
                self._check_cell(row, column, name)
                values[k] = self._number(row, column, name, layout, name in wanted.gaps, (row, column) in merged)
            except InputError as error:
                faults[start + k + 1] = error
                if len(faults) > _MOST_LISTED:
                    break
        if not faults or name in wanted.unjudged:
            return values
        (first,) = next(iter(faults.values())).faults
        if len(faults) <= _MOST_LISTED:
            out = f"leave the row{'s' * (len(faults) > 1)} out: [[exclude]] with {toml_text.pair('rows', list(faults))}"
            first = replace(first, mend=f"{first.mend}, or {out}", rows=tuple(faults))
        raise InputError(first)

    def first_rows(self, names: Sequence[str]) -> Iterator[Batch]:
        """Yield the first rows of columns of unknown kind: as numbers where most are, words among them as gaps.

        Titles and means below a table are words in columns of numbers.
        """
        self.BATCH_ROWS = FIRST_ROWS
        everything = frozenset(names)
        batch = self._first_rows(WantedColumns(tuple(names), gaps=everything, unjudged=everything))
        if batch is None:
            return
        for name in names:
            values = batch.numbers[name]
            if np.isinf(values).sum() <= 0.5 * np.sum(~np.isnan(values)):
                yield Batch(batch.first_row, {name: np.where(np.isinf(values), np.nan, values)}, {})
            elif (words := self._first_rows(WantedColumns((), (name,)))) is not None:
                yield words

    def _check_cell(self, row: int, column: int, name: str) -> None:
        """Refuse a cell that the spreadsheet has not computed, or could not."""
        outline = self._sheet.outline
        if (row, column) in outline.errors:
            reason, mend = "the cell holds an error of the spreadsheet, as #DIV/0!", "mend its formula"
            raise self._fault(FaultCode.NUMBER_INVALID, row, column, name, reason, mend)
        if (row, column) in outline.formulas and not self._text(row, column):
            reason = "the cell holds a formula whose value is not in the file"
            mend = "open the file in a spreadsheet program and save it, which computes it, or paste the values"
            raise self._fault(FaultCode.CELL_EMPTY, row, column, name, reason, mend)

    def _text(self, row: int, column: int) -> str:
        cells = self._sheet.rows[row]
        return text_of_cell(cells[column]) if column < len(cells) else ""

    def _number(self, row: int, column: int, name: str, layout: Layout, gaps: bool, merged: bool) -> float:
        cells = self._sheet.rows[row]
        cell = cells[column] if column < len(cells) else ""
        if merged:
            reason = "the cell is merged with another: one reading does not count for several rows"
            raise self._fault(FaultCode.CELL_EMPTY, row, column, name, reason, "unmerge the cells and fill each in")
        if isinstance(cell, bool):
            reason, mend = f"{text_of_cell(cell)} is not a number", "use a column of numbers"
            raise self._fault(FaultCode.NUMBER_INVALID, row, column, name, reason, mend)
        if isinstance(cell, float | int):
            return float(cell)
        if isinstance(cell, time | timedelta):
            return seconds_of_day(cell)
        if isinstance(cell, date):
            reason = f"the cell holds a date, {cell.isoformat()}"
            mend = 'a spreadsheet takes 1.5 or 1/2 for one: enter the number again; of times the unit is "iso8601"'
            raise self._fault(FaultCode.NUMBER_INVALID, row, column, name, reason, mend)
        text = cell.strip()
        if gaps and is_gap(text):
            return float("nan")
        if not text:
            raise self._fault(FaultCode.CELL_EMPTY, row, column, name, "the cell is empty", "fill it in")
        found = number(text, layout.decimal, layout.thousands)
        if found is None:
            reason = f"{text!r} is not a number"
            raise self._fault(FaultCode.NUMBER_INVALID, row, column, name, reason, "correct the cell")
        return found

    def _fault(self, code: FaultCode, row: int, column: int, name: str, reason: str, mend: str) -> InputError:
        place = f"{self.place}, cell {cell_name(row, column)}, column {name}"
        return InputError.at(code, self.display_name, place, reason, mend)


def text_of_cell(cell: Cell) -> str:
    """Return what a cell holds as text: numbers as Python writes them, whole ones without a point, moments ISO 8601.

    Examples
    --------
    >>> text_of_cell(3.0), text_of_cell(0.1), text_of_cell(timedelta(minutes=1.5)), text_of_cell(" Fx ")
    ('3', '0.1', '90', 'Fx')
    """
    if isinstance(cell, str):
        return cell.strip()
    if isinstance(cell, bool):
        return str(cell).upper()
    if isinstance(cell, time | timedelta):
        cell = seconds_of_day(cell)
    if isinstance(cell, date):
        return cell.isoformat()
    return str(int(cell)) if float(cell).is_integer() and abs(cell) < 1e15 else repr(float(cell))


def seconds_of_day(cell: time | timedelta) -> float:
    """Return a time of day, or a duration, in s."""
    if isinstance(cell, timedelta):
        return cell.total_seconds()
    return cell.hour * 3600.0 + cell.minute * 60.0 + cell.second + 1e-6 * cell.microsecond

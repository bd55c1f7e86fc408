"""Rows whose values come by name, one row after the other: their columns, and batches of the wanted ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import TypeAlias

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import COLUMNS
from stiffcal.log_columns import Batch, WantedColumns, first_not_finite
from stiffcal.measurements.timestamps import seconds_of_times
from stiffcal.parsers.open_log import OpenLog
from stiffcal.table_layout.cells import is_gap, number

Value: TypeAlias = str | float | bool | None
ROWS_FOR_NAMES = 1000
"""So many rows are looked at for the names of columns."""


@dataclass(frozen=True)
class NamedRow:
    """A row, and where in its file it stands."""

    place: str
    values: Mapping[str, Value]


class OpenRows(OpenLog):
    """A log of rows that name their values themselves."""

    def __init__(
        self, rows: Callable[[], Iterable[NamedRow]], unit_of: Callable[[str], str], display_name: str, place: str
    ) -> None:
        names: dict[str, None] = {}
        for row in islice(rows(), ROWS_FOR_NAMES):
            names.update(dict.fromkeys(row.values))
            COLUMNS.check(len(names), display_name, row.place)
        self.columns = tuple(names)
        self.units = {name: unit for name in names if (unit := unit_of(name))}
        self.n_rows = None
        self.display_name, self.place = display_name, place
        self._rows = rows
        if not names:
            raise InputError.at(FaultCode.FILE_EMPTY, display_name, "", "no rows", "log again, or leave the file out")

    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            For a damaged or cut off file, a row without one of the values, or with one of another kind.
        """
        rows, start = iter(self._rows()), 0
        while held := list(islice(rows, self.BATCH_ROWS)):
            yield self._batch(held, start, wanted)
            start += len(held)

    def _batch(self, rows: list[NamedRow], start: int, wanted: WantedColumns) -> Batch:
        numbers: dict[str, Floats] = {}
        texts: dict[str, list[str]] = {}
        for name in wanted.names:
            if name in wanted.numbers:
                numbers[name] = self._numbers(rows, name, wanted)
                continue
            words = [self._word(row, name) for row in rows]
            if name in wanted.times:
                numbers[name] = seconds_of_times(words, self.display_name, name, start + 1)
            else:
                texts[name] = words
        bad = first_not_finite(numbers, wanted, 0)
        if bad is not None:
            mend = "give the reading, or leave the row out with [[exclude]]"
            raise self._fault(FaultCode.NUMBER_INVALID, rows[bad[0]], bad[1], f"{bad[2]} is not a finite number", mend)
        return Batch(start + 1, numbers, texts)

    def _numbers(self, rows: list[NamedRow], name: str, wanted: WantedColumns) -> Floats:
        """Return a column's numbers, of one in which anything may stand infinite ones for what is none."""
        values = np.full(len(rows), np.inf)
        for k, row in enumerate(rows):
            try:
                values[k] = self._number(row, name, name in wanted.gaps)
            except InputError:
                if name not in wanted.unjudged:
                    raise
        return values

    def _number(self, row: NamedRow, name: str, gaps: bool) -> float:
        value = row.values.get(name)
        if isinstance(value, float | int) and not isinstance(value, bool):
            return float(value)
        if gaps and (value is None or (isinstance(value, str) and is_gap(value.strip()))):
            return float("nan")
        if value is None or value == "":
            raise self._fault(FaultCode.CELL_EMPTY, row, name, "the value is missing", "log it in every row")
        found = number(value.strip(), ".", "") if isinstance(value, str) else None
        if found is None:
            raise self._fault(FaultCode.NUMBER_INVALID, row, name, f"{value!r} is not a number", "correct the value")
        return found

    def _word(self, row: NamedRow, name: str) -> str:
        value = row.values.get(name)
        if value is None or value == "":
            raise self._fault(FaultCode.CELL_EMPTY, row, name, "the value is missing", "log it in every row")
        if isinstance(value, float) and not isinstance(value, bool) and value.is_integer():
            return str(int(value))
        return str(value).strip()

    def _fault(self, code: FaultCode, row: NamedRow, name: str, reason: str, mend: str) -> InputError:
        return InputError.at(code, self.display_name, f"{row.place}, column {name}", reason, mend)

"""An open log of columns that are read one by one, each under its own name: arrays, channels, variables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from stiffcal.log_columns import Batch, WantedColumns, batch_of_columns, check_columns, common_length
from stiffcal.parsers.open_log import OpenLog


@dataclass(frozen=True)
class NamedColumn:
    """A column: how many rows it has, and how to read some of them."""

    n_rows: int
    read: Callable[[int, int], NDArray[Any]]
    """``read(start, end)`` of rows `start` to before `end`, from 0."""
    unit: str = ""
    """As the log states it."""


class OpenColumns(OpenLog):
    """An open log of named columns."""

    def __init__(self, columns: Mapping[str, NamedColumn], display_name: str, place: str, elsewhere: str = "") -> None:
        """Take the columns by name; `elsewhere` says where one that is not there may be."""
        lengths = {column.n_rows for column in columns.values()}
        self.columns = tuple(columns)
        self.units = {name: column.unit for name, column in columns.items() if column.unit}
        self.uneven = len(lengths) > 1
        self.n_rows = lengths.pop() if len(lengths) == 1 else None
        self.display_name, self.place = display_name, place
        self._columns, self._elsewhere = columns, elsewhere

    def check(self, wanted: WantedColumns) -> None:
        """Raise an `InputError` for each wanted column that is not there."""
        check_columns(wanted, self.columns, self.display_name, self.place, self._elsewhere)

    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            For a damaged or cut off file, columns of unequal length, a column of another kind, a number that is not
            finite.
        """
        lengths = {name: self._columns[name].n_rows for name in wanted.names}
        n_rows = common_length(lengths, wanted, self.display_name)

        def read(name: str, start: int, end: int) -> NDArray[Any]:
            return self._columns[name].read(start, end)

        for start in range(0, n_rows, self.BATCH_ROWS):
            yield batch_of_columns(read, wanted, start, min(start + self.BATCH_ROWS, n_rows), self.display_name)

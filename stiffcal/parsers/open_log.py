"""What a parser of a log format gives: an open log, whose rows are read in batches."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import ClassVar, TypeAlias

from stiffcal.log_columns import Batch, Options, WantedColumns, check_columns


class OpenLog(ABC):
    """A log that is open for reading.

    Attributes
    ----------
    columns : the names of all columns, in order.
    units : column to unit, where the log states one.
    n_rows : number of rows, None where it does not state it.
    display_name : the log as messages name it. place : where in it the columns are.
    unpacked : bytes that reading it has unpacked so far or will, where its parser counts them.
    """

    columns: tuple[str, ...]
    units: dict[str, str]
    n_rows: int | None
    display_name: str
    place: str
    unpacked: int = 0

    BATCH_ROWS: ClassVar[int] = 1 << 16
    """Rows of a batch, at most."""

    def check(self, wanted: WantedColumns) -> None:
        """Raise an `InputError` for each wanted column that is not there."""
        check_columns(wanted, self.columns, self.display_name, self.place)

    @abstractmethod
    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield the rows of columns that are there, in order. Raises an `InputError` at the first fault."""


Parser: TypeAlias = Callable[[Path, Options, str], AbstractContextManager[OpenLog]]
"""``open_log(path, options, display_name)`` of a format's module; `options` have been checked."""

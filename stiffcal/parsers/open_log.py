"""What a parser of a log format gives: an open log, whose rows are read in batches."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

from stiffcal.errors import InputError
from stiffcal.log_columns import Batch, Options, WantedColumns, check_columns
from stiffcal.parsers.messages import LogHeader

FIRST_ROWS = 5000
"""So many rows show a column's kind, and its unit by their size."""


class OpenLog(ABC):
    """A log that is open for reading.

    Attributes
    ----------
    columns : the names of all columns, in order.
    units : column to unit, where the log states one.
    n_rows : number of rows, None where it does not state it.
    display_name : the log as messages name it. place : where in it the columns are.
    options : as understood, found ones included: the sheet that was chosen.
    remarks : what a person should know of the log, in words: rows that a spreadsheet hides.
    uneven : whether its columns are known to be of different lengths.
    unpacked : bytes that reading it has unpacked so far or will, where its parser counts them.
    """

    columns: tuple[str, ...]
    units: dict[str, str]
    n_rows: int | None
    display_name: str
    place: str
    unpacked: int = 0
    options: Mapping[str, object] = MappingProxyType({})
    remarks: tuple[str, ...] = ()
    uneven: bool = False

    BATCH_ROWS: int = 1 << 16
    """Rows of a batch, at most."""

    def header(self) -> LogHeader:
        """Return what it states of itself."""
        return LogHeader(self.columns, self.units, self.n_rows, dict(self.options), self.remarks, self.uneven)

    def check(self, wanted: WantedColumns) -> None:
        """Raise an `InputError` for each wanted column that is not there."""
        check_columns(wanted, self.columns, self.display_name, self.place)

    def first_rows(self, names: Sequence[str]) -> Iterator[Batch]:
        """Yield the first rows of columns of unknown kind: as numbers with gaps where they are, else as words.

        A column that is neither, and what cannot be read at all, is left out.
        """
        self.BATCH_ROWS = FIRST_ROWS
        together = self._first_rows(WantedColumns(tuple(names), gaps=frozenset(names)))
        if together is not None:
            yield together
            return
        for name in names:
            gaps = frozenset((name,))
            found = self._first_rows(WantedColumns((name,), gaps=gaps)) or self._first_rows(WantedColumns((), (name,)))
            if found is not None:
                yield found

    def _first_rows(self, wanted: WantedColumns) -> Batch | None:
        try:
            self.check(wanted)
            return next(iter(self.batches(wanted)), None)
        except InputError:
            return None

    @abstractmethod
    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield the rows of columns that are there, in order. Raises an `InputError` at the first fault."""


Parser: TypeAlias = Callable[[Path, Options, str], AbstractContextManager[OpenLog]]
"""``open_log(path, options, display_name)`` of a format's module; `options` have been checked."""

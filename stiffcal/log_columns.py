"""Columns of a log: which are wanted, rows of them in batches, and the checks that readers of all formats share."""

from __future__ import annotations

import difflib
import errno
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.errors import Fault, InputError
from stiffcal.extras import install_command
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_regular
from stiffcal.measurements.timestamps import seconds_of_times, seconds_of_timestamps

Options: TypeAlias = Mapping[str, object]
"""The manifest's options of a format: the table ``csv = {…}``, ``hdf5 = {…}`` of a source."""


def single_character(options: Options, key: str, file: str) -> str | None:
    """Return the character that an option of text logs gives, a tab for "tab"; None where it is not given.

    Parameters
    ----------
    options : of the manifest's ``csv``. key : "delimiter" or "decimal".
    file : how to call the file in a fault.

    Raises
    ------
    InputError : it is not one character that can stand between cells or digits.

    Examples
    --------
    >>> single_character({"delimiter": "tab"}, "delimiter", "log.csv") == chr(9)
    True
    >>> single_character({"delimiter": ";"}, "delimiter", "log.csv"), single_character({}, "decimal", "log.csv")
    (';', None)
    """
    value = options.get(key)
    if value is None:
        return None
    text = "\t" if value in ("tab", "\\t") else str(value)
    if len(text) != 1 or not text.isascii() or text in '"\n\r' or text.isalnum():
        reason = f"{value!r} is not a valid single character"
        raise InputError.at(FaultCode.OPTION_INVALID, file, f"csv.{key}", reason, "correct it")
    return text


@dataclass(frozen=True)
class WantedColumns:
    """The columns that are to be read."""

    numbers: tuple[str, ...]
    """Columns of numbers; every cell must be a finite number."""
    texts: tuple[str, ...] = ()
    """Columns of words, such as a run's name."""
    times: tuple[str, ...] = ()
    """Columns of ISO 8601 times; they come back among the numbers, as seconds since 1970-01-01 UTC."""
    gaps: frozenset[str] = frozenset()
    """Those of `numbers` in which an empty cell or NaN is a missing reading (a marker out of sight), given as NaN, and
    those of `texts` in which a cell may be empty."""
    unjudged: frozenset[str] = frozenset()
    """Those of `gaps` whose rows the caller may leave out: a word in place of a number is given as infinite."""
    date_order: str = ""
    """The order of day and month in `times`, as `seconds_of_times` takes it."""

    @property
    def names(self) -> tuple[str, ...]:
        """All names, each once, in the order in which they were requested."""
        return tuple(dict.fromkeys((*self.numbers, *self.times, *self.texts)))


@dataclass(frozen=True)
class Batch:
    """Consecutive data rows of a log."""

    first_row: int
    """The first row's number in the log, from 1; header lines are not counted."""
    numbers: dict[str, Floats]
    """Column name to (n,) array in the log's own units; ISO times are seconds since 1970-01-01 UTC."""
    texts: dict[str, list[str]] = field(default_factory=dict)
    """Column name to the n words."""

    def __len__(self) -> int:
        for values in self.numbers.values():
            return len(values)
        for column in self.texts.values():
            return len(column)
        return 0


def check_columns(wanted: WantedColumns, columns: Sequence[str], display_name: str, place: str, hint: str = "") -> None:
    """Raise `InputError` naming every wanted column that is missing or not unique, with the nearest name there is."""
    faults, missing = [], []
    for name in wanted.names:
        count = sum(column == name for column in columns)
        if count > 1:
            reason = f"the column name {name!r} occurs {count} times"
            faults.append(
                Fault(FaultCode.COLUMN_DUPLICATE, display_name, place, reason, "give every column a name of its own")
            )
        elif count == 0:
            missing.append(name)
    if hint and len(missing) > 1:  # one cause, one line
        further = f"{len(missing) - 1} other" + ("s" if len(missing) > 2 else "")
        faults.append(
            Fault(FaultCode.COLUMN_MISSING, display_name, place, f"no column {missing[0]!r} nor {further}", hint)
        )
    else:
        faults += [
            Fault(
                FaultCode.COLUMN_MISSING,
                display_name,
                place,
                f"no column {name!r}",
                hint or nearest_name(name, columns),
            )
            for name in missing
        ]
    if faults:
        raise InputError(*faults)


_C1 = re.compile("[\x80-\x9f]")
_CP1252 = 'the names look like Windows text read as latin-1: set csv = { encoding = "cp1252" }'


def nearest_name(name: str, columns: Sequence[str], having: str = "the file has") -> str:
    """Return a mend for a missing column: the nearest name, or the names there are.

    Parameters
    ----------
    name, columns : what is missing, and what there is.
    having : words before the list of names.

    Examples
    --------
    >>> nearest_name("Fx", ["Time", "fx", "Fy"])
    "did you mean 'fx'?"
    """
    folded = {column.casefold(): column for column in columns}
    bare = {column.split("[")[0].split("(")[0].strip(" #\ufeff").casefold(): column for column in columns}
    names = folded.get(name.casefold()) or bare.get(name.casefold())
    if names is None:
        close = difflib.get_close_matches(name.casefold(), list(folded), n=1, cutoff=0.6)
        names = folded[close[0]] if close else None
    if names is not None:
        return f"did you mean {names!r}?" + (f" if so, {_CP1252}" if _C1.search(names) else "")
    if any(_C1.search(column) for column in columns):
        return _CP1252
    listed = ", ".join(repr(column) for column in columns[:12]) + (", …" if len(columns) > 12 else "")
    return f"{having} {listed}" if columns else f"{having} no columns"


def first_not_finite(
    numbers: Mapping[str, Floats], wanted: WantedColumns, first_row: int
) -> tuple[int, str, float] | None:
    """Return (row, column, value) of the first cell that is not a finite number, or None.

    Cells of the columns in ``wanted.gaps`` may be NaN, never infinite.
    """
    worst: tuple[int, str, float] | None = None
    for name, values in numbers.items():
        # A sum is finite where every term is (short of an overflow, which the full look below sorts out).
        with np.errstate(all="ignore"):
            if np.isfinite(values.sum()):
                continue
        if name in wanted.unjudged:
            continue
        bad = np.isinf(values) if name in wanted.gaps else ~np.isfinite(values)
        if bad.any():
            at = int(bad.argmax())
            if worst is None or first_row + at < worst[0]:
                worst = (first_row + at, name, float(values[at]))
    return worst


def missing_library(log_format_name: str, display_name: str, extra: str = "") -> InputError:
    """Return what to install where the library behind a format is missing; `extra`: where not named like the format."""
    reason = f"the library that reads {log_format_name} files is not installed"
    return InputError.at(FaultCode.LIBRARY_MISSING, display_name, "", reason, install_command(extra or log_format_name))


def check_there(path: Path, display_name: str) -> None:
    """Raise `InputError` where there is no such file, or no regular one."""
    try:
        check_regular(path, display_name)
    except OSError as error:
        if not isinstance(error, FileNotFoundError | NotADirectoryError):
            reason = f"cannot be read: {error.strerror}"
            raise InputError.at(
                FaultCode.FILE_UNREADABLE, display_name, "", reason, "correct the name of the file or its permissions"
            ) from None
    if not path.is_file():
        raise InputError.at(FaultCode.FILE_MISSING, display_name, "", "no such file", "correct the name of the file")


# How Python shows an object that has no words of its own: its address means nothing to anybody.
_NO_MEMORY = 7  # SQLITE_NOMEM, as the libraries of Python and of bags state it
_OBJECT = re.compile(r":? ?<[^<>]* at 0x[0-9a-fA-F]+>")


@contextmanager
def damaged_file_errors(
    kind: str, display_name: str, mend: str = "copy it again from its origin, or log again"
) -> Iterator[None]:
    """Turn a library's messages on a damaged file into one line, in errors of every kind but want of memory or space.

    Parameters
    ----------
    kind : what the file should be, e.g. "TDMS file".
    mend : what to do.
    """
    try:
        yield
    except (
        InputError,
        MemoryError,
        SystemError,
    ):  # SystemError: a library that was given no memory, and names no error
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.errno in (errno.EFBIG, errno.ENOSPC, errno.EDQUOT):
            raise
        if _NO_MEMORY in (getattr(error, "sqlite_errorcode", 0), getattr(error, "result", 0)):
            raise MemoryError from None
        words_of_library = _OBJECT.sub("", str(error))
        message = (words_of_library.strip("'").splitlines() or [type(error).__name__])[0]
        raise InputError.at(FaultCode.FILE_DAMAGED, display_name, "", f"no whole {kind} ({message})", mend) from None


def common_length(lengths: Mapping[str, int], wanted: WantedColumns, display_name: str) -> int:
    """Return the number of rows of the wanted columns; raises `InputError` where they differ or there are none."""
    chosen = {name: lengths[name] for name in wanted.names}
    if len(set(chosen.values())) > 1:
        short, long = min(chosen, key=chosen.__getitem__), max(chosen, key=chosen.__getitem__)
        reason = f"{chosen[short]} rows, column {long} has {chosen[long]}: writing was interrupted"
        raise InputError.at(
            FaultCode.FILE_INCOMPLETE,
            display_name,
            f"column {short}",
            reason,
            "log again, or cut all columns to one length in a copy",
        )
    n_rows = next(iter(chosen.values()), 0)
    if n_rows == 0:
        raise InputError.at(
            FaultCode.FILE_EMPTY, display_name, "", "the columns have no rows", "log again, or leave the file out"
        )
    return n_rows


_KINDS = {
    "U": "text",
    "S": "text",
    "O": "text",
    "M": "times",
    "m": "spans of time",
    "b": "truth values",
    "f": "numbers",
}
"""Kinds of numpy's types in words; "O" is how texts of any length come."""


def batch_of_columns(
    read: Callable[[str, int, int], NDArray[Any]], wanted: WantedColumns, start: int, end: int, display_name: str
) -> Batch:
    """Return rows `start` to before `end` (from 0); ``read(name, start, end)`` gives numbers, words or times.

    Raises
    ------
    InputError
        For a column of another kind, an empty cell, a number that is not finite.
    """
    first_row = start + 1
    numbers: dict[str, Floats] = {}
    texts: dict[str, list[str]] = {}
    for name in wanted.names:
        values = read(name, start, end)
        kind = values.dtype.kind
        if name in wanted.numbers:
            if kind not in "iuf":
                reason = f"it holds {_KINDS.get(kind, str(values.dtype))}, not numbers"
                raise InputError.at(
                    FaultCode.COLUMN_TYPE, display_name, f"column {name}", reason, "use a column of numbers"
                )
            numbers[name] = values.astype(np.float64, copy=False)
            continue
        if kind == "M" and name in wanted.times:
            numbers[name] = seconds_of_timestamps(values)
            continue
        if kind not in "SUOiu":
            reason = f"it holds {_KINDS.get(kind, str(values.dtype))}, not words"
            raise InputError.at(FaultCode.COLUMN_TYPE, display_name, f"column {name}", reason, "use a column of words")
        cells = [text_of(value).strip("\0 ") for value in values.tolist()]
        if "" in cells and name not in wanted.gaps:
            place = f"row {first_row + cells.index('')}, column {name}"
            raise InputError.at(
                FaultCode.CELL_EMPTY, display_name, place, "the cell is empty", "fill it in, in a copy of the file"
            )
        if name in wanted.times:
            numbers[name] = seconds_of_times(cells, display_name, name, first_row, wanted.date_order)
        else:
            texts[name] = cells
    bad = first_not_finite(numbers, wanted, first_row)
    if bad is not None:
        mend = "give the reading, or leave the row out with [[exclude]]"
        place = f"row {bad[0]}, column {bad[1]}"
        raise InputError.at(FaultCode.NUMBER_INVALID, display_name, place, f"{bad[2]} is not a finite number", mend)
    return Batch(first_row, numbers, texts)


def text_of(value: object) -> str:
    """Return a word, whether it was stored as bytes or as text."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)

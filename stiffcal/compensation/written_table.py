"""A table of loads, poses or paths as somebody wrote it: its columns read in SI, what is impossible refused."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from os import SEEK_END
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import cast

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.campaign.found.file_formats import log_format
from stiffcal.campaign.toml.reach import check_given, open_given, read_given
from stiffcal.campaign.toml.toml_reading import LARGEST
from stiffcal.compensation.table_columns import (
    FORCES,
    POSITION,
    ReadColumn,
    columns_of,
)
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import is_given
from stiffcal.limits import TABLE
from stiffcal.log_columns import WantedColumns
from stiffcal.propose.other_tables import TEXT, reader_of
from stiffcal.readers import Header, Reader
from stiffcal.reduction.logs.reading_bounds import first_impossible
from stiffcal.table_layout.layout import NAMELESS
from stiffcal.table_layout.text import FIRST_BYTES, encoding_of
from stiffcal.wording import unused_columns

_CELL = (FaultCode.NUMBER_INVALID, "correct the cell")
_AS_OF_A_TABLE: Mapping[FaultCode, tuple[FaultCode, str]] = {
    FaultCode.FILE_EMPTY: (FaultCode.FILE_EMPTY, "write a header and at least one row"),
    FaultCode.FILE_INCOMPLETE: _CELL,
    FaultCode.CELL_EMPTY: _CELL,
    FaultCode.NUMBER_INVALID: _CELL,
    FaultCode.COLUMN_TYPE: _CELL,
    FaultCode.SHAPE_MISMATCH: (FaultCode.SHAPE_MISMATCH, "complete the line: as many cells as names, decimal points"),
    FaultCode.SYNTAX_INVALID: (FaultCode.SYNTAX_INVALID, "write one number per cell, and close every quotation mark"),
    FaultCode.ENCODING_WRONG: (FaultCode.FILE_UNREADABLE, "give a CSV file in UTF-8"),
    FaultCode.FORMAT_UNKNOWN: (FaultCode.FORMAT_UNKNOWN, "give a CSV file, or name the file as its format is"),
    FaultCode.READING_IMPLAUSIBLE: (
        FaultCode.READING_IMPLAUSIBLE, "correct it, or write its unit after the name: \"A1 [rad]\", \"Fx [kN]\"",
    ),
}  # fmt: skip
"""What is said of a reader's fault in a table: its code, and what to do."""
_KINDS = dict.fromkeys(FORCES, "wrench") | dict.fromkeys(POSITION, "position")
"""Columns whose readings have bounds, as signals of logs."""
DATA_ROW = "data row"
"""What is counted in files without lines: rows below the names, in sheets without the blank ones."""


@dataclass(frozen=True)
class WrittenTable:
    """Any such table, SI."""

    file: str
    """As it is called in messages."""
    numbers: Mapping[str, Floats]
    """Column name, as `table_columns` has it, to (n,)."""
    words: Mapping[str, tuple[str, ...]]
    """Column name to n words."""
    lines: NDArray[np.int64]
    """(n,) line of each row in the file, or its number among the rows of data."""
    stated: frozenset[str] = frozenset()
    """Columns whose unit stands in the table."""
    unused: tuple[str, ...] = ()
    """Headers of the columns that were not read."""
    remarks: tuple[str, ...] = ()
    """What a person should know of the file, in words: rows that a spreadsheet hides."""
    line_word: str = "line"
    """What `lines` counts."""

    def __len__(self) -> int:
        return len(self.lines)

    def place(self, row: int) -> str:
        """Return where a row (from 0) stands in the file."""
        return f"{self.line_word} {self.lines[row]}"

    def has(self, names: Iterable[str]) -> bool:
        """Return whether all these columns of numbers stand in the table."""
        return all(name in self.numbers for name in names)

    def block(self, names: Sequence[str]) -> Floats:
        """Return (n, k) columns side by side; zero where there is none of that name."""
        zero = np.zeros(len(self))
        return np.stack([self.numbers.get(name, zero) for name in names], axis=1)

    @property
    def unused_words(self) -> list[str]:
        """Sentences on what a spreadsheet hides, and on the columns that were not read; none where all were."""
        return [f"{self.file}: {words}" for words in (*self.remarks, *unused_columns(self.unused))]


def read_table(
    file: Path,
    joint_names: Sequence[str],
    asked: Sequence[str],
    words: Sequence[str] = (),
    prismatic: Collection[str] = (),
) -> WrittenTable:
    """Read a table of named columns; the names of those that are not asked for are kept.

    Parameters
    ----------
    file : the table, as text however it is written, or in any other format of logs.
    joint_names : the L joints of the robot, whose columns are in degrees where no unit is stated.
    asked : names of columns of numbers: joints, and names of `table_columns`.
    words : names of columns of words. prismatic : as of `read_load_table`.

    Raises
    ------
    InputError : the file is missing, a column or a cell is wrong.
    """
    display_name = str(file)
    if not is_given(file):
        reason = "a folder, no file" if file.is_dir() else "no such file"
        raise InputError.at(FaultCode.FILE_MISSING, display_name, "", reason, "correct the path")
    check_given(file)
    with _at_rest(file) as kept, _faults_of_a_table():
        return _read(
            reader_of(kept) or cast(Reader, log_format(TEXT)), kept, display_name, joint_names, asked, words, prismatic
        )


@contextmanager
def _at_rest(file: Path) -> Iterator[Path]:
    """Hand out a file that can be read twice, and text whose last line ends, as a person need not end it.

    What comes through a pipe (``--poses <(zcat …)``) is written down first.
    """
    reader = reader_of(file) if file.is_file() else None
    if reader is None and file.is_file():
        TABLE.check(file.stat().st_size, str(file))
    if reader is not None or (file.is_file() and not _lacks_line_end(file)):
        yield file
        return
    with TemporaryDirectory(prefix="stiffcal-table-") as place:
        kept = Path(place) / "table.csv"
        content = read_given(file, TABLE)
        kept.write_bytes(content if content[-2:].count(b"\n") else content + b"\n")
        yield kept


def _lacks_line_end(file: Path) -> bool:
    with open_given(file) as stream:
        if encoding_of(stream.read(FIRST_BYTES)).startswith(("utf-16", "utf-32")):
            return False
        stream.seek(-min(2, stream.seek(0, SEEK_END)), SEEK_END)
        return b"\n" not in stream.read()


@contextmanager
def _faults_of_a_table() -> Iterator[None]:
    """Turn the readers' faults into those of a table that no manifest describes: nothing can be set for it."""
    try:
        yield
    except InputError as error:
        faults = []
        for fault in error.faults:
            code, mend = _AS_OF_A_TABLE.get(fault.code, (fault.code, fault.mend))
            faults.append(replace(fault, code=code, mend=mend))
        raise InputError(*faults) from None


def _read(
    reader: Reader,
    file: Path,
    display_name: str,
    joint_names: Sequence[str],
    asked: Sequence[str],
    words: Sequence[str],
    prismatic: Collection[str],
) -> WrittenTable:
    header = reader.read_header(file, {}, display_name)
    if all(name == f"{NAMELESS}{number}" for number, name in enumerate(header.columns, start=1)):
        reason = "no names stand above the numbers, or not as many as there are cells below"
        mend = "write a line of names; where the comma is the decimal mark, another sign has to stand between the cells"
        raise InputError.at(FaultCode.HEADER_MISSING, display_name, _header_place(reader, header), reason, mend)
    units = [header.units.get(name, "") for name in header.columns]
    columns = columns_of(
        header.columns, units, joint_names, (*asked, *words), display_name, _header_place(reader, header), prismatic
    )
    in_file = {column.name: column for column in columns if column.name is not None}
    of_numbers = {name: column for name, column in in_file.items() if name in asked}
    of_words = {name: column for name, column in in_file.items() if name in words}
    wanted = WantedColumns(
        tuple(column.header for column in of_numbers.values()), tuple(column.header for column in of_words.values())
    )
    parts = list(reader.read_batches(file, {}, wanted, display_name)) if in_file else []
    count = sum(map(len, parts))
    lines = reader.row_lines(file, {})
    word = "line" if lines is not None else DATA_ROW
    at = np.arange(1, count + 1) if lines is None else lines[:count]
    numbers = {}
    for name, column in of_numbers.items():
        values = np.concatenate([part.numbers[column.header] for part in parts])
        if np.any(large := np.abs(values) > LARGEST):
            row = int(np.argmax(large))
            raise _too_large(values[row], display_name, f"{word} {at[row]}, column {column.header}")
        numbers[name] = column.factor * values
        _check_possible(name, column.header, numbers[name], joint_names, prismatic, display_name, word, at)
    texts = {name: [cell for part in parts for cell in part.texts[column.header]] for name, column in of_words.items()}
    # a delimiter at the end of every line makes a column without a name and without a cell
    nameless = reader.first_rows(file, {}, [""], display_name) if "" in header.columns else {}
    held = [column for column in columns if column.header or any(map(_is_filled, nameless.get("", ())))]
    table = _written(display_name, numbers, texts, at, held)
    return replace(table, remarks=header.remarks, line_word=word)


def _header_place(reader: Reader, header: Header) -> str:
    """Return where the names of the columns stand in a file."""
    if "skip_rows" in header.options:
        return f"line {int(str(header.options['skip_rows'])) + 1}"
    return f"{reader.name} {header.options['sheet']}" if "sheet" in header.options else "columns"


def _is_filled(cell: float | str) -> bool:
    return bool(cell) if isinstance(cell, str) else not np.isnan(cell)


def _check_possible(
    name: str,
    header: str,
    values: Floats,
    joint_names: Sequence[str],
    prismatic: Collection[str],
    display_name: str,
    word: str,
    at: NDArray[np.int64],
) -> None:
    """Raise for a reading (n,), SI, that no robot or instrument gives, as in logs."""
    kind = "joints" if name in joint_names else _KINDS.get(name)
    if kind is None or not values.size:
        return
    row = values[None]
    slides = [header] if name in prismatic else []
    found = first_impossible(kind, row, row.min(axis=1), row.max(axis=1), (header,), slides)
    if found is not None:
        place = f"{word} {at[found.row]}, column {header}"
        raise InputError.at(FaultCode.READING_IMPLAUSIBLE, display_name, place, found.reason, found.mend)


def _written(
    display_name: str,
    numbers: Mapping[str, Floats],
    texts: Mapping[str, Sequence[str]],
    lines: NDArray[np.int64],
    columns: Iterable[ReadColumn],
) -> WrittenTable:
    stated = frozenset(column.name for column in columns if column.name is not None and column.stated)
    unused = tuple(column.header.strip() or "without a name" for column in columns if column.name is None)
    words = {name: tuple(cells) for name, cells in texts.items()}
    return WrittenTable(display_name, numbers, words, lines, stated, unused)


def _too_large(value: float, display_name: str, place: str) -> InputError:
    reason = f"{value:g} is larger than any plausible value"
    return InputError.at(FaultCode.NUMBER_INVALID, display_name, place, reason, "correct the cell")

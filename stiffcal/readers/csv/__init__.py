"""Comma separated logs, and all that goes by that name: any delimiter, decimal comma, encodings, header lines.

How a file is written is recognised by its first lines (`stiffcal.table_layout`), as `init` and `check` recognise it.
Options of the manifest (``csv = {…}``) state what these do not show:

delimiter : one character; " " stands for one blank or several.
decimal : "." or ",".
encoding : of the file.
skip_rows : lines before the line with the column names.
unit_row : True where the line after the names holds units.
section : where tables stand below each other, the line that names the one to be read (Vicon Nexus: "Trajectories").

Lines are parsed by pyarrow in blocks, single-threaded, with every wanted column's type given, so that memory stays flat
and no cell is guessed at. Faults are found again in a second, slow pass that tracks lines and columns.
"""

from __future__ import annotations

import io
import math
import time
import weakref
from collections.abc import Collection, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as arrow_csv

from stiffcal.arrays import Floats, Integers
from stiffcal.errors import InputError
from stiffcal.escapes import csv_cell
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import ROWS
from stiffcal.measurements.columns import values_of
from stiffcal.measurements.timestamps import seconds_of_times
from stiffcal.parsers.signatures import begins_like_json
from stiffcal.readers import Batch, FuzzInput, Header, Options, RawRows, Reader, WantedColumns, first_not_finite
from stiffcal.readers.csv.faults import check_last_line, find_fault
from stiffcal.readers.csv.layout import CsvOptions, open_log, section_titles
from stiffcal.readers.csv.lines import LogText
from stiffcal.table_layout.cells import GAP_WORDS, WRITTEN_OTHERWISE, is_gap, number
from stiffcal.table_layout.text import FIRST_BYTES, TextLayout, text_layout

# Large enough that the parser's cost per block vanishes, small enough for flat memory.
BLOCK = 1 << 22
_GAPS = sorted({spelled for word in GAP_WORDS for spelled in (word, word.upper(), word.title())} | {"NaN", "-NaN"})


def _write_fuzz_input(path: Path) -> None:
    rows = (f"{0.01 * k:.2f},{k - 30.5},pose{k // 20}" for k in range(60))
    path.write_text("\n".join(("t,Fx,run", *rows)) + "\n", encoding="utf-8")


class CsvReader(Reader):
    """Reads logs of text lines with one delimiter."""

    name = "csv"
    endings = (".csv", ".txt", ".tsv", ".dat", ".asc")
    packed_endings = (".gz", ".bz2", ".xz", ".zst")
    options = CsvOptions
    header_at_once = True
    fuzz_inputs = (FuzzInput(".csv", _write_fuzz_input, ("t", "Fx"), ("run",)),)

    def recognises(self, path: Path) -> bool:
        """Return True for the usual endings, also packed (gzip, bzip2, xz, zstd), and for text that holds a table."""
        endings = [suffix.lower() for suffix in path.suffixes if suffix.lower() not in self.packed_endings]
        return (bool(endings) and endings[-1] in self.endings) or _is_table(path)

    def tables(self, path: Path, display_name: str = "") -> tuple[Options, ...]:
        """Return the tables in a file: several where each stands below a line that names it."""
        titles = section_titles(path, {}, display_name or str(path))
        return tuple({"section": title} for title in titles) or ({},)

    def read_header(
        self, path: Path, options: Options, display_name: str = "", wanted: WantedColumns | None = None
    ) -> Header:
        """Return the columns and what was detected of the file.

        Raises
        ------
        InputError
            For a missing or repeated column of `wanted`, an empty file, a wrong encoding or an unknown option.
        """
        with open_log(path, options, display_name or str(path), wanted or WantedColumns(())) as (_, layout):
            understood: dict[str, object] = {
                "delimiter": layout.delimiter,
                "decimal": layout.rows.decimal,
                "encoding": layout.encoding,
                "skip_rows": (layout.header_line or layout.first_data_line) - 1,
                "unit_row": layout.rows.has_unit_row,
            }
            return Header(layout.columns, dict(layout.rows.units), None, understood)

    def read_batches(
        self, path: Path, options: Options, wanted: WantedColumns, display_name: str = ""
    ) -> Iterator[Batch]:
        """Yield the data rows in blocks of about 4 MB of text.

        Raises
        ------
        InputError
            With line and column, for a cell that is no finite number, a line with too few or too many cells, a file
            that ends in the middle of a line, a file without data.
        """
        display_name = display_name or str(path)
        n_rows = 0
        try:
            for batch in _read(path, options, wanted, display_name, frozenset()):
                n_rows += len(batch)
                yield batch
        except _WordError:  # in a row that the caller may leave out
            for batch in _read(path, options, wanted, display_name, wanted.unjudged):
                if batch.first_row + len(batch) - 1 > n_rows:
                    yield _from_row(batch, n_rows + 1)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``line n`` of data row `row` (from 1); reads the file up to there."""
        with open_log(path, options, str(path), WantedColumns(())) as (text, layout):
            number = next((number for own, number, _ in _data_lines(text, layout) if own == row), None)
        return f"data row {row}" if number is None else f"line {number}"

    def raw_rows(self, path: Path, options: Options, rows: Collection[int]) -> RawRows:
        """Return some data rows as they stand in the file; reads it up to the last of them."""
        wanted, found = set(rows), {}
        with open_log(path, options, str(path), WantedColumns(())) as (text, layout):
            for row, number, line in _data_lines(text, layout):
                if row in wanted:
                    found[row] = (number, line.decode("utf-8", "replace").rstrip("\r"))
                    if len(found) == len(wanted):
                        break
            return RawRows(tuple(layout.columns), found)

    def row_lines(self, path: Path, options: Options) -> Integers:
        """Return the line of each data row, (n,); reads the whole file."""
        with open_log(path, options, str(path), WantedColumns(())) as (text, layout):
            return np.fromiter((number for _, number, _ in _data_lines(text, layout)), dtype=np.int64)


def _data_lines(text: LogText, layout: TextLayout) -> Iterator[tuple[int, int, bytes]]:
    """Yield the number of each data row, from 1, that of its line, and the line."""
    row = 0
    for line in text.lines():
        if line or len(layout.columns) == 1:
            row += 1
            yield row, text.line_number, line


READER = CsvReader()


def _is_table(path: Path) -> bool:
    """Return whether a file is text with rows of numbers, whatever its name ends with."""
    if begins_like_json(path):  # numbers between commas
        return False
    try:
        with LogText(path, None, path.name) as text:
            content = text.peek(FIRST_BYTES)
            encoding = text.encoding if text.not_yet_decoded else "utf-8"
        layout = text_layout(content.decode(encoding), encoding)
    except (InputError, OSError, UnicodeDecodeError):
        return False
    return (
        b"\0" not in content
        and not content.lstrip().startswith(b"<")
        and layout.rows.holds_numbers
        and len(layout.columns) > 1
    )


class _WordError(Exception):
    """A cell that is no number, in a column whose rows the caller judges."""


def _read(
    path: Path, options: Options, wanted: WantedColumns, display_name: str, as_words: frozenset[str]
) -> Iterator[Batch]:
    """Yield the rows; `as_words` are columns of numbers in which a cell may hold anything.

    Raises
    ------
    InputError
        As `CsvReader.read_batches`.
    _WordError
        There is a fault, and columns whose rows the caller judges have not been read as words yet.
    """
    with open_log(path, options, display_name, wanted) as (text, layout):
        row = 0
        unusual = layout.rows.thousands or WRITTEN_OTHERWISE.search(text.peek(FIRST_BYTES))
        as_words |= frozenset(wanted.numbers if unusual else ())
        try:
            for records in _parse(text, layout, wanted, as_words):
                batch = _batch(records, layout, wanted, row + 1, display_name, as_words)
                row += len(batch)
                ROWS.check(row, display_name)
                yield batch
        except pa.ArrowInvalid as error:
            if not wanted.unjudged <= as_words:
                raise _WordError from None
            raise _located_fault(path, options, layout, wanted, row, display_name, str(error)) from None
        if row != text.n_lines:
            raise _located_fault(
                path, options, layout, wanted, 0, display_name, "a quoted cell extends over several lines"
            )
        if row == 0:
            place = f"line {layout.first_data_line}"
            raise InputError.at(
                FaultCode.FILE_EMPTY,
                display_name,
                place,
                "no data after the header",
                "log again, or leave the file out",
            )
        if text.suspect and (fault := find_fault(path, layout, wanted, 0, display_name)) is not None:
            raise fault
        check_last_line(text, layout, wanted, display_name)


def _from_row(batch: Batch, row: int) -> Batch:
    """Return the rows of a batch from a number on."""
    skip = max(0, row - batch.first_row)
    return Batch(
        batch.first_row + skip,
        {name: values[skip:] for name, values in batch.numbers.items()},
        {name: words[skip:] for name, words in batch.texts.items()},
    )


def _parse(
    text: LogText, layout: TextLayout, wanted: WantedColumns, as_words: frozenset[str]
) -> Iterator[pa.RecordBatch]:
    """Yield pyarrow's record batches of the wanted columns, named c0, c1, … by their place in the file."""
    names = [f"c{index}" for index in range(len(layout.columns))]
    numbers = set(wanted.numbers) - as_words
    types = {
        f"c{layout.columns.index(name)}": pa.float64() if name in numbers else pa.string() for name in wanted.names
    }
    source = _Source(text)
    released = weakref.ref(source)
    try:
        stream = arrow_csv.open_csv(
            pa.PythonFile(source, mode="r"),
            read_options=arrow_csv.ReadOptions(use_threads=False, block_size=BLOCK, column_names=names),
            parse_options=arrow_csv.ParseOptions(delimiter=layout.delimiter, ignore_empty_lines=False),
            convert_options=arrow_csv.ConvertOptions(
                column_types=types,
                include_columns=list(types),
                decimal_point=layout.rows.decimal,
                null_values=_GAPS if wanted.gaps else [],
                strings_can_be_null=False,
            ),
        )
    except pa.ArrowInvalid as error:
        del source
        text.abandon()
        _wait_for(released)
        if "Empty CSV" in str(error):
            return
        raise
    del source
    try:
        yield from stream
    finally:
        text.abandon()
        with suppress(pa.ArrowInvalid, InputError):
            for _ in stream:  # what was read ahead
                pass
        stream.close()
        del stream
        _wait_for(released)


class _Source(io.RawIOBase):
    """What the parser reads, in a thread of its own: it is released when that thread has ended."""

    def __init__(self, text: LogText) -> None:
        super().__init__()
        self._text = text

    def readable(self) -> bool:
        """Return True."""
        return True

    def read(self, size: int = -1) -> bytes:
        """Return bytes as `LogText.read` does."""
        return self._text.read(size)


# A thread of the parser that has not ended asks for the interpreter when that ends, and the process is aborted. It
# reads nothing more then: a longer wait would be for a thread that never ends.
_LONGEST_WAIT_S = 5.0


def _wait_for(released: weakref.ref[_Source]) -> None:
    """Return when the parser's thread has let go of what it reads."""
    until = time.monotonic() + _LONGEST_WAIT_S
    while released() is not None and time.monotonic() < until:
        time.sleep(1e-4)


def _batch(
    records: pa.RecordBatch,
    layout: TextLayout,
    wanted: WantedColumns,
    first_row: int,
    display_name: str,
    as_words: frozenset[str],
) -> Batch:
    """Return the records as arrays; raises `pa.ArrowInvalid` where a cell is not what it has to be."""
    numbers: dict[str, Floats] = {}
    texts: dict[str, list[str]] = {}
    for name in wanted.names:
        column = records.column(f"c{layout.columns.index(name)}")
        if name in as_words:
            numbers[name] = _numbers_of_words(column, layout, name, wanted)
            continue
        if name in wanted.numbers:
            if column.null_count and name not in wanted.gaps:
                raise pa.ArrowInvalid(f"an empty cell in column {name}")
            numbers[name] = values_of(column)
            continue
        words: list[str] = [word.as_py().strip() for word in column]
        if name not in wanted.gaps and not all(words):
            raise pa.ArrowInvalid(f"an empty cell in column {name}")
        if name in wanted.times:
            numbers[name] = seconds_of_times(words, display_name, name, first_row, wanted.date_order)
        else:
            texts[name] = [csv_cell.original(word) if word.startswith("'") else word for word in words]
    if (bad := first_not_finite(numbers, wanted, first_row)) is not None:
        raise pa.ArrowInvalid(f"row {bad[0]}, column {bad[1]}: {bad[2]} is not a finite number")
    return Batch(first_row, numbers, texts)


def _numbers_of_words(column: pa.Array, layout: TextLayout, name: str, wanted: WantedColumns) -> Floats:
    """Return cells as numbers, a gap as NaN; raises `pa.ArrowInvalid` for a word, unless rows are judged later."""
    decimal, thousands = layout.rows.decimal, layout.rows.thousands
    found = []
    for cell in column.to_pylist():
        bare = cell.strip(" \t")
        value = number(bare, decimal, thousands)
        if value is None:
            if is_gap(bare) and name in wanted.gaps:
                value = math.nan
            elif name in wanted.unjudged:
                value = math.inf
            else:
                raise pa.ArrowInvalid(f"column {name}: {bare!r} is not a number")
        found.append(value)
    return np.array(found)


def _located_fault(
    path: Path,
    options: Options,
    layout: TextLayout,
    wanted: WantedColumns,
    rows_read: int,
    display_name: str,
    reason: str,
) -> InputError:
    """Return the fault with its line; where the slow pass finds none, with the row up to which all was well."""
    titles = [] if layout.section else section_titles(path, options, display_name)
    if titles:
        listed = ", ".join(map(repr, titles))
        reason, mend = f"{len(titles)} tables stand below each other", f"state which: {listed}"
        return InputError.at(FaultCode.LOG_PART_AMBIGUOUS, display_name, "csv.section", reason, mend)
    fault = find_fault(path, layout, wanted, rows_read, display_name)
    return fault or InputError.at(
        FaultCode.SYNTAX_INVALID,
        display_name,
        f"after data row {rows_read}",
        reason,
        "correct the line in a copy of the file",
    )

"""Parquet tables, as pandas, polars, DuckDB or a logger write them. No options.

Numbers of any kind are read as float64; times may be timestamps or ISO 8601 words. A column inside a group goes by its
path, ``pose.x``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as parquet

from stiffcal.arrays import Floats
from stiffcal.campaign.typed import TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.limits import COLUMNS, ROWS, check_unpacked
from stiffcal.measurements.columns import values_of
from stiffcal.measurements.timestamps import seconds_of_times
from stiffcal.readers import (
    Batch,
    FuzzInput,
    Header,
    Options,
    Reader,
    WantedColumns,
    check_columns,
    check_options,
    check_there,
    first_not_finite,
)

BATCH_ROWS = 1 << 16
NANOSECONDS = {"s": 1_000_000_000, "ms": 1_000_000, "us": 1_000, "ns": 1}


class ParquetOptions(TomlTable):
    """Nothing to say yet: a Parquet file carries names and types itself."""


def _write_fuzz_input(path: Path) -> None:
    rows = range(60)
    columns = {"t": [k / 100 for k in rows], "Fx": [k - 30.5 for k in rows], "run": [f"pose{k // 20}" for k in rows]}
    parquet.write_table(pa.table(columns), path, row_group_size=20)


class ParquetReader(Reader):
    """Reads Parquet files in batches of rows."""

    name = "parquet"
    endings = (".parquet", ".pq")
    first_bytes = b"PAR1"
    options = ParquetOptions
    fuzz_inputs = (FuzzInput(".parquet", _write_fuzz_input, ("t", "Fx"), ("run",)),)

    def read_header(
        self, path: Path, options: Options, display_name: str = "", wanted: WantedColumns | None = None
    ) -> Header:
        """Return the columns; units where a column's metadata holds ``unit`` or ``units``."""
        display_name = display_name or str(path)
        with _open(path, options, display_name) as file:
            columns = _leaves(file)
            if wanted is not None:
                check_columns(wanted, columns, display_name, "schema")
            units = {}
            for column in file.schema_arrow:
                for key in (b"unit", b"units"):
                    if column.metadata and key in column.metadata:
                        units[column.name] = column.metadata[key].decode("utf-8", "replace")
            return Header(columns, units, file.metadata.num_rows)

    def read_batches(
        self, path: Path, options: Options, wanted: WantedColumns, display_name: str = ""
    ) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            For a damaged or cut off file, a missing column, a column that holds no numbers, an empty cell.
        """
        display_name = display_name or str(path)
        with _open(path, options, display_name, (*wanted.texts, *wanted.times)) as file:
            check_columns(wanted, _leaves(file), display_name, "schema")
            if file.metadata.num_rows == 0:
                raise InputError.at(
                    FaultCode.FILE_EMPTY, display_name, "", "the table has no rows", "log again, or leave the file out"
                )
            row = 1
            _check_sizes(file, wanted, path.stat().st_size, display_name)
            for records in file.iter_batches(BATCH_ROWS, columns=list(wanted.names), use_threads=False):
                batch = _batch(records, wanted, row, display_name)
                row += len(batch)
                ROWS.check(row - 1, display_name)
                yield batch
            if row - 1 != file.metadata.num_rows:
                reason = f"incomplete Parquet file ({row - 1} rows where its footer has {file.metadata.num_rows})"
                raise InputError.at(
                    FaultCode.FILE_DAMAGED, display_name, "", reason, "copy it again from its origin, or log again"
                )

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``row n``."""
        return f"row {row}"


READER = ParquetReader()


@contextmanager
def _open(path: Path, options: Options, display_name: str, words: Sequence[str] = ()) -> Iterator[parquet.ParquetFile]:
    # Words are read as the numbers of entries in a dictionary: one word of 100 MB can stand in each of a billion rows.
    check_options(options, ParquetOptions, "parquet", display_name)
    try:
        check_there(path, display_name)
        with open_regular(path, display_name) as opened:  # as a path pyarrow takes no name that is not UTF-8
            metadata = parquet.read_metadata(opened)
            COLUMNS.check(metadata.num_columns, display_name)
            dictionary_columns = [name for name in words if name in _leaves(metadata)]
            opened.seek(0)
            with parquet.ParquetFile(
                opened, metadata=metadata, page_checksum_verification=True, read_dictionary=dictionary_columns
            ) as file:
                yield file
    except FileNotFoundError:
        raise InputError.at(
            FaultCode.FILE_MISSING, display_name, "", "no such file", "correct the file's name"
        ) from None
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        reason = f"incomplete Parquet file ({str(error).splitlines()[0]})"
        raise InputError.at(
            FaultCode.FILE_DAMAGED, display_name, "", reason, "copy it again from its origin, or log again"
        ) from None


def _check_sizes(file: parquet.ParquetFile, wanted: WantedColumns, size: int, display_name: str) -> None:
    """Refuse a table whose columns take far more memory than the file has bytes: runs of one value are stored once.

    By the rows alone: in a damaged footer pyarrow ends the whole program where it is asked for a row group.
    """
    chosen = [index for index, name in enumerate(_leaves(file)) if name in wanted.names]
    for index in chosen:
        _check_kind(file, index, wanted, display_name)
    ROWS.check(file.metadata.num_rows, display_name)
    check_unpacked(8 * file.metadata.num_rows * len(chosen), size, display_name)


def _check_kind(file: parquet.ParquetFile, index: int, wanted: WantedColumns, display_name: str) -> None:
    """Refuse lists, and words where numbers are wanted, before the library takes memory for all of them."""
    column = file.schema.column(index)
    words = column.physical_type == "BYTE_ARRAY" and column.logical_type.type != "DECIMAL"
    if column.max_repetition_level > 0 or (words and column.path in wanted.numbers):
        top = file.schema_arrow.field(file.schema_arrow.names.index(column.path.split(".")[0])).type
        reason = f"it contains {top}, not {'words' if column.path in wanted.texts else 'numbers'}"
        raise InputError.at(
            FaultCode.COLUMN_TYPE, display_name, f"column {column.path}", reason, "use a column of single values"
        )


def _leaves(file: parquet.ParquetFile | parquet.FileMetaData) -> tuple[str, ...]:
    return tuple(file.schema.column(index).path for index in range(len(file.schema)))


def _batch(records: pa.RecordBatch, wanted: WantedColumns, first_row: int, display_name: str) -> Batch:
    numbers: dict[str, Floats] = {}
    texts: dict[str, list[str]] = {}
    for name in wanted.names:
        column = _column(records, name)
        if column.null_count and name not in wanted.gaps:
            row = first_row + next(index for index, value in enumerate(column) if not value.is_valid)
            mend = "give the value, or delete the row in a copy of the file"
            raise InputError.at(
                FaultCode.CELL_EMPTY, display_name, f"row {row}, column {name}", "the cell is empty", mend
            )
        if name in wanted.numbers:
            numbers[name] = _numbers(column, name, display_name)
        elif name in wanted.times:
            numbers[name] = _seconds(column, name, display_name, first_row)
        else:
            texts[name] = _text_cells(column, name, display_name)
    bad = first_not_finite(numbers, wanted, first_row)
    if bad is not None:
        mend = "give the reading, or leave the row out with [[exclude]]"
        raise InputError.at(
            FaultCode.NUMBER_INVALID,
            display_name,
            f"row {bad[0]}, column {bad[1]}",
            f"{bad[2]} is not a finite number",
            mend,
        )
    return Batch(first_row, numbers, texts)


def _column(records: pa.RecordBatch, name: str) -> pa.Array:
    if name in records.schema.names:
        return records.column(records.schema.names.index(name))
    group, *inner = name.split(".")
    column = records.column(group)
    for field in inner:
        # `flatten` hands the group's own empty rows down to its members.
        column = column.flatten()[column.type.get_field_index(field)]
    return column


def _numbers(column: pa.Array, name: str, display_name: str) -> Floats:
    kind = column.type
    if pa.types.is_dictionary(kind):
        column = column.dictionary_decode()
        kind = column.type
    if not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind)):
        raise InputError.at(
            FaultCode.COLUMN_TYPE,
            display_name,
            f"column {name}",
            f"it contains {kind}, not numbers",
            "use a column of numbers",
        )
    return values_of(column.cast(pa.float64(), safe=False))


def _seconds(column: pa.Array, name: str, display_name: str, first_row: int) -> Floats:
    if pa.types.is_timestamp(column.type):
        counts = values_of(column.cast(pa.int64()))
        return (counts / (1_000_000_000 / NANOSECONDS[column.type.unit])).astype("float64")
    return seconds_of_times(_text_cells(column, name, display_name), display_name, name, first_row)


def _text_cells(column: pa.Array, name: str, display_name: str) -> list[str]:
    """Return a column's cells as text without surrounding blanks; raise `InputError` where they are no text."""
    if pa.types.is_dictionary(column.type):
        entries = _text_cells(column.dictionary, name, display_name)  # each once, however often it stands in the table
        return [entries[index] for index in column.indices.to_pylist()]
    if not (pa.types.is_string(column.type) or pa.types.is_large_string(column.type)):
        # Run numbers are words as well.
        if not pa.types.is_integer(column.type):
            raise InputError.at(
                FaultCode.COLUMN_TYPE,
                display_name,
                f"column {name}",
                f"it contains {column.type}, not words",
                "use a column of words",
            )
        column = column.cast(pa.string())
    return [str(word.as_py()).strip() for word in column]

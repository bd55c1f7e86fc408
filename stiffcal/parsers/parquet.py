"""Parquet logs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import pyarrow as pa
import pyarrow.parquet as parquet

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.log_columns import Batch, Options, WantedColumns, damaged_file_errors, first_not_finite
from stiffcal.measurements.columns import values_of
from stiffcal.measurements.timestamps import seconds_of_times
from stiffcal.parsers.open_log import OpenLog

LIBRARIES = ("pyarrow.compute",)
"""Imported before the limits of a log hold; pyarrow does so where numbers are converted."""
NANOSECONDS = {"s": 1_000_000_000, "ms": 1_000_000, "us": 1_000, "ns": 1}


class OpenParquet(OpenLog):
    """An open Parquet file; units are those that a column's metadata holds as ``unit`` or ``units``."""

    def __init__(self, file: IO[bytes], metadata: parquet.FileMetaData, display_name: str) -> None:
        self.columns = tuple(metadata.schema.column(index).path for index in range(len(metadata.schema)))
        self.units = {}
        for column in metadata.schema.to_arrow_schema():
            for key in (b"unit", b"units"):
                if column.metadata and key in column.metadata:
                    self.units[column.name] = column.metadata[key].decode("utf-8", "replace")
        self.n_rows = metadata.num_rows
        self.display_name, self.place = display_name, "schema"
        self._file, self._metadata = file, metadata

    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            For a damaged or cut off file, a column that holds no numbers, an empty cell.
        """
        if self.n_rows == 0:
            raise InputError.at(
                FaultCode.FILE_EMPTY, self.display_name, "", "the table has no rows", "log again, or leave the file out"
            )
        self._file.seek(0)
        row = 1
        # Words are read as the numbers of entries in a dictionary: one of 100 MB can stand in each of a billion rows.
        words = [name for name in (*wanted.texts, *wanted.times) if name in self.columns]
        with parquet.ParquetFile(
            self._file, metadata=self._metadata, page_checksum_verification=True, read_dictionary=words
        ) as file:
            for index, name in enumerate(self.columns):
                if name in wanted.names:
                    _check_kind(file, index, wanted, self.display_name)
            for records in file.iter_batches(self.BATCH_ROWS, columns=list(wanted.names), use_threads=False):
                batch = _batch(records, wanted, row, self.display_name)
                row += len(batch)
                yield batch
        if row - 1 != self.n_rows:
            reason = f"incomplete Parquet file ({row - 1} rows where its footer has {self.n_rows})"
            raise InputError.at(
                FaultCode.FILE_DAMAGED, self.display_name, "", reason, "copy it again from its origin, or log again"
            )


@contextmanager
def open_log(path: Path, options: Options, display_name: str) -> Iterator[OpenParquet]:
    """Open a log; raises `InputError` for a damaged file."""
    # As a path pyarrow takes no name that is not UTF-8.
    with damaged_file_errors("Parquet file", display_name), open_regular(path, display_name) as file:
        yield OpenParquet(file, parquet.read_metadata(file), display_name)


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
            numbers[name] = _seconds(column, name, display_name, first_row, wanted.date_order)
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


def _seconds(column: pa.Array, name: str, display_name: str, first_row: int, order: str) -> Floats:
    if pa.types.is_timestamp(column.type):
        counts = values_of(column.cast(pa.int64()))
        return (counts / (1_000_000_000 / NANOSECONDS[column.type.unit])).astype("float64")
    return seconds_of_times(_text_cells(column, name, display_name), display_name, name, first_row, order)


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

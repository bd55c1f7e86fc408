"""Parquet tables that anybody may have written, read in a child process; and put together here, without the library.

Numbers, truth values and words are all that travels: other columns are refused.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pyarrow as pa

from stiffcal.bounded_work.client import Work
from stiffcal.bounded_work.messages import Document, joined
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import PIECE, ROWS, check_unpacked
from stiffcal.plain_files import is_refused, open_inside

KINDS = {"double": pa.float64(), "int64": pa.int64(), "bool": pa.bool_(), "string": pa.string()}
"""The types that are read, by Arrow's names of them."""


def read_parquet(
    root: Path, inside: str, size: int, columns: Sequence[str] | None, rows: int, display_name: str, place: str
) -> Iterator[pa.RecordBatch]:
    """Yield a table in pieces, one at least.

    Parameters
    ----------
    root, inside, size : where the file is, as `open_inside` takes it, and its bytes.
    columns : which; None: all. rows : of a piece, at most.
    display_name, place : how to call it in a fault.

    Raises
    ------
    InputError
        A file that is damaged, holds columns of other types, or takes more than it may.
    """
    values = {
        "root": str(root),
        "inside": inside,
        "columns": None if columns is None else list(columns),
        "rows": rows,
        "name": display_name,
        "place": place,
    }
    work = Work(__name__, values, size, display_name, "copy it again from its origin", place)
    sent = n_rows = 0
    with closing(work.answers()) as answers:
        head, _ = next(answers)
        metadata = {key.encode("latin-1"): value.encode("latin-1") for key, value in head["metadata"].items()}
        schema = pa.schema([(str(name), KINDS[kind]) for name, kind in head["columns"]], metadata)
        PIECE.check(8 * int(head["n_rows"]) * len(schema), display_name, place)
        for head, rest in answers:
            sent, n_rows = sent + len(rest), n_rows + int(head["n_rows"])
            check_unpacked(sent, size, display_name, place)
            ROWS.check(n_rows, display_name, place)
            yield _batch_of(head, rest, schema)


def prepare(values: Document) -> None:
    """Import the library."""
    import pyarrow.parquet  # noqa: F401


def answers(values: Document) -> Generator[tuple[bytes, int], None, None]:
    """Yield the table's columns, and its rows."""
    import pyarrow.parquet as parquet

    name, place = values["name"], values["place"]
    try:
        with (
            open_inside(Path(values["root"]), values["inside"]) as file,
            parquet.ParquetFile(file, page_checksum_verification=True) as table,
        ):
            schema, chosen = table.schema_arrow, values["columns"]
            if len(set(schema.names)) < len(schema):
                raise _damaged(name, place, "two of its columns have one name")
            for field in schema:
                if str(field.type) not in KINDS:
                    raise _damaged(name, place, f"column {field.name!r} holds {str(field.type)[:100]}")
            chosen = [field.name for field in schema if chosen is None or field.name in chosen]
            metadata = {
                key.decode("latin-1"): value.decode("latin-1") for key, value in (schema.metadata or {}).items()
            }
            head = {
                "kind": "columns",
                "columns": [(column, str(schema.field(column).type)) for column in chosen],
                "metadata": metadata,
                "n_rows": table.metadata.num_rows,
            }
            yield joined(head), 0
            if table.metadata.num_rows == 0:
                yield _rows_message(0, [_nothing(schema.field(column).type) for column in chosen]), 0
            for records in table.iter_batches(values["rows"], columns=chosen, use_threads=False):
                yield _rows_message(len(records), [_pieces(column) for column in records.columns]), 0
    except (OSError, pa.ArrowException) as error:
        if isinstance(error, MemoryError) or (isinstance(error, OSError) and is_refused(error)):
            raise
        raise _damaged(name, place, (str(error).splitlines() or [type(error).__name__])[0]) from None


def _rows_message(n_rows: int, columns: Sequence[Sequence[bytes]]) -> bytes:
    """Return the message of some rows; of each column the pieces of `_pieces`."""
    head = {"kind": "rows", "n_rows": n_rows, "bytes": [[len(piece) for piece in pieces] for pieces in columns]}
    return joined(head, [piece for pieces in columns for piece in pieces])


def _nothing(kind: pa.DataType) -> list[bytes]:
    """Return the pieces of a column without rows, for which pyarrow's own empty tables import pandas."""
    return [b"", bytes(4), b""] if pa.types.is_string(kind) else [b"", b""]


def _pieces(column: pa.Array) -> list[bytes]:
    """Return bits of the cells that hold something (b"": all do) and the values; of words their ends and letters."""
    if len(column) == 0:
        return _nothing(column.type)
    start, end = column.offset, column.offset + len(column)
    held, *data = column.buffers()
    validity = _bits(held, start, len(column)) if column.null_count else b""
    if pa.types.is_boolean(column.type):
        return [validity, _bits(data[0], start, len(column))]
    if not pa.types.is_string(column.type):
        return [validity, memoryview(data[0])[8 * start : 8 * end].tobytes()]
    ends = np.frombuffer(data[0], np.int32)[start : end + 1]
    letters = memoryview(data[1])[ends[0] : ends[-1]].tobytes() if data[1] is not None else b""
    return [validity, (ends - ends[0]).astype(np.int32).tobytes(), letters]


def _bits(buffer: pa.Buffer, start: int, count: int) -> bytes:
    bits = np.unpackbits(np.frombuffer(buffer, np.uint8), bitorder="little")[start : start + count]
    return np.packbits(bits, bitorder="little").tobytes()


def _batch_of(head: Document, rest: memoryview, schema: pa.Schema) -> pa.RecordBatch:
    """Return the rows of a message, every length and word of it checked."""
    n_rows, at, arrays = int(head["n_rows"]), 0, []
    for field, lengths in zip(schema, head["bytes"], strict=True):
        buffers: list[pa.Buffer | None] = []
        for length in lengths:
            buffers.append(pa.py_buffer(bytes(rest[at : at + int(length)])))
            at += int(length)
        if not len(buffers[0] or b""):
            buffers[0] = None
        array = pa.Array.from_buffers(field.type, n_rows, buffers)
        array.validate(full=True)
        arrays.append(array)
    return pa.RecordBatch.from_arrays(arrays, schema=schema)


def _damaged(display_name: str, place: str, reason: str) -> InputError:
    return InputError.at(FaultCode.FILE_DAMAGED, display_name, place, reason, "copy it again from its origin")

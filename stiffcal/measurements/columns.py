"""Table columns from numpy arrays and words, and back.

Why not ``pyarrow.array``: it imports pandas to see whether it was given a frame, a fifth of a second on every start.
pyarrow itself is imported where a table is touched: answers that read documents alone do without it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pyarrow as pa

Values = NDArray[Any] | Sequence[str]
Columns = Mapping[str, Values]

TABLE_DOCUMENT = b"stiffcal"
"""Key of the JSON document that stands with a stored table: what its columns alone do not hold."""


def column_of(values: Values) -> pa.Array:
    """Return an Arrow array: float64, int64 or bool without copying where possible, anything else as strings.

    Parameters
    ----------
    values : (n,) numbers or truth values, or n words.

    Examples
    --------
    >>> column_of(np.array([1.5, 2.0])).type, column_of(["a", "µ"]).type
    (DataType(double), DataType(string))
    """
    import pyarrow as pa

    array = np.asarray(values)
    if array.ndim != 1:
        raise ValueError(f"a column has one dimension, not {array.ndim}")
    if array.dtype.kind == "f":
        return _of_buffer(pa.float64(), np.ascontiguousarray(array, dtype=np.float64))
    if array.dtype.kind in "iu":
        return _of_buffer(pa.int64(), np.ascontiguousarray(array, dtype=np.int64))
    if array.dtype.kind == "b":
        bits = np.packbits(array, bitorder="little")
        return pa.Array.from_buffers(pa.bool_(), len(array), [None, pa.py_buffer(bits)])
    encoded = [str(word).encode() for word in values]
    ends = np.zeros(len(encoded) + 1, dtype=np.int32)
    np.cumsum([len(word) for word in encoded], out=ends[1:])
    buffers = [None, pa.py_buffer(ends), pa.py_buffer(b"".join(encoded))]
    return pa.Array.from_buffers(pa.string(), len(encoded), buffers)


def table_of(columns: Columns) -> pa.Table:
    """Return an Arrow table of columns of equal length; see `column_of`.

    Examples
    --------
    >>> table_of({"run": ["a", "b"], "Fx": np.array([1.0, 2.0])}).num_rows
    2
    """
    import pyarrow as pa

    arrays = [column_of(values) for values in columns.values()]
    if len({len(array) for array in arrays}) > 1:
        raise ValueError(f"columns of unequal length: { ({name: len(values) for name, values in columns.items()}) }")
    return pa.Table.from_arrays(arrays, names=list(columns))


def _of_buffer(kind: pa.DataType, array: NDArray[Any]) -> pa.Array:
    import pyarrow as pa

    return pa.Array.from_buffers(kind, len(array), [None, pa.py_buffer(array)])


def values_of(column: pa.Array | pa.ChunkedArray) -> NDArray[Any]:
    """Return a column of numbers or truth values as a numpy array, the inverse of `column_of`; missing floats as NaN.

    Why not ``to_numpy``: it imports pandas. Words come back as an array of ``str``.

    Examples
    --------
    >>> values_of(column_of(np.array([1.5, 2.0])))
    array([1.5, 2. ])
    """
    import pyarrow as pa

    chunks = column.chunks if isinstance(column, pa.ChunkedArray) else [column]
    pieces = [_values_of_chunk(chunk) for chunk in chunks]
    if not pieces:
        return _values_of_chunk(pa.Array.from_buffers(column.type, 0, [None] * column.type.num_buffers))
    return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)


def _values_of_chunk(chunk: pa.Array) -> NDArray[Any]:
    import pyarrow as pa

    start, end = chunk.offset, chunk.offset + len(chunk)
    if pa.types.is_string(chunk.type) or pa.types.is_large_string(chunk.type):
        return np.array([word.as_py() for word in chunk], dtype=np.str_)
    if len(chunk) == 0:
        return np.empty(0, dtype=chunk.type.to_pandas_dtype())
    validity, data = chunk.buffers()
    if pa.types.is_boolean(chunk.type):
        return np.unpackbits(np.frombuffer(data, np.uint8), bitorder="little")[start:end].astype(np.bool_)
    values = np.frombuffer(data, dtype=chunk.type.to_pandas_dtype())[start:end]
    if chunk.null_count:
        if not pa.types.is_floating(chunk.type):
            raise ValueError(f"missing values in a column of {chunk.type}")
        valid = np.unpackbits(np.frombuffer(validity, np.uint8), bitorder="little")[start:end]
        values = np.where(valid == 1, values, np.nan)
    return values

"""Arrays of NumPy: ``.npz`` and ``.npy``, without anything that is pickled."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.limits import COLUMNS
from stiffcal.log_columns import Options, damaged_file_errors, nearest_name
from stiffcal.parsers.named_columns import NamedColumn, OpenColumns

NPY = b"\x93NUMPY"
NAMELESS = "column"
"""Columns of a matrix without names are called column1, column2 …, as those of a text without a header are."""


@contextmanager
def open_log(path: Path, options: Options, display_name: str) -> Iterator[OpenColumns]:
    """Open a log.

    Raises
    ------
    InputError
        For a damaged file, an array that is not there, one of Python objects, one without columns.
    """
    with damaged_file_errors("file of NumPy", display_name), open_regular(path, display_name) as file:
        is_single = file.read(len(NPY)) == NPY
        file.seek(0)
        arrays = {"": _single(file)} if is_single else _archive(file)
        place = "array" if is_single else "arrays"
        yield OpenColumns(_columns(arrays, options, display_name), display_name, place)


@dataclass(frozen=True)
class _Array:
    """An array that is loaded when it is asked for."""

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    load: Callable[[], NDArray[Any]]


def _single(file: IO[bytes]) -> _Array:
    shape, dtype = _head(file)

    def load() -> NDArray[Any]:
        file.seek(0)
        return np.lib.format.read_array(file, allow_pickle=False)

    return _Array(shape, dtype, cache(load))


def _archive(file: IO[bytes]) -> dict[str, _Array]:
    """Return the arrays of an archive, by their heads."""
    import zipfile

    archive = zipfile.ZipFile(file)
    found = {}
    for name in archive.namelist():
        with archive.open(name) as member:
            shape, dtype = _head(member)
        found[name.removesuffix(".npy")] = _Array(shape, dtype, cache(partial(_member, archive, name)))
    return found


def _member(archive: Any, name: str) -> NDArray[Any]:
    with archive.open(name) as member:
        return np.lib.format.read_array(member, allow_pickle=False)


def _head(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return an array's shape and type, which stand before its values."""
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(file)
    return shape, dtype


def _columns(arrays: dict[str, _Array], options: Options, display_name: str) -> dict[str, NamedColumn]:
    """Return the columns that the options point at."""
    requested, names = options.get("array"), options.get("columns")
    if requested is not None:
        if str(requested) not in arrays:
            mend = nearest_name(str(requested), [name for name in arrays if name])
            reason = f"no array {requested!r}"
            raise InputError.at(FaultCode.LOG_PART_MISSING, display_name, "npz.array", reason, mend)
        arrays = {"": arrays[str(requested)]}
    columns: dict[str, NamedColumn] = {}
    alone = len(arrays) == 1
    for name, array in arrays.items():
        if array.dtype.hasobject:
            reason = f"array {name!r} holds Python objects, which are programs and not loaded"
            mend = "save each column as an array of numbers or words: np.savez(file, t=t, Fx=Fx)"
            raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, display_name, "", reason, mend)
        columns |= _of_array(array, "" if alone else name, name)
    if names is not None:
        if not isinstance(names, list) or len(names) != len(columns) or not alone:
            counts = f"{len(names) if isinstance(names, list) else 0} names for {len(columns)} columns"
            reason = counts if alone else f"{len(arrays)} arrays, of which each has a name of its own"
            mend = "give npz.array, and one name per column" if not alone else "give one name per column"
            raise InputError.at(FaultCode.SHAPE_MISMATCH, display_name, "npz.columns", reason, mend)
        columns = dict(zip(map(str, names), columns.values(), strict=True))
    if not columns:
        listed = ", ".join(f"{name!r} of shape {array.shape}" for name, array in list(arrays.items())[:12]) or "nothing"
        reason = f"no columns: it holds {listed}"
        raise InputError.at(FaultCode.FILE_EMPTY, display_name, "", reason, "save arrays of one or two dimensions")
    return columns


def _of_array(array: _Array, stem: str, own_name: str) -> dict[str, NamedColumn]:
    """Return the columns of an array; `stem`: what their names begin with, "" where it is the only array."""
    if not array.shape or len(array.shape) > 2:
        return {}
    n_rows = array.shape[0]
    if array.dtype.names:
        fields = array.dtype.names if len(array.shape) == 1 else ()
        prefix = f"{stem}." if stem else ""
        return {f"{prefix}{name}": NamedColumn(n_rows, partial(_field, array, name)) for name in fields}
    if len(array.shape) == 1:
        return {own_name or f"{NAMELESS}1": NamedColumn(n_rows, partial(_rows, array))}
    width = array.shape[1]
    COLUMNS.check(width, own_name or "the array")
    names = [f"{stem}[{k}]" if stem else f"{NAMELESS}{k + 1}" for k in range(width)]
    if width == 1 and own_name:
        names = [own_name]
    return {name: NamedColumn(n_rows, partial(_column, array, k)) for k, name in enumerate(names)}


def _rows(array: _Array, start: int, end: int) -> NDArray[Any]:
    return array.load()[start:end]


def _field(array: _Array, name: str, start: int, end: int) -> NDArray[Any]:
    values: NDArray[Any] = array.load()[name]
    return values[start:end]


def _column(array: _Array, number: int, start: int, end: int) -> NDArray[Any]:
    return array.load()[start:end, number]

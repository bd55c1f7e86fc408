"""MAT files of version 7.3: HDF5, in which groups are structs and every array lies transposed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from stiffcal.parsers.hdf5_files import Read, by_chunk, checked, members_of, open_hdf5
from stiffcal.parsers.mat_classes import PLAIN_CLASSES
from stiffcal.parsers.named_columns import NamedColumn

MOST_LETTERS = 1 << 16  # of a word in a cell


@contextmanager
def open_tree(path: Path, display_name: str) -> Iterator[Tree73]:
    """Open a file; raises `InputError` where something in it leads to another file."""
    with open_hdf5(path, display_name) as file:
        yield Tree73(file, display_name)


class Tree73:
    """A file of version 7.3: groups are structs, every array lies transposed."""

    def __init__(self, file: h5py.File, display_name: str) -> None:
        self.top: Any = file
        self._file = file
        self._display_name = display_name

    def members(self, item: Any) -> dict[str, Any] | None:
        """Return the fields of a struct, or the variables of the file; None of anything else."""
        if not isinstance(item, h5py.Group):
            return None
        return {name: member for name, member in members_of(item).items() if not name.startswith("#")}

    def kind(self, item: Any) -> str:
        """Return MATLAB's name of an item's class."""
        kind = item.attrs.get("MATLAB_class", b"struct" if isinstance(item, h5py.Group) else b"double")
        return kind.decode() if isinstance(kind, bytes) else str(kind)

    def vectors(self, item: Any) -> dict[str, NamedColumn]:
        """Return the columns of a matrix by number from 1, of a vector by the empty name."""
        if not isinstance(item, h5py.Dataset) or item.ndim != 2 or "MATLAB_empty" in item.attrs:
            return {}
        kind = self.kind(item)
        if kind not in PLAIN_CLASSES or kind == "char":
            return {}
        n_columns, n_rows = item.shape
        if n_rows == 1:
            rows = by_chunk(lambda a, b: np.asarray(item[a:b, 0]), item, 0, n_columns)
            return {"": NamedColumn(n_columns, self._reader(kind, rows))}
        rows_of = [by_chunk(partial(_transposed, item, column), item, 1, n_rows) for column in range(n_columns)]
        vectors = [NamedColumn(n_rows, self._reader(kind, rows)) for rows in rows_of]
        return {"" if n_columns == 1 else str(k + 1): vector for k, vector in enumerate(vectors)}

    def _reader(self, kind: str, read: Read) -> Read:
        if kind != "cell":
            return read
        return lambda a, b: np.array([self._word(reference) for reference in read(a, b)], dtype=object)

    def _word(self, reference: Any) -> str:
        cell = checked(self._file[reference], self._display_name)
        if not isinstance(cell, h5py.Dataset) or cell.size > MOST_LETTERS:
            return ""
        if self.kind(cell) != "char" or "MATLAB_empty" in cell.attrs:
            return ""
        return "".join(chr(code) for code in np.asarray(cell).ravel())


def _transposed(item: Any, column: int, start: int, end: int) -> NDArray[Any]:
    return np.asarray(item[column, start:end])

"""MAT files of version 5 to 7, whose variables are packed whole."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.parsers.mat_classes import PLAIN_CLASSES
from stiffcal.parsers.named_columns import NamedColumn

Read = Callable[[int, int], NDArray[Any]]


@contextmanager
def open_tree(path: Path) -> Iterator[Tree5]:
    """Open a file."""
    yield Tree5(path)


class Tree5:
    """A file of version 5 to 7, its variables read one by one when they are asked for."""

    def __init__(self, path: Path) -> None:
        from scipy.io import loadmat, whosmat

        outline = whosmat(str(path), appendmat=False)
        self._outline = {name: (shape, kind) for name, shape, kind in outline}
        self.top: Any = None  # the file itself, whose members are its variables

        @cache
        def load(name: str) -> Any:
            return loadmat(str(path), appendmat=False, variable_names=[name])[name]

        self._load = load

    def members(self, item: Any) -> dict[str, Any] | None:
        """Return the fields of a struct, or the variables of the file; None of anything else."""
        if item is None:
            return {name: ("", name) for name in self._outline}
        if self.kind(item) != "struct":
            return None
        value = self._value(item)
        if value.size != 1:
            return {}
        return {name: ("value", value.flat[0][name]) for name in value.dtype.names or ()}

    def _value(self, item: Any) -> Any:
        return self._load(item[1]) if item[0] == "" else item[1]

    def kind(self, item: Any) -> str:
        """Return MATLAB's name of an item's class."""
        if item[0] == "":
            return str(self._outline[item[1]][1])
        value = item[1]
        if not isinstance(value, np.ndarray):
            return type(value).__name__
        if value.dtype.names is not None:
            return "struct"
        return {"O": "cell", "U": "char", "V": "opaque"}.get(value.dtype.kind, "double")

    def vectors(self, item: Any) -> dict[str, NamedColumn]:
        """Return the columns of a matrix by number from 1, of a vector by the empty name."""
        kind = self.kind(item)
        shape = self._outline[item[1]][0] if item[0] == "" else item[1].shape if isinstance(item[1], np.ndarray) else ()
        if kind not in PLAIN_CLASSES or kind in ("char", "struct") or len(shape) != 2:
            return {}
        n_rows, n_columns = shape

        def reader(column: int | None) -> Read:
            def read(start: int, end: int) -> NDArray[Any]:
                value = self._value(item)
                cells = value.ravel()[start:end] if column is None else value[start:end, column]
                return np.array([_cell_word(cell) for cell in cells], dtype=object) if kind == "cell" else cells

            return read

        if 1 in (n_rows, n_columns):
            return {"": NamedColumn(n_rows * n_columns, reader(None))}
        return {str(k + 1): NamedColumn(n_rows, reader(k)) for k in range(n_columns)}


def _cell_word(cell: Any) -> str:
    value = np.asarray(cell)
    return str(value.ravel()[0]) if value.dtype.kind == "U" and value.size == 1 else ""

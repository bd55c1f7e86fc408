"""MATLAB's MAT files: version 5 to 7 (`save`), and 7.3 (``save -v7.3``), which is HDF5 inside.

Options of the manifest (``mat = {…}``), all optional:

variable : the struct whose fields are the columns, or the matrix that holds them; members by points: ``log.ft``.
    Absent: the file's own variables are the columns, or the fields of its only struct.
columns : the names of a matrix's columns, in order.

A column is a vector, or one column of a matrix; words are a cell array of character vectors. What MATLAB stores in a
form of its own (table, timetable, datetime, string) is not readable outside it and is refused by name.

Version 7.3 is read in pieces. Version 5 packs each variable whole, so that the wanted ones are held in memory (MATLAB
itself bounds each to 2 GB).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Annotated, Any

import h5py
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from stiffcal.campaign.typed import Name, TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import COLUMNS, ROWS
from stiffcal.measurements.hdf5_heaps import attribute_of
from stiffcal.measurements.hdf5_links import check_item, members_inside
from stiffcal.measurements.hdf5_sizes import by_chunk, check_sizes
from stiffcal.measurements.mat5_elements import check_elements
from stiffcal.readers import (
    Batch,
    FuzzInput,
    Header,
    Options,
    Reader,
    WantedColumns,
    batch_of_columns,
    check_columns,
    check_options,
    check_there,
    common_length,
    damaged_file_errors,
    nearest_name,
)

BATCH_ROWS = 1 << 16
MOST_LETTERS = 1 << 16  # of a word in a cell
PLAIN_CLASSES = (
    "double",
    "single",
    "logical",
    "char",
    "cell",
    "struct",
    *(f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64)),
)
IN_MATLAB = "save what is in it as vectors, e.g. s = table2struct(T, ToScalar=true); save(file, '-struct', 's')"

Read = Callable[[int, int], NDArray[Any]]


@dataclass(frozen=True)
class Vector:
    """A column: how many rows it has, how to read some of them, and the HDF5 dataset in which they lie, if any."""

    n_rows: int
    read: Read
    dataset: Any = None


class MatOptions(TomlTable):
    """Where in a MAT file the columns lie.

    Attributes
    ----------
    variable : the struct whose fields they are, or the matrix that holds them (``log.ft``); absent: the file itself.
    columns : the names of a matrix's columns.
    """

    variable: Name | None = None
    columns: Annotated[list[Name] | None, Field(min_length=1)] = None


def _write_fuzz_input(path: Path) -> None:
    from scipy.io import savemat

    savemat(path, {"t": np.linspace(0.0, 0.6, 60), "Fx": np.arange(-30.5, 29.0)}, oned_as="column")


def _write_fuzz_input_73(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in (("t", np.linspace(0.0, 0.6, 60)), ("Fx", np.arange(-30.5, 29.0))):
            file.create_dataset(name, data=values[None, :]).attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")


class MatReader(Reader):
    """Reads MAT files in batches of rows."""

    name = "mat"
    endings = (".mat",)
    first_bytes = b"MATLAB "
    options = MatOptions
    fuzz_inputs = (
        FuzzInput(".mat", _write_fuzz_input, ("t", "Fx")),
        FuzzInput(".mat", _write_fuzz_input_73, ("t", "Fx")),
    )

    def read_header(
        self, path: Path, options: Options, display_name: str = "", wanted: WantedColumns | None = None
    ) -> Header:
        """Return the columns of the variable; MAT files state no units."""
        display_name = display_name or str(path)
        with _open(path, options, display_name) as (columns, place):
            if wanted is not None:
                check_columns(wanted, tuple(columns), display_name, place)
            lengths = {column.n_rows for column in columns.values()}
            return Header(tuple(columns), {}, lengths.pop() if len(lengths) == 1 else None)

    def read_batches(
        self, path: Path, options: Options, wanted: WantedColumns, display_name: str = ""
    ) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            For a damaged or cut off file, a missing variable, columns of unequal length, a column of another kind, a
            number that is not finite.
        """
        display_name = display_name or str(path)
        with _open(path, options, display_name) as (columns, place):
            check_columns(wanted, tuple(columns), display_name, place)
            n_rows = common_length({name: columns[name].n_rows for name in wanted.names}, wanted, display_name)
            ROWS.check(n_rows, display_name)
            datasets = {name: columns[name].dataset for name in wanted.names if columns[name].dataset is not None}
            if datasets:
                check_sizes(datasets, n_rows, display_name)

            def read(name: str, start: int, end: int) -> NDArray[Any]:
                return columns[name].read(start, end)

            for start in range(0, n_rows, BATCH_ROWS):
                yield batch_of_columns(read, wanted, start, min(start + BATCH_ROWS, n_rows), display_name)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``row n``."""
        return f"row {row}"


READER = MatReader()


@contextmanager
def _open(path: Path, options: Options, display_name: str) -> Iterator[tuple[dict[str, Vector], str]]:
    check_options(options, MatOptions, "mat", display_name)
    check_there(path, display_name)
    variable = str(options.get("variable") or "")
    place = f"variable {variable}" if variable else ""
    with damaged_file_errors("MAT file", display_name, "copy it again from its origin, or save it again"):
        if h5py.is_hdf5(path):
            with h5py.File(path, "r") as file:
                yield _columns(_Tree73(file, display_name), options, display_name), place
        else:
            yield _columns(_Tree5(path, display_name), options, display_name), place


def _columns(tree: _Tree73 | _Tree5, options: Options, display_name: str) -> dict[str, Vector]:
    """Return the columns that the options point at."""
    variable, names = str(options.get("variable") or ""), options.get("columns")
    item, path = tree.top, ""
    for step in variable.split(".") if variable else []:
        inside_item = tree.members(item)
        if inside_item is None or step not in inside_item:
            inside = f" in {path!r}" if path else ""
            mend = nearest_name(step, list(inside_item or ()))
            raise InputError.at(
                FaultCode.LOG_PART_MISSING, display_name, "mat.variable", f"no variable {step!r}{inside}", mend
            )
        item, path = inside_item[step], f"{path}.{step}".strip(".")
    members = tree.members(item)
    if members is not None and not variable and len(members) == 1 and not names:
        (only,) = members
        inner = tree.members(members[only])
        members, path = (inner, only) if inner is not None else (members, path)
    if members is None:
        return _matrix_columns(tree, item, names, path, display_name)
    if names:
        raise InputError.at(
            FaultCode.OPTION_CONFLICT,
            display_name,
            "mat.columns",
            "column names apply to a matrix only",
            "give the matrix: mat.variable",
        )
    columns = {}
    for name, member in members.items():
        for column, vector in tree.vectors(member).items():
            columns[name if not column else f"{name}[{column}]"] = vector
    if not columns:
        opaque = [name for name, member in members.items() if tree.kind(member) not in PLAIN_CLASSES]
        if opaque:
            reason = f"{opaque[0]!r} is a MATLAB {tree.kind(members[opaque[0]])}, which only MATLAB can read"
            raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, display_name, f"variable {opaque[0]}", reason, IN_MATLAB)
        listed = ", ".join(repr(name) for name in list(members)[:12]) or "nothing"
        raise InputError.at(
            FaultCode.FILE_EMPTY,
            display_name,
            "",
            "contains no vectors",
            f"give a struct or matrix: mat.variable; the file has {listed}",
        )
    return columns


def _matrix_columns(
    tree: _Tree73 | _Tree5, item: Any, names: object, path: str, display_name: str
) -> dict[str, Vector]:
    if tree.kind(item) not in PLAIN_CLASSES:
        reason = f"it is a MATLAB {tree.kind(item)}, which only MATLAB can read"
        raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, display_name, f"variable {path}", reason, IN_MATLAB)
    vectors = tree.vectors(item)
    if not isinstance(names, list) or len(names) != len(vectors):
        counts = f"{len(names)} names for " if isinstance(names, list) else "its columns have no names: "
        mend = 'write mat.columns = ["Fx", "Fy", "Fz"], say, one name per column'
        raise InputError.at(
            FaultCode.SHAPE_MISMATCH, display_name, f"variable {path}", f"{counts}{len(vectors)} columns", mend
        )
    return {str(name): vector for name, vector in zip(names, vectors.values(), strict=True)}


class _Tree73:
    """A file of version 7.3: groups are structs, every array lies transposed."""

    def __init__(self, file: h5py.File, display_name: str) -> None:
        self.top: Any = file
        self._file = file
        self._display_name = display_name

    def members(self, item: Any) -> dict[str, Any] | None:
        if not isinstance(item, h5py.Group):
            return None
        COLUMNS.check(len(item), self._display_name, str(item.name))
        members, _ = members_inside(item)  # what lies in another file is no variable of this one
        return {name: member for name, member in members.items() if not name.startswith("#")}

    def kind(self, item: Any) -> str:
        kind = attribute_of(item, "MATLAB_class", b"struct" if isinstance(item, h5py.Group) else b"double")
        return kind.decode() if isinstance(kind, bytes) else str(kind)

    def vectors(self, item: Any) -> dict[str, Vector]:
        """Return the columns of a matrix by number from 1, of a vector by the empty name."""
        if not isinstance(item, h5py.Dataset) or item.ndim != 2 or "MATLAB_empty" in item.attrs:
            return {}
        if item.is_virtual:  # MATLAB writes none
            return {}
        kind = self.kind(item)
        if kind not in PLAIN_CLASSES or kind == "char":
            return {}
        n_columns, n_rows = item.shape
        if n_rows == 1:
            rows = by_chunk(lambda a, b: np.asarray(item[a:b, 0]), item, 0, n_columns)
            return {"": Vector(n_columns, self._reader(item, kind, rows), item)}
        COLUMNS.check(n_columns, self._display_name, str(item.name))
        rows_of = [by_chunk(partial(_transposed, item, column), item, 1, n_rows) for column in range(n_columns)]
        vectors = [Vector(n_rows, self._reader(item, kind, rows), item) for rows in rows_of]
        return {"" if n_columns == 1 else str(k + 1): vector for k, vector in enumerate(vectors)}

    def _reader(self, item: Any, kind: str, read: Read) -> Read:
        if kind != "cell":
            return read
        return lambda a, b: np.array([self._word(reference) for reference in read(a, b)], dtype=object)

    def _word(self, reference: Any) -> str:
        cell = self._file[reference]
        check_item(cell, "a cell")
        if not isinstance(cell, h5py.Dataset) or cell.size > MOST_LETTERS:
            return ""
        if self.kind(cell) != "char" or "MATLAB_empty" in cell.attrs:
            return ""
        return "".join(chr(code) for code in np.asarray(cell).ravel())


def _transposed(item: Any, column: int, start: int, end: int) -> NDArray[Any]:
    return np.asarray(item[column, start:end])


class _Tree5:
    """A file of version 5 to 7, its variables read one by one when they are asked for."""

    def __init__(self, path: Path, display_name: str) -> None:
        from scipy.io import loadmat, whosmat

        check_elements(path, display_name)
        outline = whosmat(str(path), appendmat=False)
        self._outline = {name: (shape, kind) for name, shape, kind in outline}
        self.top: Any = None  # the file itself, whose members are its variables

        @cache
        def load(name: str) -> Any:
            return loadmat(str(path), appendmat=False, variable_names=[name])[name]

        self._load = load

    def members(self, item: Any) -> dict[str, Any] | None:
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
        if item[0] == "":
            return str(self._outline[item[1]][1])
        value = item[1]
        if not isinstance(value, np.ndarray):
            return type(value).__name__
        if value.dtype.names is not None:
            return "struct"
        return {"O": "cell", "U": "char", "V": "opaque"}.get(value.dtype.kind, "double")

    def vectors(self, item: Any) -> dict[str, Vector]:
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
            return {"": Vector(n_rows * n_columns, reader(None))}
        return {str(k + 1): Vector(n_rows, reader(k)) for k in range(n_columns)}


def _cell_word(cell: Any) -> str:
    value = np.asarray(cell)
    return str(value.ravel()[0]) if value.dtype.kind == "U" and value.size == 1 else ""

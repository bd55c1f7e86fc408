"""HDF5 logs in the three layouts that are common.

Options of the manifest (``hdf5 = {…}``), all optional:

group : the group that holds the columns, "/" when absent.
dataset : a dataset in it that holds all columns; absent: the only one with two dimensions or with fields, if there is
    no dataset per column.

Layouts: one dataset of one dimension per column; one dataset of two dimensions whose attribute ``columns`` (or
``column_names``, ``names``, ``fields``, ``labels``) names its columns; one dataset of records with named fields. Units
are taken from an attribute ``unit`` or ``units``.

A writer that died leaves parts of a dataset unwritten, which HDF5 reads as zeros: such a dataset is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from stiffcal.campaign.typed import Name, TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import COLUMNS
from stiffcal.measurements.hdf5_heaps import attribute_of, bounded_memory, check_words
from stiffcal.measurements.hdf5_links import LeadsOutsideError, groups_inside, item_inside, members_inside
from stiffcal.measurements.hdf5_sizes import Read, by_chunk, check_sizes
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
    text_of,
)

BATCH_ROWS = 1 << 16
NAME_ATTRIBUTES = ("columns", "column_names", "names", "fields", "labels")
UNIT_ATTRIBUTES = ("unit", "units")
# Conventions by which stored numbers are not the physical ones.
SCALING_ATTRIBUTES = ("scale_factor", "add_offset", "scale", "offset", "gain")


class Hdf5Options(TomlTable):
    """Where in an HDF5 file the columns lie.

    Attributes
    ----------
    group : the group that holds them. dataset : one dataset in it that holds all columns; recognised where left out.
    """

    group: Name = "/"
    dataset: Name | None = None


@dataclass(frozen=True)
class Columns:
    """The columns of a group: names, how to read rows of one, how many rows there are, units, the datasets behind.

    `elsewhere` are the names that only link to another file, `groups` the groups next to them.
    """

    names: tuple[str, ...]
    read: Callable[[str, int, int], NDArray[Any]]
    lengths: dict[str, int]
    units: dict[str, str]
    datasets: dict[str, Any]
    elsewhere: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()


def _write_fuzz_input(path: Path) -> None:
    with h5py.File(path, "w") as file:
        for name, values in (("t", np.linspace(0.0, 0.6, 60)), ("Fx", np.arange(-30.5, 29.0))):
            file.create_dataset(name, data=values)
        file.create_dataset("run", data=[f"pose{k // 20}" for k in range(60)])


class Hdf5Reader(Reader):
    """Reads HDF5 files in batches of rows."""

    name = "hdf5"
    endings = (".h5", ".hdf5", ".hdf")
    options = Hdf5Options
    fuzz_inputs = (FuzzInput(".h5", _write_fuzz_input, ("t", "Fx"), ("run",)),)

    def recognises(self, path: Path) -> bool:
        """Return True for a file that begins like HDF5, or is named so."""
        return path.suffix.lower() in (*self.endings, ".he5") or bool(path.is_file() and h5py.is_hdf5(path))

    def read_header(
        self, path: Path, options: Options, display_name: str = "", wanted: WantedColumns | None = None
    ) -> Header:
        """Return the columns of the group."""
        display_name = display_name or str(path)
        with _open(path, options, display_name) as (columns, place):
            if wanted is not None:
                _check_columns(wanted, columns, display_name, place)
            lengths = set(columns.lengths.values())
            return Header(columns.names, columns.units, lengths.pop() if len(lengths) == 1 else None)

    def read_batches(
        self, path: Path, options: Options, wanted: WantedColumns, display_name: str = ""
    ) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            For a damaged or cut off file, a missing column, columns of unequal length or partly unwritten, a cell
            that is no finite number.
        """
        display_name = display_name or str(path)
        with _open(path, options, display_name) as (columns, place):
            _check_columns(wanted, columns, display_name, place)
            n_rows = _checked_length(columns, wanted, display_name)
            for start in range(0, n_rows, BATCH_ROWS):
                end = min(start + BATCH_ROWS, n_rows)
                yield batch_of_columns(columns.read, wanted, start, end, display_name)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``row n``."""
        return f"row {row}"


READER = Hdf5Reader()


@contextmanager
def _open(path: Path, options: Options, display_name: str) -> Iterator[tuple[Columns, str]]:
    check_options(options, Hdf5Options, "hdf5", display_name)
    check_there(path, display_name)
    group_name = str(options.get("group") or "/")
    mend = "close the program that writes it, copy it again, or log again"
    with damaged_file_errors("HDF5 file", display_name, mend), h5py.File(path, "r") as file:
        try:
            group = _inside(file, group_name, display_name)
        except KeyError:
            near = nearest_name(group_name, groups_inside(file))
            raise InputError.at(
                FaultCode.LOG_PART_MISSING, display_name, "hdf5.group", f"no group {group_name!r}", near
            ) from None
        dataset = options.get("dataset")
        if isinstance(group, h5py.Dataset):
            yield _columns_of_dataset(group, display_name), group_name
        elif dataset is not None:
            item = None
            with suppress(KeyError):
                item = _inside(group, str(dataset), display_name)
            if not isinstance(item, h5py.Dataset):
                near = nearest_name(str(dataset), list(group))
                raise InputError.at(
                    FaultCode.LOG_PART_MISSING,
                    display_name,
                    "hdf5.dataset",
                    f"no dataset {dataset!r} in {group_name!r}",
                    near,
                )
            yield _columns_of_dataset(item, display_name), f"dataset {dataset}"
        else:
            yield _columns_of_group(group, display_name), f"group {group_name}"


def _inside(group: h5py.Group, name: str, display_name: str) -> Any:
    try:
        return item_inside(group, name)
    except LeadsOutsideError:
        raise _lies_elsewhere(name, display_name) from None


def _check_columns(wanted: WantedColumns, columns: Columns, display_name: str, place: str) -> None:
    for name in wanted.names:
        if name in columns.elsewhere:
            raise _lies_elsewhere(name, display_name)
    hint = ""
    if not columns.names and columns.groups:
        hint = f"give the group that contains it: hdf5.group = one of {', '.join(map(repr, columns.groups[:12]))}"
    check_columns(wanted, columns.names, display_name, place, hint)


def _lies_elsewhere(name: str, display_name: str) -> InputError:
    reason = f"{name!r} is in another file, to which this one only links"
    return InputError.at(FaultCode.FILE_OUTSIDE, display_name, name, reason, "copy it into this file, e.g. with h5copy")


def _columns_of_group(group: h5py.Group, display_name: str) -> Columns:
    COLUMNS.check(len(group), display_name, f"group {group.name}")
    members, elsewhere = members_inside(group)
    datasets = {name: item for name, item in members.items() if isinstance(item, h5py.Dataset)}
    flat = {
        name: item
        for name, item in datasets.items()
        if item.dtype.names is None and (item.ndim == 1 or (item.ndim == 2 and item.shape[1] == 1))
    }
    tables = [item for name, item in datasets.items() if name not in flat and item.ndim > 0]
    if not flat and not elsewhere and len(tables) == 1:
        return _columns_of_dataset(tables[0], display_name)

    readers = {name: by_chunk(partial(_rows_of, item), item, 0, item.shape[0]) for name, item in flat.items()}

    def read(name: str, start: int, end: int) -> NDArray[Any]:
        return readers[name](start, end)

    units = {name: unit for name, item in flat.items() if (unit := _unit(item))}
    lengths = {name: item.shape[0] for name, item in flat.items()}
    groups = tuple(str(item.name) for item in members.values() if isinstance(item, h5py.Group)) if not flat else ()
    return Columns(tuple(flat), read, lengths, units, flat, elsewhere, groups)


def _rows_of(dataset: Any, start: int, end: int) -> NDArray[Any]:
    return _rows(dataset, slice(start, end)).reshape(end - start)


def _rows(dataset: Any, which: Any) -> NDArray[Any]:
    with bounded_memory() if dataset.dtype.hasobject else nullcontext():
        return np.asarray(dataset[which])


def _columns_of_dataset(dataset: Any, display_name: str) -> Columns:
    place = f"dataset {dataset.name}"
    if dataset.dtype.names is not None and dataset.ndim == 1:
        names = tuple(dataset.dtype.names)

        def some(name: str) -> Read:
            return lambda start, end: _rows(dataset, (name, slice(start, end)))
    elif dataset.ndim == 2:
        names = _named_columns(dataset, display_name, place)

        def some(name: str) -> Read:
            column = names.index(name)
            return lambda start, end: np.asarray(dataset[start:end, column])
    else:
        reason = f"its shape {dataset.shape} is not a table"
        raise InputError.at(
            FaultCode.CONTENT_UNSUPPORTED,
            display_name,
            place,
            reason,
            "give a group with one dataset per column, or a table",
        )
    COLUMNS.check(len(names), display_name, place)
    readers = {name: by_chunk(some(name), dataset, 0, dataset.shape[0]) for name in names}
    units = _text_list(dataset, UNIT_ATTRIBUTES)
    return Columns(
        names,
        lambda name, start, end: readers[name](start, end),
        dict.fromkeys(names, dataset.shape[0]),
        dict(zip(names, units, strict=True)) if len(units) == len(names) else {},
        dict.fromkeys(names, dataset),
    )


def _named_columns(dataset: Any, display_name: str, place: str) -> tuple[str, ...]:
    names = tuple(_text_list(dataset, NAME_ATTRIBUTES))
    if len(names) != dataset.shape[1]:
        reason = f"{len(names)} names for {dataset.shape[1]} columns" if names else "its columns have no names"
        mend = f"write an attribute {NAME_ATTRIBUTES[0]!r} with one name per column"
        raise InputError.at(FaultCode.SHAPE_MISMATCH, display_name, place, reason, mend)
    return names


def _text_list(dataset: Any, attributes: tuple[str, ...]) -> list[str]:
    for attribute in attributes:
        value = attribute_of(dataset, attribute)
        if value is not None:
            if isinstance(value, bytes | str):
                return [text.strip() for text in text_of(value).split(",")]
            return [text_of(element).strip() for element in np.asarray(value).ravel()]
    return []


def _unit(dataset: Any) -> str:
    units = _text_list(dataset, UNIT_ATTRIBUTES)
    return units[0] if len(units) == 1 else ""


def _checked_length(columns: Columns, wanted: WantedColumns, display_name: str) -> int:
    n_rows = common_length(columns.lengths, wanted, display_name)
    check_sizes({name: columns.datasets[name] for name in wanted.names}, n_rows, display_name)
    for name in wanted.names:
        dataset = columns.datasets[name]
        check_words(dataset)
        scaled = [attribute for attribute in SCALING_ATTRIBUTES if attribute in dataset.attrs]
        if scaled and name in wanted.numbers:
            reason = f"its attribute {scaled[0]!r} marks the numbers as scaled"
            raise InputError.at(
                FaultCode.CONTENT_UNSUPPORTED,
                display_name,
                f"column {name}",
                reason,
                "write the physical values, without that attribute",
            )
        if _unwritten(dataset):
            reason = "parts of it were never written: writing was interrupted"
            raise InputError.at(
                FaultCode.FILE_INCOMPLETE,
                display_name,
                f"column {name}",
                reason,
                "log again, or cut the rows off in a copy",
            )
    return n_rows


def _unwritten(dataset: Any) -> bool:
    """Return True where HDF5 would give fill values for rows that no one wrote."""
    if dataset.chunks is None:
        return dataset.size > 0 and dataset.id.get_storage_size() == 0 and not dataset.is_virtual
    needed = int(np.prod([-(-size // chunk) for size, chunk in zip(dataset.shape, dataset.chunks, strict=True)]))
    return int(dataset.id.get_num_chunks()) < needed

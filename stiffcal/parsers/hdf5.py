"""HDF5 logs: one dataset per column, one of two dimensions with names, or one of records."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.log_columns import (
    Batch,
    Options,
    WantedColumns,
    batch_of_columns,
    check_columns,
    common_length,
    damaged_file_errors,
    nearest_name,
    text_of,
)
from stiffcal.parsers.hdf5_files import Read, by_chunk, member_of, members_of, open_hdf5
from stiffcal.parsers.open_log import OpenLog

NAME_ATTRIBUTES = ("columns", "column_names", "names", "fields", "labels")
UNIT_ATTRIBUTES = ("unit", "units")
# Conventions by which stored numbers are not the physical ones.
SCALING_ATTRIBUTES = ("scale_factor", "add_offset", "scale", "offset", "gain")
MOST_LISTED = 20_000
MOST_LEVELS = 20  # of groups in groups: a file may hold itself
MEND = "close the program that writes it, copy it again, or log again"


@dataclass(frozen=True)
class Columns:
    """The columns of a group: names, how to read rows of one, how many rows there are, units, the datasets behind.

    `groups` are those next to them.
    """

    names: tuple[str, ...]
    read: Callable[[str, int, int], NDArray[Any]]
    lengths: dict[str, int]
    units: dict[str, str]
    datasets: dict[str, Any]
    groups: tuple[str, ...] = ()


class OpenHdf5(OpenLog):
    """An open HDF5 log."""

    def __init__(self, columns: Columns, display_name: str, place: str) -> None:
        lengths = set(columns.lengths.values())
        self.columns, self.units = columns.names, columns.units
        self.uneven = len(lengths) > 1
        self.n_rows = lengths.pop() if len(lengths) == 1 else None
        self.display_name, self.place = display_name, place
        self._columns = columns

    def check(self, wanted: WantedColumns) -> None:
        """Raise an `InputError` for each wanted column that is not there."""
        hint = ""
        if not self.columns and self._columns.groups:
            listed = ", ".join(map(repr, self._columns.groups[:12]))
            hint = f"give the group that contains it: hdf5.group = one of {listed}"
        check_columns(wanted, self.columns, self.display_name, self.place, hint)

    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            For a damaged or cut off file, columns of unequal length or partly unwritten, a cell that is no finite
            number.
        """
        n_rows = _checked_length(self._columns, wanted, self.display_name)
        for start in range(0, n_rows, self.BATCH_ROWS):
            end = min(start + self.BATCH_ROWS, n_rows)
            yield batch_of_columns(self._columns.read, wanted, start, end, self.display_name)


@contextmanager
def open_log(path: Path, options: Options, display_name: str) -> Iterator[OpenHdf5]:
    """Open a log.

    Raises
    ------
    InputError
        For a damaged file, one that leads to others, a group or dataset that is not there.
    """
    with damaged_file_errors("HDF5 file", display_name, MEND), open_hdf5(path, display_name) as file:
        yield OpenHdf5(*_columns(file, options, display_name))


def tables(path: Path, display_name: str) -> list[Options]:
    """Return the options that choose each group, or dataset of two dimensions, that holds columns."""
    with damaged_file_errors("HDF5 file", display_name, MEND), open_hdf5(path, display_name) as file:
        found = [table for group in ("/", *_groups(file)) for table in _tables_of_group(file, group, display_name)]
    return found if len(found) > 1 else [{}]


def _tables_of_group(file: h5py.File, name: str, display_name: str) -> list[Options]:
    group = member_of(file, name)
    chosen = {} if name == "/" else {"group": name}
    if not isinstance(group, h5py.Group):
        return []
    try:
        if _columns_of_group(group, display_name).names:
            return [chosen]
    except InputError:  # a dataset whose columns have no names
        return []
    datasets = [name for name, item in members_of(group).items() if isinstance(item, h5py.Dataset) and item.ndim > 0]
    return [{**chosen, "dataset": name} for name in datasets]


def _columns(file: h5py.File, options: Options, display_name: str) -> tuple[Columns, str, str]:
    """Return the columns that the options point at, the file's name and the place of faults in them."""
    group_name = str(options.get("group") or "/")
    group = member_of(file, group_name)
    if group is None:
        near = nearest_name(group_name, _groups(file))
        raise InputError.at(FaultCode.LOG_PART_MISSING, display_name, "hdf5.group", f"no group {group_name!r}", near)
    dataset = options.get("dataset")
    if isinstance(group, h5py.Dataset):
        return _columns_of_dataset(group, display_name), display_name, group_name
    if dataset is None:
        if not options.get("group"):
            group = _sole_group(group)
            group_name = str(group.name)
        return _columns_of_group(group, display_name), display_name, f"group {group_name}"
    item = member_of(group, str(dataset))
    if not isinstance(item, h5py.Dataset):
        near = nearest_name(str(dataset), list(group))
        raise InputError.at(
            FaultCode.LOG_PART_MISSING,
            display_name,
            "hdf5.dataset",
            f"no dataset {dataset!r} in {group_name!r}",
            near,
        )
    return _columns_of_dataset(item, display_name), display_name, f"dataset {dataset}"


def _sole_group(group: h5py.Group) -> h5py.Group:
    """Return the group below that holds the datasets, where there is one group alone on the way to them."""
    for _ in range(MOST_LEVELS):
        members = list(members_of(group).values())
        if len(members) != 1 or not isinstance(members[0], h5py.Group):
            break
        group = members[0]
    return group


def _groups(file: h5py.File) -> list[str]:
    """Return the paths of a file's groups, each once; at most `MOST_LISTED` objects are looked at."""
    groups: list[str] = []
    n_visited = 0

    def note(name: str, item: Any) -> bool | None:
        nonlocal n_visited
        n_visited += 1
        if isinstance(item, h5py.Group):
            groups.append(f"/{name}")
        return True if n_visited >= MOST_LISTED else None

    file.visititems(note)
    return groups


def _columns_of_group(group: h5py.Group, display_name: str) -> Columns:
    members = members_of(group)
    datasets = {name: item for name, item in members.items() if isinstance(item, h5py.Dataset)}
    flat = {
        name: item
        for name, item in datasets.items()
        if item.dtype.names is None and (item.ndim == 1 or (item.ndim == 2 and item.shape[1] == 1))
    }
    tables = [item for name, item in datasets.items() if name not in flat and item.ndim > 0]
    if not flat and len(tables) == 1:
        return _columns_of_dataset(tables[0], display_name)

    readers = {name: by_chunk(partial(_rows_of, item), item, 0, item.shape[0]) for name, item in flat.items()}

    def read(name: str, start: int, end: int) -> NDArray[Any]:
        return readers[name](start, end)

    units = {name: unit for name, item in flat.items() if (unit := _unit(item))}
    lengths = {name: item.shape[0] for name, item in flat.items()}
    groups = tuple(str(item.name) for item in members.values() if isinstance(item, h5py.Group)) if not flat else ()
    return Columns(tuple(flat), read, lengths, units, flat, groups)


def _rows_of(dataset: Any, start: int, end: int) -> NDArray[Any]:
    return _rows(dataset, slice(start, end)).reshape(end - start)


def _rows(dataset: Any, which: Any) -> NDArray[Any]:
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
        value = dataset.attrs.get(attribute)
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
    for name in wanted.names:
        dataset = columns.datasets[name]
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
        return bool(dataset.size > 0 and dataset.id.get_storage_size() == 0)
    needed = int(np.prod([-(-size // chunk) for size, chunk in zip(dataset.shape, dataset.chunks, strict=True)]))
    return int(dataset.id.get_num_chunks()) < needed

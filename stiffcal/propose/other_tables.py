"""Tables of formats that name their columns themselves: workbooks, HDF5, Parquet, arrays, bags and the like."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from stiffcal.campaign.columns.column_headers import header_parts, is_unit
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.column_roles import holds_signals
from stiffcal.propose.recognising import recognise
from stiffcal.propose.table_sniffing import SniffedColumn, SniffedTable, column_of_times, sniff_table
from stiffcal.propose.unnamed_columns import are_numbered
from stiffcal.readers import Options, Reader, WantedColumns, find_reader

TEXT = "csv"
NO_OPTIONS: Options = MappingProxyType({})


def table_of(path: Path) -> SniffedTable:
    """Read the columns of a table of any format, with proposals for their units.

    Of several tables in one file that one is read whose columns alone are recognised.

    Raises
    ------
    InputError
        Not there, empty, damaged, no table, or one of several that are in the file.
    """
    reader = reader_of(path)
    if reader is None:
        return sniff_table(path)
    found = [table for table in tables_of(reader, path, path.name) if holds_signals(recognise(table.columns))]
    return found[0] if len(found) == 1 else other_table(reader, path, path.name)


def tables_of(reader: Reader, path: Path, display_name: str) -> list[SniffedTable]:
    """Read the columns of every table in a file; of several those that cannot be read are left out.

    Raises
    ------
    InputError
        Of a file with one table: as `other_table`, or as `sniff_table` where it is text.
    """
    tables = reader.tables(path, display_name)
    if len(tables) == 1:
        return [_table(reader, path, display_name, tables[0])]
    found = []
    for options in tables:
        with suppress(InputError):
            found.append(_table(reader, path, display_name, options))
    return found or [_table(reader, path, display_name, {})]  # which says why


def _table(reader: Reader, path: Path, display_name: str, options: Options) -> SniffedTable:
    if reader.name == TEXT:
        return sniff_table(path, str(options.get("section", "")))
    return other_table(reader, path, display_name, options)


def reader_of(path: Path) -> Reader | None:
    """Return the reader of a file that is no text, by its ending, else by its first bytes; None for all others."""
    try:
        reader = find_reader(path, display_name=path.name)
    except InputError:
        return None
    return None if reader.name == TEXT else reader


def other_table(reader: Reader, path: Path, display_name: str, options: Options = NO_OPTIONS) -> SniffedTable:
    """Return the columns that a table in a file names itself, with the first values of those that are used.

    Parameters
    ----------
    options : that choose the table; none where the file holds one.

    Raises
    ------
    InputError : the file is damaged, or holds no columns that can be found without an option.
    """
    header = reader.read_header(path, options, display_name)
    count = Counter(header.columns)
    own = [name for name in header.columns if name and count[name] == 1]
    named = tuple(SniffedColumn(name, *_name_and_unit(name, header.units), (math.nan,)) for name in own)
    if not named:
        reason, mend = "it has no columns at its top", f"state where they lie: {reader.name} = {{ … }}"
        raise InputError.at(FaultCode.LOG_PART_MISSING, display_name, "", reason, mend)
    # columns without names show what they are by their values alone
    unused = set() if are_numbered(own) else {column.header for column in recognise(named).unused}
    used = [column.header for column in named if column.header not in unused]
    first = reader.first_rows(path, options, used, display_name)
    columns = []
    for column in named:
        values = first.get(column.header)
        if isinstance(values, list):
            column = column_of_times(column.header, values) or replace(column, values=())
        elif values is not None:
            column = replace(column, values=tuple(values.tolist()))
        columns.append(column)
    understood = {**options, **header.options}
    stated = {key: value for key, value in understood.items() if isinstance(value, str | int | bool)}
    n_rows = header.n_rows if header.n_rows is not None else max(map(len, first.values()), default=0)
    repeated = tuple((name, f'{n} columns have the name "{name}"') for name, n in count.items() if name and n > 1)
    return SniffedTable(
        path,
        tuple(columns),
        n_rows,
        stated,
        reader.name,
        left_out=repeated,
        remarks=header.remarks,
        uneven=header.uneven,
    )


def rows_that_are_no_readings(table: SniffedTable, columns: Sequence[str]) -> tuple[int, ...]:
    """Return the data rows (from 1) of a table that is no text in which a cell of columns of numbers holds a word.

    Empty where nothing or another fault is found: reading the table states that.
    """
    reader = find_reader(table.path, table.log_format, table.path.name)
    try:
        next(iter(reader.read_batches(table.path, table.options, WantedColumns(tuple(columns)), table.path.name)), None)
    except InputError as error:
        return error.faults[0].rows
    return ()


def _name_and_unit(header: str, units: Mapping[str, str]) -> tuple[str, str | None]:
    """Return a column's name without its unit, and the unit that stands there or next to it."""
    parts = header_parts(header)
    if parts.unit is None or not is_unit(parts.unit):  # q[0] is an element, and 0 no unit
        return header, units.get(header)
    return parts.name, units.get(header) or parts.unit

"""Writing logs as instruments write them: text in many dialects, HDF5, Parquet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import InputError
from stiffcal.escapes import csv_cell
from stiffcal.fault_codes import FaultCode
from stiffcal.log_columns import single_character

Column = Floats | Sequence[str]

_DEFAULT_DECIMALS = 6
# Characters that no log holds, in place of what is exchanged last.
_CELL_END, _POINT_IN_WORDS = "\x1f", "\x1e"


@dataclass(frozen=True)
class Dialect:
    """How a text log is written."""

    delimiter: str = ","
    """The character between columns, as in the manifest."""
    decimal: str = "."
    """The decimal mark, as in the manifest."""
    encoding: str = "utf-8"
    """The encoding, as in the manifest."""
    preamble: tuple[str, ...] = ()
    """Lines before the column names."""
    units: Mapping[str, str] | None = None
    """Column name to unit, for a line of units after the names; None for no such line."""
    decimals: Mapping[str, int] = field(default_factory=dict)
    """Column name to decimals."""


def dialect_of(
    source: Source, preamble: Sequence[str], decimals: Mapping[str, int], units: Mapping[str, str], place: str
) -> Dialect:
    """Return the dialect that the manifest describes.

    Parameters
    ----------
    source : from the manifest.
    preamble : lines wanted before the names; their number must be the manifest's ``skip_rows``.
    decimals, units : by column name.
    place : how to call the source in a fault.

    Raises
    ------
    InputError
        the preamble has another number of lines than the manifest skips, or an option is not one character.
    """
    options = source.options_of("csv")
    skipped = options.get("skip_rows") or 0
    assert isinstance(skipped, int)
    lines = tuple(preamble) or tuple("simulated" for _ in range(skipped))
    if len(lines) != skipped:
        raise _wrong_preamble(place, len(lines), skipped)
    decimal = single_character(options, "decimal", MANIFEST_FILE) or "."
    return Dialect(
        delimiter=single_character(options, "delimiter", MANIFEST_FILE) or (";" if decimal == "," else ","),
        decimal=decimal,
        encoding=str(options.get("encoding") or "utf-8"),
        preamble=lines,
        units=units if options.get("unit_row") else None,
        decimals=decimals,
    )


def _wrong_preamble(place: str, n_lines: int, skipped: int) -> InputError:
    return InputError.at(
        FaultCode.KEY_CONFLICT,
        "simulate.toml",
        place,
        f"{n_lines} lines of preamble, where campaign.toml skips {skipped}",
        "make skip_rows in campaign.toml the same number",
    )


FORMATS = ("csv", "hdf5", "parquet")


def check_format(log_format: str, name: str) -> None:
    """Refuse a format that cannot be simulated.

    Raises
    ------
    InputError : it is none of `FORMATS`.
    """
    if log_format not in FORMATS:
        reason = f"logs of format {log_format} cannot be simulated"
        raise InputError.at(FaultCode.SIMULATION_UNSUPPORTED, "campaign.toml", name, reason, "use csv, hdf5 or parquet")


def write_log(path: Path, log_format: str, columns: Mapping[str, Column], dialect: Dialect, group: str = "/") -> None:
    """Write one log.

    Parameters
    ----------
    path : to write.
    log_format : one of `FORMATS`.
    columns : name to n numbers (or words), in the lab's units.
    dialect : how a text log is written.
    group : where in an HDF5 file the columns lie.
    """
    if log_format == "csv":
        _write_text(path, columns, dialect)
    elif log_format == "hdf5":
        _write_hdf5(path, columns, group)
    else:
        _write_parquet(path, columns)


def _write_text(path: Path, columns: Mapping[str, Column], dialect: Dialect) -> None:
    """Write delimited text; a whole row is formatted at once, which is what makes it fast."""
    names = list(columns)
    cells, values = [], []
    for name in names:
        column = columns[name]
        if isinstance(column, np.ndarray):
            cells.append(f"%.{dialect.decimals.get(name, _DEFAULT_DECIMALS)}f")
            values.append(column.tolist())
        else:
            cells.append("%s")
            values.append([_text_cell(word, dialect).replace(".", _POINT_IN_WORDS) for word in column])
    template = _CELL_END.join(cells)
    rows = [template % row for row in zip(*values, strict=True)]
    body = "\n".join(rows) + "\n"
    # Points that end a number's whole part become the decimal sign, those in words stay.
    for sign, written in ((".", dialect.decimal), (_POINT_IN_WORDS, "."), (_CELL_END, dialect.delimiter)):
        body = body.replace(sign, written)
    head = [*dialect.preamble, dialect.delimiter.join(_text_cell(name, dialect) for name in names)]
    if dialect.units is not None:
        head.append(dialect.delimiter.join(dialect.units.get(name, "") for name in names))
    text = "".join(line + "\n" for line in head) + body
    try:
        path.write_bytes(text.encode(dialect.encoding))
    except UnicodeEncodeError as error:
        reason = f"a name contains {error.object[error.start]!r}, which {dialect.encoding} does not have"
        raise InputError.at(
            FaultCode.ENCODING_WRONG, "campaign.toml", "csv.encoding", reason, 'set encoding = "utf-8"'
        ) from None


def _text_cell(text: str, dialect: Dialect) -> str:
    """Return a text as a cell, in quotation marks where it holds what ends one."""
    cell = csv_cell.escaped(text)
    return '"' + cell.replace('"', '""') + '"' if '"' in cell or dialect.delimiter in cell else cell


def _write_hdf5(path: Path, columns: Mapping[str, Column], group: str) -> None:
    import h5py

    with h5py.File(path, "w", libver="latest", track_order=True) as file:
        place = file.require_group(group)
        for name, column in columns.items():
            if isinstance(column, np.ndarray):
                place.create_dataset(name, data=column, compression="gzip", shuffle=True)
            else:
                place.create_dataset(name, data=list(column), dtype=h5py.string_dtype())


def _write_parquet(path: Path, columns: Mapping[str, Column]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table({name: pa.array(column) for name, column in columns.items()})
    pq.write_table(table, path, compression="zstd")

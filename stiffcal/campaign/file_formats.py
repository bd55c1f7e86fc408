"""The formats of log files: which a file's ending stands for, and what a manifest may say of each."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Annotated, ClassVar, Literal, TypeAlias

from pydantic import Field

from stiffcal.campaign.typed import Name, Table

Format: TypeAlias = Literal["csv", "hdf5", "parquet", "tdms", "mat", "mcap", "rosbag2", "postgres"]
_ENDINGS: dict[str, Format] = {
    ".csv": "csv",
    ".txt": "csv",
    ".tsv": "csv",
    ".dat": "csv",
    ".asc": "csv",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".hdf": "hdf5",
    ".parquet": "parquet",
    ".pq": "parquet",
    ".tdms": "tdms",
    ".mat": "mat",
    ".mcap": "mcap",
    ".db3": "rosbag2",
}
_PACKED = (".gz", ".bz2", ".xz", ".zst")


def format_of(file: str) -> Format | None:
    """Return the format that a file's ending stands for, None where it says nothing.

    Examples
    --------
    >>> format_of("raw/table.CSV"), format_of("raw/pose01.csv.gz")
    ('csv', 'csv')
    """
    path = PurePosixPath(file)
    if path.suffix.lower() in _PACKED:  # text alone is read packed: a table or a tree of columns is not
        inner = _ENDINGS.get(PurePosixPath(path.stem).suffix.lower())
        return inner if inner == "csv" else None
    return _ENDINGS.get(path.suffix.lower())


class CsvOptions(Table):
    """How a text file is written.

    Attributes
    ----------
    delimiter : a single character or "tab"; recognised where left out. decimal : "." where left out.
    encoding : Python's name of it; UTF-8 where left out. skip_rows : lines before the header.
    unit_row : True where the line after the header holds units; recognised where left out.
    """

    delimiter: Name | None = None
    decimal: Literal[".", ","] | None = None
    encoding: Name | None = None
    skip_rows: Annotated[int, Field(ge=0)] | None = None
    unit_row: bool | None = None

    look_alikes: ClassVar[dict[str, str]] = {
        "sep": "delimiter", "separator": "delimiter", "skiprows": "skip_rows", "header": "skip_rows",
        "header_lines": "skip_rows", "units_row": "unit_row",
    }  # fmt: skip


class Hdf5Options(Table):
    """Where in an HDF5 file the columns lie.

    Attributes
    ----------
    group : the group that holds them. dataset : one dataset in it that holds all columns; recognised where left out.
    """

    group: Name = "/"
    dataset: Name | None = None


class ParquetOptions(Table):
    """Nothing to say yet: a Parquet file carries names and types itself."""


class TdmsOptions(Table):
    """Where in a TDMS file the channels lie: the group; may be left out where only one group has any."""

    group: Name | None = None


class MatOptions(Table):
    """Where in a MAT file the columns lie.

    Attributes
    ----------
    variable : the struct whose fields they are, or the matrix that holds them (``log.ft``); absent: the file itself.
    columns : the names of a matrix's columns.
    """

    variable: Name | None = None
    columns: Annotated[list[Name] | None, Field(min_length=1)] = None


class RosOptions(Table):
    """Which messages of a ROS 2 bag or MCAP file are read; its columns are fields: ``wrench.force.x``, ``position.A1``.

    Attributes
    ----------
    topic : may be left out where the bag has only one. child_frame : of transforms, the frame that was tracked.
    types : the ROS release (``ros2_humble``) whose messages they are, where the bag does not define them itself.
    """

    topic: Name | None = None
    child_frame: Name | None = None
    types: Name | None = None


class PostgresOptions(Table):
    """How a PostgreSQL database is reached; which table or query is read, `file` says. No password stands here.

    The user allows databases by environment, ``STIFFCAL_POSTGRES_ENV`` and ``STIFFCAL_POSTGRES``, and trusts queries.

    Attributes
    ----------
    uri_env : the environment variable that holds the address (``postgresql://…``), its password included if need be.
    host, port, database, user : instead of it; the password comes from PGPASSWORD or from ~/.pgpass.
    order_by : the column, or columns, that put a table's rows into order.
    """

    uri_env: Name | None = None
    host: Name | None = None
    port: Annotated[int, Field(gt=0, lt=65536)] | None = None
    database: Name | None = None
    user: Name | None = None
    order_by: Name | None = None

    look_alikes: ClassVar[dict[str, str]] = {
        "db": "database", "dbname": "database", "uri": "uri_env", "url": "uri_env", "dsn": "uri_env",
        "password": "uri_env", "username": "user", "order": "order_by",
    }  # fmt: skip

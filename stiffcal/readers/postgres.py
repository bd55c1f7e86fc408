"""Tables and queries of a PostgreSQL database, TimescaleDB included, streamed. Needs the extra ``postgres`` (ADBC).

What is read, the manifest says under `file`: a table (``daq.ft``) or a query (``select … order by t``). Options
(``postgres = {…}``):

uri_env : the environment variable that holds the address, ``postgresql://user@host/database``.
host, port, database, user : instead of it. What is left out comes from libpq's own PGHOST, PGDATABASE, … and the
    password from PGPASSWORD or ~/.pgpass: there is no option for it, and it is never written or shown.
order_by : the columns that put the rows of a table into order; a table has none of its own.

Rows come over in the server's binary form in batches of bounded size, in one read-only transaction.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.measurements.columns import values_of
from stiffcal.readers import (
    Batch,
    Header,
    Options,
    Wanted,
    batch_of_columns,
    check_columns,
    check_options,
    missing_library,
    nearest_name,
)

BATCH_BYTES = 4 << 20
BATCH_ROWS = 1 << 16
PATIENCE_S = 20
# `from` is the manifest's `file`.
KNOWN_OPTIONS: dict[str, type] = {
    "uri_env": str, "host": str, "port": int, "database": str, "user": str, "order_by": str, "from": str,
}  # fmt: skip


class PostgresReader:
    """Reads a table or query of a PostgreSQL database in batches of rows; the paths it is given mean nothing."""

    name = "postgres"

    def recognises(self, path: Path) -> bool:
        """Return False: a database is no file."""
        return False

    def read_header(self, path: Path, options: Options, shown: str = "", wanted: Wanted | None = None) -> Header:
        """Return the columns of the table or query."""
        with _connected(options) as (cursor, what):
            columns = _columns(cursor, what)
            if wanted is not None:
                check_columns(wanted, columns, what.shown, "")
            return Header(columns)

    def read_batches(self, path: Path, options: Options, wanted: Wanted, shown: str = "") -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            Where the database cannot be reached, the table or a column is not there, rows have no order, a cell is
            empty or no finite number.
        """
        with _connected(options) as (cursor, what):
            columns = _columns(cursor, what)
            check_columns(wanted, columns, what.shown, "")
            row = 0
            cursor.execute(what.statement(wanted.names, columns))
            for records in cursor.fetch_record_batch():
                for start in range(0, records.num_rows, BATCH_ROWS):
                    piece = records.slice(start, BATCH_ROWS)
                    yield _batch(piece, wanted, row, what.shown)
                    row += piece.num_rows
            if row == 0:
                raise InputError.at(what.shown, "", "there are no rows", "correct the table's name or the query")

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``row n``."""
        return f"row {row}"

    def fingerprint(self, options: Options) -> tuple[int, str]:
        """Return the number of rows and a digest of all of them, computed by the server."""
        with _connected(options) as (cursor, what):
            _columns(cursor, what)
            digest = "coalesce(sum(hashtextextended(rows::text, 0)::numeric), 0)::text"
            cursor.execute(f"select count(*), {digest} from ({what.inner}\n) as rows")
            count, told = cursor.fetchone()
            return int(count), f"{what.inner} {count} {told}"


READER = PostgresReader()


class _What:
    """What is read: a table or a query.

    Attributes
    ----------
    inner : its SQL. shown : how messages call it.
    """

    def __init__(self, options: Options) -> None:
        text = str(options.get("from") or "").strip().rstrip(";").strip()
        if not text:
            raise InputError.at("campaign.toml", "file", "no table or query is named", 'add file = "schema.table"')
        self.is_query = re.match(r"(select|with|table|values)\s", text, re.IGNORECASE) is not None
        self.order_by = [name.strip() for name in str(options.get("order_by") or "").split(",") if name.strip()]
        self.inner = text if self.is_query else f"select * from {_table(text)}"
        words = " ".join(text.split())
        self.shown = f"query {words[:60]}{'…' if len(words) > 60 else ''}" if self.is_query else f"table {text}"

    def statement(self, names: tuple[str, ...], columns: tuple[str, ...]) -> str:
        """Return the SQL that reads these columns in order; raises `InputError` where there is none."""
        for name in self.order_by:
            if name not in columns:
                raise InputError.at(self.shown, "postgres.order_by", f"no column {name!r}", nearest_name(name, columns))
        if self.order_by:
            order = ", ".join(_quoted(name) for name in self.order_by)
            return f"select {', '.join(_quoted(name) for name in names)} from ({self.inner}\n) as rows order by {order}"
        if self.is_query and re.search(r"\border\s+by\b", self.inner, re.IGNORECASE):
            return self.inner
        mend = 'add postgres.order_by = "…", the column of the time' + (", or order by …" if self.is_query else "")
        raise InputError.at(self.shown, "", "its rows have no order", mend)


def _table(text: str) -> str:
    parts = re.findall(r'"(?:[^"]|"")+"|[^".]+', text)
    return ".".join(part if part.startswith('"') else _quoted(part.strip()) for part in parts)


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


@contextmanager
def _connected(options: Options) -> Iterator[tuple[Any, _What]]:
    """Open a read-only transaction; what the server refuses becomes one line without the password."""
    what = _What(options)
    check_options(options, KNOWN_OPTIONS, "postgres", what.shown)
    try:
        from adbc_driver_postgresql import StatementOptions, dbapi
    except ImportError:
        raise missing_library("postgres", what.shown) from None
    address = _address(options, what.shown)
    try:
        connection = dbapi.connect(address)
    except dbapi.Error as error:
        reason = f"the database cannot be reached ({_told(error, address)})"
        mend = "correct postgres.host, .port, .database, .user or the variable of postgres.uri_env, or start the server"
        raise InputError.at(what.shown, "postgres", reason, mend) from None
    hint = {StatementOptions.BATCH_SIZE_HINT_BYTES.value: str(BATCH_BYTES)}
    with connection, connection.cursor(adbc_stmt_kwargs=hint) as cursor:
        try:
            cursor.execute("set transaction read only")
            yield cursor, what
        except (dbapi.Error, pa.ArrowException, OSError) as error:
            told = _told(error, address)
            mend = "correct the table's name or the query"
            with suppress(dbapi.Error, pa.ArrowException, OSError):
                mend = _near_table(connection, told) or mend
            raise InputError.at(what.shown, "", f"the database refused ({told})", mend) from None


def _near_table(connection: Any, told: str) -> str:
    """Return the nearest table's name where the server says that there is none of this name."""
    found = re.search(r'relation "(.*)" does not exist', told)
    if found is None:
        return ""
    connection.rollback()
    with connection.cursor() as cursor:
        cursor.execute(
            "select table_schema::text, table_name::text from information_schema.tables"
            " where table_schema not in ('pg_catalog', 'information_schema') order by 1, 2"
        )
        rows = cursor.fetchall()
    names = [table if schema == "public" else f"{schema}.{table}" for schema, table in rows]
    near = nearest_name(found[1], names).replace("the file has columns", "the database has tables")
    return near.replace("the file has no columns", "the database has no tables").replace("the file has", "tables:")


def _address(options: Options, shown: str) -> str:
    variable = options.get("uri_env")
    parts = {"host": options.get("host"), "port": options.get("port"), "dbname": options.get("database"),
             "user": options.get("user")}  # fmt: skip
    if variable is not None:
        if any(value is not None for value in parts.values()):
            place, mend = "postgres.uri_env", "keep one: the variable, or host, port, database, user"
            raise InputError.at(shown, place, "the address is given twice", mend)
        address = os.environ.get(str(variable), "")
        if not address:
            mend = f"export {variable}=postgresql://USER@HOST/DATABASE"
            raise InputError.at(shown, "postgres.uri_env", f"the environment variable {variable} is not set", mend)
        for key, value in _patience().items():
            if key not in address:
                joint = " " if "://" not in address else "&" if "?" in address else "?"
                address += f"{joint}{key}={value}"
        return address
    said = {key: str(value) for key, value in parts.items() if value is not None}
    said |= _patience()
    quoted = {key: value.replace("\\", "\\\\").replace("'", "\\'") for key, value in said.items()}
    return " ".join(f"{key}='{value}'" for key, value in quoted.items())


def _patience() -> dict[str, str]:
    """Return how long a server may not answer: a line that is dead would else be waited at for hours."""
    first = {} if "PGCONNECT_TIMEOUT" in os.environ else {"connect_timeout": str(PATIENCE_S)}
    return {**first, "keepalives_idle": "30", "keepalives_interval": "10", "keepalives_count": "3"}


def _told(error: Exception, address: str) -> str:
    """Return what the server says, on one line, without the address and its password."""
    told = " ".join(str(error).split())
    secrets = [address, os.environ.get("PGPASSWORD", "")]
    secrets += re.findall(r"(?:password\s*=\s*'?|://[^:/@\s]*:)([^'@\s&]+)", address)
    with suppress(ValueError):
        secrets.append(urlsplit(address).password or "")
    for secret in sorted({*secrets, *(unquote(secret) for secret in secrets)}, key=len, reverse=True):
        told = told.replace(secret, "…") if secret else told
    found = re.search(r"(?:ERROR|FATAL): .*?(?= LINE \d| Query was|$)", told)
    return (found.group() if found else told)[:300]


def _columns(cursor: Any, what: _What) -> tuple[str, ...]:
    schema = cursor.adbc_execute_schema(f"select * from ({what.inner}\n) as rows limit 0")
    return tuple(schema.names)


def _batch(records: pa.RecordBatch, wanted: Wanted, first: int, shown: str) -> Batch:
    arrays = {name: _array(records.column(name), name, wanted, first, shown) for name in wanted.names}
    return batch_of_columns(lambda name, a, b: arrays[name], wanted, first, first + records.num_rows, shown)


def _array(column: pa.Array, name: str, wanted: Wanted, first: int, shown: str) -> NDArray[Any]:
    if isinstance(column, pa.ExtensionArray):
        column = column.storage
    if column.null_count and name not in wanted.gaps:
        row = first + 1 + next(index for index, value in enumerate(column) if not value.is_valid)
        mend = "give the value, or leave the row out: where … is not null"
        raise InputError.at(shown, f"row {row}, column {name}", "the cell is empty (NULL)", mend)
    kind = column.type
    if name in wanted.numbers and (pa.types.is_string(kind) or pa.types.is_decimal(kind) or pa.types.is_integer(kind)):
        # `numeric` comes as text, so that no digit is lost.
        try:
            column = column.cast(pa.float64())
        except pa.ArrowInvalid:
            reason = "it holds words, not numbers"
            raise InputError.at(shown, f"column {name}", reason, "name a column of numbers") from None
    elif pa.types.is_date(kind):
        column = column.cast(pa.timestamp("s"))
    elif pa.types.is_null(kind):
        column = column.cast(pa.float64())
    if pa.types.is_timestamp(column.type):
        return values_of(column.cast(pa.int64())).astype(f"datetime64[{column.type.unit}]")
    if pa.types.is_string(column.type) or pa.types.is_large_string(column.type):
        return np.array([value.as_py() for value in column], dtype=object)
    if not (pa.types.is_floating(column.type) or pa.types.is_integer(column.type) or pa.types.is_boolean(column.type)):
        reason = f"it holds {kind}, neither numbers nor words nor times"
        mend = "name another column, or turn it into one of these in a query, e.g. extract(epoch from …)"
        raise InputError.at(shown, f"column {name}", reason, mend)
    if column.null_count:  # of a column that may have gaps
        column = column.cast(pa.float64()).fill_null(float("nan"))
    return values_of(column)

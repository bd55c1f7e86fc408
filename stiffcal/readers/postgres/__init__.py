"""Tables and queries of a PostgreSQL database, TimescaleDB included, streamed. Needs the extra ``postgres`` (ADBC).

What is read, the manifest states under `file`: a table (``daq.ft``) or a query (``select … order by t``). Options
(``postgres = {…}``):

uri_env : the environment variable that holds the address, ``postgresql://user@host/database``.
host, port, database, user : instead of it. What is left out comes from libpq's own PGHOST, PGDATABASE, … and the
    password from PGPASSWORD or ~/.pgpass: there is no option for it, and it is never written or shown.
    Both only where the user allows them, see `address`; a query, only where the user has trusted its text.
order_by : the columns that put the rows of a table into order; a table has none of its own.

Rows come over in the server's binary form in batches of bounded size, in one read-only transaction whose statements
end after half an hour (``STIFFCAL_POSTGRES_STATEMENT_S``).
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pydantic import Field

from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.columns import values_of
from stiffcal.readers import (
    Batch,
    DatabaseReader,
    Header,
    Options,
    WantedColumns,
    batch_of_columns,
    check_columns,
    check_options,
    missing_library,
    nearest_name,
)
from stiffcal.readers.postgres.address import Address, address_of
from stiffcal.trust.queries import query_digest, query_text, table_of
from stiffcal.trust.record import open_record

BATCH_BYTES = 4 << 20
BATCH_ROWS = 1 << 16
STATEMENT_S, LONGEST_S = "STIFFCAL_POSTGRES_STATEMENT_S", 1800
"""The variable that sets how long a statement may take, s, and what holds without it."""
_FILE = {"from": str}  # the option as which the manifest's `file` comes here
_CANCELLED, _NO_TABLE = "57014", "42P01"  # SQLSTATE query_canceled and undefined_table


class PostgresOptions(TomlTable):
    """How a PostgreSQL database is reached; which table or query is read, `file` states. No password stands here.

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


class PostgresReader(DatabaseReader):
    """Reads a table or query of a PostgreSQL database in batches of rows; the paths it is given mean nothing."""

    name = "postgres"
    options = PostgresOptions

    def recognises(self, path: Path) -> bool:
        """Return False: a database is no file."""
        return False

    def read_header(
        self, path: Path, options: Options, display_name: str = "", wanted: WantedColumns | None = None
    ) -> Header:
        """Return the columns of the table or query."""
        with _connected(options) as (cursor, source):
            columns = _columns(cursor, source)
            if wanted is not None:
                check_columns(wanted, columns, source.display_name, "")
            return Header(columns)

    def read_batches(
        self, path: Path, options: Options, wanted: WantedColumns, display_name: str = ""
    ) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            Where the database cannot be reached, the table or a column is not there, rows have no order, a cell is
            empty or no finite number.
        """
        with _connected(options) as (cursor, source):
            columns = _columns(cursor, source)
            check_columns(wanted, columns, source.display_name, "")
            row = 0
            cursor.execute(source.statement(wanted.names, columns))
            for records in cursor.fetch_record_batch():
                for start in range(0, records.num_rows, BATCH_ROWS):
                    piece = records.slice(start, BATCH_ROWS)
                    yield _batch(piece, wanted, row, source.display_name)
                    row += piece.num_rows
            if row == 0:
                raise InputError.at(
                    FaultCode.FILE_EMPTY,
                    source.display_name,
                    "",
                    "there are no rows",
                    "correct the table's name or the query",
                )

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``row n``."""
        return f"row {row}"

    def fingerprint(self, options: Options) -> tuple[int, str]:
        """Return the number of rows and a digest of all of them, computed by the server."""
        with _connected(options) as (cursor, source):
            _columns(cursor, source)
            digest = "coalesce(sum(hashtextextended(rows::text, 0)::numeric), 0)::text"
            cursor.execute(f"select count(*), {digest} from ({source.inner}\n) as rows")
            count, digest_value = cursor.fetchone()
            return int(count), f"{source.inner} {count} {digest_value}"


READER = PostgresReader()


class _What:
    """What is read: a table or a query.

    Attributes
    ----------
    inner : its SQL. display_name : how messages call it. table : the parts of the table's name, None of a query.
    """

    def __init__(self, options: Options) -> None:
        text = query_text(str(options.get("from") or ""))
        if not text:
            raise InputError.at(
                FaultCode.KEY_MISSING,
                "campaign.toml",
                "file",
                "no table or query is given",
                'add file = "schema.table"',
            )
        self.table = table_of(text)
        self.order_by = [name.strip() for name in str(options.get("order_by") or "").split(",") if name.strip()]
        self.inner = text if self.table is None else f"select * from {'.'.join(map(_quoted, self.table))}"
        words = " ".join(text.split())
        self.display_name = f"table {text}" if self.table else f"query {words[:60]}{'…' if len(words) > 60 else ''}"

    def check_trusted(self) -> None:
        """Raise an `InputError` where this is a query that the user has not allowed."""
        digest = query_digest(self.inner)
        if self.table is None and not open_record().text_allowed(digest):
            reason = f"a query runs on your database with your rights, and this one is not allowed ({digest})"
            mend = "read it and allow it: stiffcal trust DIR; or give a table only: schema.table"
            raise InputError.at(FaultCode.QUERY_UNTRUSTED, self.display_name, "", reason, mend)

    def statement(self, names: tuple[str, ...], columns: tuple[str, ...]) -> str:
        """Return the SQL that reads these columns in order; raises `InputError` where there is none."""
        for name in self.order_by:
            if name not in columns:
                raise InputError.at(
                    FaultCode.COLUMN_MISSING,
                    self.display_name,
                    "postgres.order_by",
                    f"no column {name!r}",
                    nearest_name(name, columns),
                )
        if self.order_by:
            order = ", ".join(_quoted(name) for name in self.order_by)
            return f"select {', '.join(_quoted(name) for name in names)} from ({self.inner}\n) as rows order by {order}"
        if self.table is None and re.search(r"\border\s+by\b", self.inner, re.IGNORECASE):
            return self.inner
        mend = 'add postgres.order_by = "…", the column of the time' + (", or order by …" if self.table is None else "")
        raise InputError.at(
            FaultCode.OPTION_MISSING, self.display_name, "", "the order of its rows is not defined", mend
        )


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


@contextmanager
def _connected(options: Options) -> Iterator[tuple[Any, _What]]:
    """Open a read-only transaction; what the server refuses becomes one line without the password."""
    source = _What(options)
    check_options(options, PostgresOptions, "postgres", source.display_name, _FILE)
    try:
        from adbc_driver_postgresql import StatementOptions, dbapi
    except ImportError:
        raise missing_library("postgres", source.display_name) from None
    source.check_trusted()
    address, most_s = address_of(options, source.display_name), _longest_statement_s()
    try:
        connection = dbapi.connect(address.text)
    except dbapi.Error as error:
        reason = f"the database cannot be reached ({_server_message(error, address)})"
        mend = "correct postgres.host, .port, .database, .user or the variable of postgres.uri_env, or start the server"
        raise InputError.at(FaultCode.DATABASE_UNREACHABLE, source.display_name, "postgres", reason, mend) from None
    hint = {StatementOptions.BATCH_SIZE_HINT_BYTES.value: str(BATCH_BYTES)}
    began = time.monotonic()
    with connection, connection.cursor(adbc_stmt_kwargs=hint) as cursor:
        try:
            cursor.execute("set transaction read only")
            cursor.execute(f"set local statement_timeout = '{most_s}s'")
            yield cursor, source
        except (dbapi.Error, pa.ArrowException, OSError) as error:
            state = getattr(error, "sqlstate", None)  # what fails half-way through the rows carries none
            mend = "correct the table's name or the query"
            if state == _CANCELLED or (state is None and time.monotonic() - began >= most_s):
                mend = f"select fewer rows, or raise {STATEMENT_S}, which is {most_s} s now"
            elif state == _NO_TABLE:
                with suppress(dbapi.Error, pa.ArrowException, OSError):
                    mend = _near_table(connection, str(error), source) or mend
            raise InputError.at(
                FaultCode.DATABASE_UNREACHABLE,
                source.display_name,
                "",
                f"the database refused ({_server_message(error, address)})",
                mend,
            ) from None


def _longest_statement_s() -> int:
    text = os.environ.get(STATEMENT_S, "").strip() or str(LONGEST_S)
    if not re.fullmatch(r"[1-9]\d{0,5}", text):
        mend = f"write a whole number of seconds, as in {STATEMENT_S}={LONGEST_S}"
        raise InputError.at(FaultCode.OPTION_INVALID, "", STATEMENT_S, f"{text!r} is not a time in seconds", mend)
    return int(text)


def _near_table(connection: Any, servers_words: str, source: _What) -> str:
    """Return the nearest name of a table in the database, where there is one."""
    relation = re.search(r'relation "(.*)" does not exist', servers_words)
    table_name = ".".join(source.table) if source.table else relation[1] if relation else None
    if table_name is None:
        return ""
    connection.rollback()
    with connection.cursor() as cursor:
        cursor.execute(
            "select table_schema::text, table_name::text from information_schema.tables"
            " where table_schema not in ('pg_catalog', 'information_schema') order by 1, 2"
        )
        rows = cursor.fetchall()
    names = [table if schema == "public" else f"{schema}.{table}" for schema, table in rows]
    return nearest_name(table_name, names, "tables:") if names else "the database has no tables"


def _server_message(error: Exception, address: Address) -> str:
    """Return the server's message, on one line, without the address's secrets."""
    servers_words = address.without_secrets(" ".join(str(error).split()))
    first_error = re.search(r"(?:ERROR|FATAL): .*?(?= LINE \d| Query was|$)", servers_words)
    return (first_error.group() if first_error else servers_words)[:300]


def _columns(cursor: Any, source: _What) -> tuple[str, ...]:
    schema = cursor.adbc_execute_schema(f"select * from ({source.inner}\n) as rows limit 0")
    return tuple(schema.names)


def _batch(records: pa.RecordBatch, wanted: WantedColumns, first: int, display_name: str) -> Batch:
    arrays = {name: _array(records.column(name), name, wanted, first, display_name) for name in wanted.names}
    return batch_of_columns(lambda name, a, b: arrays[name], wanted, first, first + records.num_rows, display_name)


def _array(column: pa.Array, name: str, wanted: WantedColumns, first: int, display_name: str) -> NDArray[Any]:
    if isinstance(column, pa.ExtensionArray):
        column = column.storage
    if column.null_count and name not in wanted.gaps:
        row = first + 1 + next(index for index, value in enumerate(column) if not value.is_valid)
        mend = "give the value, or exclude the row: where … is not null"
        raise InputError.at(
            FaultCode.CELL_EMPTY, display_name, f"row {row}, column {name}", "the cell is empty (NULL)", mend
        )
    kind = column.type
    if name in wanted.numbers and (pa.types.is_string(kind) or pa.types.is_decimal(kind) or pa.types.is_integer(kind)):
        # `numeric` comes as text, so that no digit is lost.
        try:
            column = column.cast(pa.float64())
        except pa.ArrowInvalid:
            reason = "it contains words, not numbers"
            raise InputError.at(
                FaultCode.COLUMN_TYPE, display_name, f"column {name}", reason, "use a column of numbers"
            ) from None
    elif pa.types.is_date(kind):
        column = column.cast(pa.timestamp("s"))
    elif pa.types.is_null(kind):
        column = column.cast(pa.float64())
    if pa.types.is_timestamp(column.type):
        return values_of(column.cast(pa.int64())).astype(f"datetime64[{column.type.unit}]")
    if pa.types.is_string(column.type) or pa.types.is_large_string(column.type):
        return np.array([value.as_py() for value in column], dtype=object)
    if not (pa.types.is_floating(column.type) or pa.types.is_integer(column.type) or pa.types.is_boolean(column.type)):
        reason = f"it contains {kind}, neither numbers nor words nor times"
        mend = "use another column, or convert it in a query, e.g. extract(epoch from …)"
        raise InputError.at(FaultCode.COLUMN_TYPE, display_name, f"column {name}", reason, mend)
    if column.null_count:  # of a column that may have gaps
        column = column.cast(pa.float64()).fill_null(float("nan"))
    return values_of(column)

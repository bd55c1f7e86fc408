"""Odd columns, spoilt queries, options and addresses for a PostgreSQL server, and a line that spoils its answers."""

from __future__ import annotations

import os
import random
import select
import socket
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from unittest import mock
from urllib.parse import parse_qs, urlsplit

from tests.fuzz.mutations import NASTY_TEXTS, spoilt_bytes
from tests.laboratory.database import VARIABLE, VARIABLES, trusting

SPOILT = "STIFFCAL_FUZZ_DATABASE"
IDLE_S = 0.3  # neither side speaks: what was cut out would be waited for without end, so the line is cut
SENSIBLE = ("k * 0.01", "sin(k)", "k", "k::real", "k::numeric(12, 3)", "'pose' || k / 20")
ODD = (
    "null", "nullif(k, 7)", "null::float8", "'nan'::float8", "'infinity'::float4", "'nan'::numeric", "''", "'x'",
    "'infinity'::numeric", "10::numeric ^ 400", "repeat('9', 1000)::numeric", "9223372036854775807",
    "1e308 * k / k", "k > 3", "k::smallint", "k::oid", "'a'::\"char\"", "'a'::char(9)", "'n'::name",
    "'{1,2}'::float8[]", "'{{1}}'::int[]", "array[null, k]", "'{}'::text[]", "row(k, 'x')",
    "json_build_object('k', k)", "'{\"a\": 1}'::jsonb", "'\\x00ff'::bytea", "now()", "now()::timestamp",
    "'infinity'::timestamptz", "'-infinity'::date", "'4713-01-01 BC'::timestamptz", "now()::date",
    "'2026-11-21T08:15:30Z'", "'294276-12-31'::timestamp", "'12:00'::time", "'12:00+02'::timetz",
    "'1 month'::interval", "gen_random_uuid()", "'1.5'::money", "'10.0.0.1'::inet", "b'101'", "'(1,2)'::point",
    "'[1,5)'::int4range", "to_tsvector('a b')", "'pg_class'::regclass", "repeat('w', 3000)", "1 / (k - 30)",
    "sqrt(10 - k)", "pg_typeof(k)", "chr(k + 160)", "e'a\\nb'", "current_user", "txid_current_snapshot()",
    "'<a/>'::text", "pg_sleep(0)", "random()",
)  # fmt: skip
TEXTS = (
    "pg_class", "pg_catalog.pg_attribute", "pg_stats", "nowhere", "a.b.c.d", '"', '"a"b', "public.", ".",
    "information_schema.tables", "select", "select 1", "select 1 order by 1", "select order by",
    "values (1), (2) order by 1", "table pg_class order by oid",
    "select 1 as t order by t) to program 'false' --", "select 1 as t order by t; drop table pg_class",
    "select $1 as t order by t", "with t as (select 1 as t) select * from t order by t",
    "select set_config('x.y', 'z', false) as t order by t", "select 1 as t order by t /*",
    "select 1 as t order by t --", "select * from generate_series(1, 5) as t(t) order by t",
    "select pg_terminate_backend(pg_backend_pid()) as t order by t", "select from pg_class order by oid",
    "set transaction read write", "select 1 as t, 2 as t order by 1", 'select 1 as "" order by 1', "commit",
    "listen x", "copy pg_class to stdout", "explain select 1",
)  # fmt: skip
ADDRESSES = (
    "", "x", "postgresql://", "postgresql://127.0.0.1:1/x", "host=127.0.0.1 port=1", "host=/nowhere", "port=x", "= =",
    "'", "\\", "postgresql://[::1", "postgresql://u:p%zz@127.0.0.1:1", "service=none", "a" * 9999,
    "sslmode=verify-full host=127.0.0.1 port=1",
)  # fmt: skip


def odd_query(chance: random.Random) -> str:
    """Return a query of the columns t, Fx, Fy, run, some of them of odd types or failing half-way."""
    odd = chance.random()
    columns = [
        f'{chance.choice(ODD) if chance.random() < odd * 0.5 else sensible} as "{name}"'
        for name, sensible in zip(
            ("t", "Fx", "Fy", "run"), (SENSIBLE[0], chance.choice(SENSIBLE[1:5]), "k", SENSIBLE[5]), strict=True
        )
    ]
    if chance.random() < 0.1:
        columns[chance.randrange(4)] = chance.choice(('k as "Fx"', 'k as "ä"', "k", "*", '1 as "a\'b"'))
    rows = chance.choice((0, 1, 60, 60, 60, 3000))
    return f"select {', '.join(columns)} from generate_series(1, {rows}) as s(k) order by s.k"


def spoilt_options(chance: random.Random, folder: Path) -> dict[str, object]:
    """Return options of the manifest: mostly a query of odd columns, else spoilt text, options or an address."""
    found: dict[str, object] = {"uri_env": VARIABLE, "from": odd_query(chance)}
    match chance.randrange(10):
        case 0 | 1:
            text = chance.choice((*TEXTS, str(found["from"])))
            if chance.random() < 0.7:
                text = spoilt_bytes(chance, text.encode()).decode("latin-1")
            found["from"] = text
            if chance.random() < 0.4:
                found["order_by"] = chance.choice(("t", "oid", "relname, oid", "no", '"', "t desc", "", "t, t"))
        case 2:
            key = chance.choice(("order_by", "uri_env", "database", "user", "port", "from", "passwort"))
            found[key] = chance.choice((*NASTY_TEXTS, 5, -1, 10**9, True, 1.5, None, ["t"]))
            if key in ("database", "user", "port"):
                found |= {"uri_env": None, "host": chance.choice(("127.0.0.1", str(folder), "/nowhere", "a\nb"))}
        case 3:
            os.environ["STIFFCAL_FUZZ_ADDRESS"] = chance.choice(ADDRESSES)
            found["uri_env"] = "STIFFCAL_FUZZ_ADDRESS"
    return found


@contextmanager
def allowing(folder: Path, options: Mapping[str, object]) -> Iterator[None]:
    """Allow what such options ask for, so that the server and libpq come to see it."""
    further = {
        VARIABLES: f"{VARIABLE} {SPOILT} STIFFCAL_FUZZ_ADDRESS",
        "STIFFCAL_POSTGRES": f"127.0.0.1/* {folder}/* /nowhere/*",
    }
    with mock.patch.dict(os.environ, further), trusting(str(options.get("from") or "")):
        yield


@contextmanager
def spoiling_line(chance: random.Random, folder: Path) -> Iterator[None]:
    """Let the server be reached over a line that changes, cuts or doubles some bytes of its answers."""
    path = folder / ".s.PGSQL.5432"
    path.unlink(missing_ok=True)
    stop = threading.Event()
    with socket.socket(socket.AF_UNIX) as door:
        door.bind(str(path))
        door.listen(4)
        door.settimeout(0.05)
        thread = threading.Thread(target=_relay, args=(door, random.Random(chance.random()), stop), daemon=True)
        thread.start()
        user = urlsplit(os.environ[VARIABLE]).username or ""
        os.environ[SPOILT] = f"host={folder} user={user} dbname=postgres sslmode=disable"
        try:
            yield
        finally:
            stop.set()
            thread.join()


def _relay(door: socket.socket, chance: random.Random, stop: threading.Event) -> None:
    folder = parse_qs(urlsplit(os.environ[VARIABLE]).query)["host"][0]
    while not stop.is_set():
        with suppress(OSError):
            client, _ = door.accept()
            with client, socket.socket(socket.AF_UNIX) as server:
                server.connect(f"{folder}/.s.PGSQL.5432")
                _pass_on(client, server, chance, stop)


def _pass_on(client: socket.socket, server: socket.socket, chance: random.Random, stop: threading.Event) -> None:
    """Pass bytes on, the server's spoilt from some point on, until one side ends or both are silent."""
    left = chance.choice((0, 100, 400, 1000, 3000, 20_000))
    spoilt = False
    while not stop.is_set():
        ready, _, _ = select.select([client, server], [], [], IDLE_S)
        if not ready and spoilt:
            return
        for side in ready:
            data = side.recv(1 << 16)
            if not data:
                return
            if side is client:
                server.sendall(data)
                continue
            left -= len(data)
            if left <= 0 and chance.random() < 0.5:
                data, spoilt = spoilt_bytes(chance, data), True
            client.sendall(data)


def wanted_of_database(chance: random.Random) -> Any:
    """Return the columns that are asked for."""
    from stiffcal.readers import WantedColumns

    return chance.choice(
        (
            WantedColumns(("t", "Fx", "Fy")),
            WantedColumns(("t", "Fx", "Fy"), ("run",)),
            WantedColumns(("t", "Fx"), gaps=frozenset(("Fx",))),
            WantedColumns(("Fx",), (), ("t",)),
            WantedColumns(("t",)),
        )
    )

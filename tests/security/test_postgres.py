"""Databases: none is reached that the user does not allow, no query runs that is not trusted, no secret is shown."""

from __future__ import annotations

import hashlib
import os
import re
import shlex
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from stiffcal.campaign.loading import load_manifest
from stiffcal.campaign.manifest.queries import queries_of
from stiffcal.errors import InputError
from stiffcal.readers import WantedColumns, find_reader
from stiffcal.readers.postgres.conninfo import conninfo_text, read_conninfo
from stiffcal.trust.queries import needs_trust, query_digest, table_of
from stiffcal.trust.record import open_record
from tests.laboratory.database import VARIABLE, Database, trusting

READER = find_reader(Path("x"), "postgres")
SECRET = "AKfgeheimgeheimsecret"


def fault(options: dict[str, Any], wanted: str = "t") -> str:
    with pytest.raises(InputError) as caught:
        list(READER.read_batches(Path("none"), {"from": "ft", "order_by": "t"} | options, WantedColumns((wanted,))))
    assert "\n" not in str(caught.value)
    assert "heim" not in str(caught.value)
    return str(caught.value).removesuffix(f" [{caught.value.code}]")


@pytest.fixture(autouse=True)
def _nothing_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("STIFFCAL_POSTGRES", "STIFFCAL_POSTGRES_ENV", "STIFFCAL_TRUST", "PGHOST", "PGPORT", "PGDATABASE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PGPASSWORD", SECRET)
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", SECRET)


@contextmanager
def listening() -> Iterator[tuple[int, list[bytes]]]:
    """Listen on a port, answer nothing, keep what came."""
    came: list[bytes] = []
    stop = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(0.05)

        def accept() -> None:
            lines: list[socket.socket] = []
            while not stop.is_set():
                with suppress(TimeoutError):
                    lines.append(server.accept()[0])
                    lines[-1].settimeout(0.5)
                    with suppress(OSError):
                        came.append(lines[-1].recv(4096))
            for line in lines:
                line.close()

        thread = threading.Thread(target=accept, daemon=True)
        thread.start()
        try:
            yield server.getsockname()[1], came
        finally:
            stop.set()
            thread.join()


class TestWhatTheUserAllows:
    def test_no_variable_that_the_user_does_not_allow_is_read(self, monkeypatch: pytest.MonkeyPatch) -> None:
        reported = fault({"uri_env": "AWS_SECRET_ACCESS_KEY"})
        assert "a campaign is not allowed to use AWS_SECRET_ACCESS_KEY as address of a database" in reported
        assert "STIFFCAL_POSTGRES_ENV=" not in reported  # no advice to open the way to a key
        monkeypatch.setenv("LAB_DB", f"postgresql://me:{SECRET}@127.0.0.1:1/ft")
        assert fault({"uri_env": "LAB_DB"}).endswith("export STIFFCAL_POSTGRES_ENV=LAB_DB")
        monkeypatch.setenv("STIFFCAL_POSTGRES_ENV", "OTHER,THIRD")
        assert fault({"uri_env": "LAB_DB"}).endswith("export STIFFCAL_POSTGRES_ENV='OTHER THIRD LAB_DB'")
        monkeypatch.setenv("STIFFCAL_POSTGRES_ENV", "OTHER, LAB_DB")
        assert "the database cannot be reached" in fault({"uri_env": "LAB_DB"})

    @pytest.mark.parametrize("name", ["A B", "A;rm -rf ~", "$(x)", "", "Ä", "A\nB"])
    def test_what_is_no_name_of_a_variable_is_refused(self, name: str) -> None:
        assert "is not a name of a variable" in fault({"uri_env": name})

    def test_the_same_answer_whether_a_variable_is_set_or_not(self, monkeypatch: pytest.MonkeyPatch) -> None:
        before = fault({"uri_env": "LAB_DB"})
        monkeypatch.setenv("LAB_DB", "postgresql://127.0.0.1/ft")
        assert fault({"uri_env": "LAB_DB"}) == before

    @pytest.mark.parametrize(
        "text",
        [
            SECRET, f"{SECRET}==", f"a={SECRET}", f"port={SECRET}", f"postgresql://me:{SECRET}/@h/d",
            f"postgresql://h/d?sslmode={SECRET}", f"host=h connect_timeout={SECRET}", f"postgresql://h:{SECRET}/d",
            f"postgresql://a:b%{SECRET}@h/d", f"host='{SECRET}", f"postgresql://a:b@{SECRET}@h/d",
        ],
    )  # fmt: skip
    def test_libpq_says_nothing_of_an_address_that_cannot_be_read(
        self, monkeypatch: pytest.MonkeyPatch, text: str
    ) -> None:
        monkeypatch.setenv("LAB_DB", text)
        monkeypatch.setenv("STIFFCAL_POSTGRES_ENV", "LAB_DB")
        assert "the value of LAB_DB is not the address of a PostgreSQL database" in fault({"uri_env": "LAB_DB"})

    def test_a_value_that_libpq_refuses_is_not_shown(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_POSTGRES_ENV", "LAB_DB")
        for key in ("gssencmode", "target_session_attrs", "channel_binding", "require_auth", "client_encoding"):
            monkeypatch.setenv("LAB_DB", f"host=127.0.0.1 port=1 {key}={SECRET}")
            assert "cannot be reached" in fault({"uri_env": "LAB_DB"})

    def test_no_byte_goes_to_a_host_that_the_user_does_not_allow(self) -> None:
        with listening() as (port, came):
            reported = fault({"host": "127.0.0.1", "port": port, "database": "ft", "user": "me"})
            assert reported.endswith(f"if it is yours: export STIFFCAL_POSTGRES=me@127.0.0.1:{port}/ft")
        assert came == []

    def test_the_line_that_the_error_gives_allows_it(self, monkeypatch: pytest.MonkeyPatch) -> None:
        for options in (
            {"host": "127.0.0.1", "port": 1, "database": "ft", "user": "me"},
            {"host": "::1", "port": 1, "database": "ft"},
            {"host": "127.0.0.1", "database": "a b,c/d@e*"}, {"host": "/no where/x", "database": "ft"},
            {"host": "/nowhere", "port": 7, "database": "ft", "user": "m e"}, {"database": "$(x);'"},
        ):  # fmt: skip
            line = fault(options).rpartition("if it is yours: ")[2]
            command, entry = shlex.split(line)
            assert command == "export"
            name, _, value = entry.partition("=")
            with monkeypatch.context() as allowed:
                allowed.setenv(name, value)
                assert "the database cannot be reached" in fault(options)

    @pytest.mark.parametrize(
        ("allowed", "options"),
        [
            ("db.example/ft", {"host": "evil.example", "database": "ft"}),
            ("db.example/ft", {"host": "db.example", "database": "other"}),
            ("db.example/ft", {"host": "db.example", "database": "ft", "port": 5433}),
            ("db.example/ft", {"host": "db.example", "database": "ft", "user": "postgres"}),
            ("me@db.example/ft", {"host": "db.example", "database": "ft", "user": "postgres"}),
            ("db.example/*", {"host": "db.example.evil.example", "database": "ft"}),
            ("db.example/ft", {"database": "ft"}),
            ("/ft", {"host": "/var/run/evil", "database": "ft"}),
        ],
    )
    def test_what_is_not_the_very_thing_that_is_allowed_is_refused(
        self, monkeypatch: pytest.MonkeyPatch, allowed: str, options: dict[str, Any]
    ) -> None:
        monkeypatch.setenv("STIFFCAL_POSTGRES", allowed)
        assert "not allowed to connect to" in fault(options)

    @pytest.mark.parametrize(
        "host", ["a,127.0.0.1", "a b", "127.0.0.1 sslcert=/etc/passwd", "'", "a/b", "postgresql://x", "@abstract", ""]
    )
    def test_what_is_no_single_host_is_refused(self, monkeypatch: pytest.MonkeyPatch, host: str) -> None:
        monkeypatch.setenv("STIFFCAL_POSTGRES", "*/* 127.0.0.1/* a/*")
        assert re.search("is not a host|is not allowed|is not a database", fault({"host": host, "database": "ft"}))

    @pytest.mark.parametrize("key", ["sslcert", "sslkey", "passfile", "service", "options", "password", "hostaddr"])
    def test_other_parameters_of_libpq_are_no_options_of_a_manifest(self, key: str) -> None:
        assert f"postgres.{key}: no such option" in fault({"host": "127.0.0.1", "database": "ft", key: "/etc/passwd"})

    def test_no_value_of_a_manifest_becomes_another_parameter(self, monkeypatch: pytest.MonkeyPatch) -> None:
        for value in ("ft' sslcert='/etc/passwd", "ft\\' passfile=x", "host=evil", "postgresql://evil/x"):
            parameters = read_conninfo(conninfo_text({"host": "h", "dbname": value}))
            assert parameters == {"host": "h", "dbname": value}

    def test_a_wrong_list_of_databases_is_one_line(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_POSTGRES", "db.example")
        assert "STIFFCAL_POSTGRES: 'db.example' is not a database" in fault({"host": "db.example", "database": "ft"})


class TestASilentHost:
    def test_a_host_that_takes_the_line_and_stays_silent_costs_five_seconds(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.delenv("PGCONNECT_TIMEOUT", raising=False)
        with listening() as (port, _):
            monkeypatch.setenv("STIFFCAL_POSTGRES", f"127.0.0.1:{port}/ft")
            begun = time.monotonic()
            assert "cannot be reached" in fault({"host": "127.0.0.1", "port": port, "database": "ft"})
            assert time.monotonic() - begun < 6.0

    def test_a_name_with_two_addresses_has_no_longer(self, monkeypatch: pytest.MonkeyPatch) -> None:
        from stiffcal.readers.postgres import address

        entries = [(2, 1, 6, "", ("127.0.0.1", 0)), (10, 1, 6, "", ("::1", 0, 0, 0))]
        monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: entries)
        monkeypatch.setenv("STIFFCAL_POSTGRES", "db.example/ft")
        found = address.address_of({"host": "db.example", "database": "ft"}, "table ft")
        assert "connect_timeout='2'" in found.text


@pytest.fixture
def filled(database: Database, monkeypatch: pytest.MonkeyPatch) -> Database:
    monkeypatch.setenv("STIFFCAL_POSTGRES_ENV", VARIABLE)
    database.run(
        'create schema if not exists "my lab"; drop table if exists lab_ft; drop table if exists "my lab"."f.t";'
        " create table lab_ft as select k * 0.1 as t, k * 2.0 as x from generate_series(0, 9) as k;"
        ' create table "my lab"."f.t" as select * from lab_ft'
    )
    return database


def read(text: str) -> int:
    options = {"uri_env": VARIABLE, "from": text} | ({} if needs_trust(text) else {"order_by": "t"})
    return sum(len(batch) for batch in READER.read_batches(Path("none"), options, WantedColumns(("t", "x"))))


class TestQueries:
    def test_a_bare_table_needs_no_trust(self, filled: Database) -> None:
        assert read("lab_ft") == read("public.lab_ft") == read('"my lab"."f.t"') == read('my lab."f.t"') == 10

    @pytest.mark.parametrize(
        "text",
        [
            "select pg_read_file('/etc/passwd') as t order by t", "table ft", "values (1) order by 1",
            "with a as (select 1) select * from a order by 1", "(select 1)", "ft, pg_authid",
            "ft; select 1", "select * from dblink('host=evil', 'select 1') as a(t int) order by t", "ft /* x",
            "pg_authid", "pg_catalog.pg_authid", '"pg_catalog"."pg_authid"', "PG_AUTHID", "information_schema.tables",
            'ft" union select', "a.b.c", "lo_import('/etc/passwd')", "SELECT 1", "select",
        ],
    )  # fmt: skip
    def test_any_other_text_does(self, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_POSTGRES_ENV", "LAB_DB")
        monkeypatch.setenv("LAB_DB", "host=127.0.0.1 port=1")
        reported = fault({"uri_env": "LAB_DB", "from": text})
        assert "this one is not allowed" in reported
        assert "stiffcal trust DIR" in reported
        assert query_digest(text) in reported

    def test_nothing_is_sent_before_a_query_is_trusted(self, monkeypatch: pytest.MonkeyPatch) -> None:
        with listening() as (port, came):
            monkeypatch.setenv("STIFFCAL_POSTGRES", f"127.0.0.1:{port}/ft")
            options = {"host": "127.0.0.1", "port": port, "database": "ft", "from": "select 1 as t order by t"}
            assert "this one is not allowed" in fault(options)
        assert came == []

    def test_a_trusted_text_runs_and_any_change_of_it_does_not(self, filled: Database) -> None:
        text = "select t, x from lab_ft order by t"
        with trusting(text):
            assert read(text) == read(f"  {text} ; ") == 10
            for changed in (text.replace("t, x", "x, t"), text.upper(), text + " limit 3", text.replace("ft", "fu")):
                with pytest.raises(InputError, match="this one is not allowed"):
                    read(changed)

    def test_the_record_of_trust_counts(self, filled: Database) -> None:
        text = "select t, x + 1 as x from lab_ft order by t"
        open_record().allow_text(query_digest(text), "a test")
        assert read(text) == 10
        open_record().revoke(query_digest(text))
        with pytest.raises(InputError, match="this one is not allowed"):
            read(text)

    def test_the_hash_of_a_file_with_the_same_bytes_is_another(self) -> None:
        text = "select 1"
        assert query_digest(text) != hashlib.sha256(text.encode()).hexdigest()

    def test_even_a_trusted_query_writes_nothing(self, filled: Database) -> None:
        text = "with gone as (delete from lab_ft returning t, x) select * from gone order by t"
        with trusting(text), pytest.raises(InputError, match="refused"):
            read(text)
        assert read("lab_ft") == 10

    def test_a_statement_that_takes_too_long_is_ended(self, filled: Database, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_POSTGRES_STATEMENT_S", "1")
        text = "select t, x, pg_sleep(60)::text as s from lab_ft order by t"
        begun = time.monotonic()
        with trusting(text), pytest.raises(InputError, match="raise STIFFCAL_POSTGRES_STATEMENT_S"):
            read(text)
        assert time.monotonic() - begun < 8.0
        monkeypatch.setenv("STIFFCAL_POSTGRES_STATEMENT_S", "0; drop table ft")
        with pytest.raises(InputError, match="STIFFCAL_POSTGRES_STATEMENT_S: .* is not a time in seconds"):
            read("lab_ft")

    def test_the_nearest_table_is_named_in_any_language_of_the_server(self, filled: Database) -> None:
        with pytest.raises(InputError, match="did you mean 'lab_ft'"):
            read("lab_fft")

    @pytest.mark.parametrize("name", ['a"b', "a b", "ä-1", 'x"; drop table ft; --'])
    def test_names_are_quoted(self, name: str) -> None:
        quoted = '"' + name.replace('"', '""') + '"'
        assert table_of(quoted) == (name,)

    def test_the_queries_of_a_manifest_are_listed_once_each(self, tmp_path: Path) -> None:
        from tests.laboratory.small_campaign import write_small_campaign

        folder = write_small_campaign(tmp_path)
        manifest = load_manifest(folder)
        source = next(iter(manifest.sources))
        assert queries_of(manifest) == []
        changed = manifest.sources[source].model_copy(update={"format": "postgres", "file": " select 1; "})
        manifest = manifest.model_copy(update={"sources": {source: changed, "b": changed}})
        assert queries_of(manifest) == [(f"sources.{source}.file", "select 1")]
        table = changed.model_copy(update={"file": "daq.ft"})
        assert queries_of(manifest.model_copy(update={"sources": {source: table}})) == []


def test_the_environment_of_the_tests_allows_nothing_more() -> None:
    assert "STIFFCAL_POSTGRES" not in os.environ

"""PostgreSQL, on a real server: tables, partitioned tables and queries; order, faults, and no password anywhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.readers import WantedColumns, find_reader
from stiffcal.readers import postgres as postgres_module
from tests.laboratory.database import VARIABLE, VARIABLES, Database, trusting
from tests.laboratory.log_reading import read_columns, refusal

READER = find_reader(Path("x"), "postgres")
NO_FILE = Path("nothing")
SETUP = """
create schema daq;
create table daq.ft (t double precision, "Fx" real, fy numeric(12, 6), run text, at timestamptz, n int, gap real)
    partition by range (t);
create table daq.ft_a partition of daq.ft for values from (0) to (5);
create table daq.ft_b partition of daq.ft for values from (5) to (10);
insert into daq.ft select k * 0.01, k * 0.5, k * 1.25, 'p' || (k % 2),
    '2026-11-21T08:15:30.25Z'::timestamptz + k * interval '10 ms', k, nullif(k, 7)
    from generate_series(999, 0, -1) as k;
create table daq.holes as select k * 0.1 as t, case when k = 3 then null else k end as x,
    case when k = 4 then 'NaN'::float8 else 1.0 end as y from generate_series(0, 9) as k;
create table daq.big as select k as t, k * 0.001 as x, k * 0.002 as y from generate_series(1, 400000) as k;
"""


@pytest.fixture(scope="module")
def filled(database: Database) -> Database:
    database.run(SETUP)
    return database


def read(options: dict[str, Any], wanted: WantedColumns) -> dict[str, Any]:
    with trusting(options["from"]):
        return read_columns(READER, NO_FILE, {"uri_env": VARIABLE} | options, wanted)


def fault(options: dict[str, Any], wanted: WantedColumns) -> str:
    return refusal(lambda: read(options, wanted))


K = np.arange(1000)


def test_a_partitioned_table_in_order(filled: Database) -> None:
    wanted = WantedColumns(("t", "Fx", "fy", "n", "gap"), texts=("run",), times=("at",), gaps=frozenset({"gap"}))
    found = read({"from": "daq.ft", "order_by": "t"}, wanted)
    assert np.allclose(found["t"], K * 0.01, rtol=0, atol=1e-12)
    assert np.array_equal(found["Fx"], K * 0.5)
    assert np.array_equal(found["fy"], K * 1.25)
    assert np.array_equal(found["n"], K)
    assert np.flatnonzero(np.isnan(found["gap"])).tolist() == [7]
    assert found["run"][:3].tolist() == ["p0", "p1", "p0"]
    assert np.allclose(found["at"] - 1795248930.25, K * 0.01, rtol=0, atol=1e-6)
    assert READER.read_header(NO_FILE, {"uri_env": VARIABLE, "from": "daq.ft"}).columns[:3] == ("t", "Fx", "fy")


def test_queries_say_their_order(filled: Database) -> None:
    query = "select t, \"Fx\" * 2 as x from daq.ft where run = 'p1' order by t desc;  "
    found = read({"from": query}, WantedColumns(("x",)))
    assert np.array_equal(found["x"], K[1::2][::-1] * 1.0)
    found = read({"from": "select t, fy from daq.ft -- all of it", "order_by": "t"}, WantedColumns(("fy",)))
    assert np.array_equal(found["fy"], K * 1.25)
    assert ("the order of its rows is not defined; add postgres.order_by") in fault(
        {"from": "daq.ft"}, WantedColumns(("t",))
    )
    assert "the order of its rows is not defined" in fault({"from": "select t from daq.ft"}, WantedColumns(("t",)))


def test_rows_are_streamed(filled: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(postgres_module, "BATCH_BYTES", 1 << 18)
    options = {"uri_env": VARIABLE, "from": "daq.big", "order_by": "t"}
    lengths, last = [], 0.0
    for batch in READER.read_batches(NO_FILE, options, WantedColumns(("t", "x", "y"))):
        lengths.append(len(batch))
        last = batch.numbers["t"][-1]
    assert sum(lengths) == last == 400_000
    assert max(lengths) <= 20_000  # 256 kB of three columns


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (
            {"from": "daq.fft"},
            'table daq.fft: the database refused (ERROR: relation "daq.fft" does not exist); did you mean',
        ),
        ({"from": "select x from hols order by x"}, "does not exist); did you mean 'daq.holes'?"),
        ({"from": "daq.ft", "order_by": "tt"}, "postgres.order_by: no column 'tt'; did you mean 't'?"),
        ({"from": "daq.holes", "order_by": "t"}, "row 4, column x: the cell is empty (NULL)"),
        ({"from": "select t, y as x from daq.holes order by t"}, "row 5, column x: nan is not a finite number"),
        ({"from": "select t, run as x from daq.ft order by t"}, "column x: it contains words, not numbers"),
        ({"from": "select t, t as x from daq.ft where t < 0 order by t"}, "there are no rows"),
        (
            {"from": "select '1 s'::interval as x order by x"},
            "neither numbers nor words nor times; use another column",
        ),
        ({"from": "select array[1.5] as x order by x"}, "it contains list<item: "),
        ({"from": "select 1/0 as x order by x"}, "ERROR: division by zero"),
        ({"from": "daq.ft", "password": "geheim"}, "postgres.password: no such option"),
        ({"from": "daq.ft", "host": "localhost"}, "the address is given twice"),
        ({"from": "daq.ft", "uri_env": "NOT_ALLOWED"}, "a campaign is not allowed to use NOT_ALLOWED"),
        (
            {"from": "with gone as (delete from daq.ft returning t as x) select * from gone order by x"},
            "data-modifying",
        ),
        ({"from": "daq.ft", "order_by": "t; drop table daq.ft"}, "no column 't; drop table daq.ft'"),
    ],
)
def test_faults_are_one_clear_line(filled: Database, options: dict[str, Any], expected: str) -> None:
    assert expected in fault(options, WantedColumns(("x",)) if options["from"] != "daq.ft" else WantedColumns(("t",)))


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("postgresql://me:ge%20heim@localhost:1/db", "the database cannot be reached"),
        ("host=localhost port=1 password='geheim' user=me", "the database cannot be reached"),
        ("postgresql://me:geheim@loc[alhost:x1/db?password=geheim", "is not the address"),
        ("password=geheim nonsense", "is not the address"),
        ("postgresql://me:geheim%zz@localhost:1/db", "is not the address"),  # libpq's own message holds it
    ],
)
def test_no_password_is_shown(monkeypatch: pytest.MonkeyPatch, address: str, reason: str) -> None:
    monkeypatch.setenv(VARIABLES, "LAB")
    monkeypatch.setenv("LAB", address)
    reported = fault({"from": "ft", "uri_env": "LAB"}, WantedColumns(("t",)))
    assert reason in reported
    assert "heim" not in reported


def test_the_fingerprint_follows_the_rows(filled: Database) -> None:
    options = {"uri_env": VARIABLE, "from": "daq.holes", "order_by": "t"}
    before = postgres_module.READER.fingerprint(options)
    assert before == postgres_module.READER.fingerprint(options)
    filled.run("update daq.holes set y = 2.0 where t = 0")
    after = postgres_module.READER.fingerprint(options)
    assert before[0] == after[0] == 10
    assert before != after


@pytest.mark.parametrize(
    ("moment", "expected"),
    [("'2026-11-21'::date", 1795219200.0), ("'2026-11-21 08:00'::timestamp", 1795248000.0),
     ("'infinity'::timestamptz", None), ("'-infinity'::timestamp", None)],
)  # fmt: skip
def test_moments_of_every_kind(filled: Database, moment: str, expected: float | None) -> None:
    options, wanted = {"from": f"select {moment} as x order by x"}, WantedColumns((), times=("x",))
    if expected is None:
        assert "is not a finite number" in fault(options, wanted)
    else:
        assert read(options, wanted)["x"] == [expected]

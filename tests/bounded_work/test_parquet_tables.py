"""Tables of a store that this user has not written: read in a child process, the same cells, none of the rest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.store import Store
from stiffcal.store.index import DamagedStoreError
from tests.fuzz.running import fresh_state
from tests.fuzz.stores import seal

ROWS = 100_003  # two pieces, no multiple of eight
NUMBERS = np.random.default_rng(4).normal(size=ROWS)
MISSING = np.arange(ROWS) % 7 == 3
TABLE = pa.table(
    {
        "x": pa.array(NUMBERS, mask=MISSING),
        "y": NUMBERS,
        "n": np.arange(ROWS),
        "m": pa.array([None, 5] * (ROWS // 2) + [7], pa.int64()),
        "on": NUMBERS > 0.0,
        "b": pa.array(NUMBERS > 1.0, mask=MISSING),
        "run": [f"pose {k % 9} äµ" for k in range(ROWS)],
        "tag": pa.array([("", None, "one\ntwo")[k % 3] for k in range(ROWS)]),
    },
    metadata={"stiffcal": '{"a": 1}'},
)


@pytest.fixture
def store(tmp_path: Path, state: Path) -> Store:
    """A store that somebody else has written."""
    with fresh_state(tmp_path / "stranger"):
        Store(tmp_path / "store").commit({"all": TABLE, "none": TABLE.slice(0, 0), "few": TABLE.slice(3, 5)})
    return Store(tmp_path / "store", display_name="store")


def replace_table(store: Store, table: pa.Table, **options: Any) -> None:
    (generation,) = (store.folder / "generations").iterdir()
    parquet.write_table(table, generation / "few.parquet", **options)
    seal(generation)


def test_the_cells_are_those_that_were_written(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr("pyarrow.parquet.ParquetFile")  # not in this process
    for name, table in {"all": TABLE, "none": TABLE.slice(0, 0), "few": TABLE.slice(3, 5)}.items():
        found = store.read_table(name)
        assert found.equals(table, check_metadata=True), name
        assert store.read_table(name, ["run", "m"]).equals(table.select(["m", "run"])), name
    with store.snapshot() as snapshot:
        pieces = list(snapshot.read_batches("all", ["b"], 1001))
    assert pa.Table.from_batches(pieces).equals(TABLE.select(["b"]))


def test_a_table_that_was_taken_over_into_an_own_generation_is_read_there_too(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.commit({"mine": TABLE.slice(0, 2)}, origin="foreign")  # made from what the stranger has measured
    monkeypatch.delattr("pyarrow.parquet.ParquetFile")
    with store.snapshot() as snapshot:
        assert (snapshot.origin, snapshot.origin_of("few")) == ("own", "foreign")
        assert snapshot.read_table("few").num_rows == 5


@pytest.mark.parametrize(
    "column",
    [
        pa.array([[1], [2]]),
        pa.array([b"a", b"b"]),
        pa.array([{"a": 1}, {"a": 2}]),
        pa.array([1, 2], pa.timestamp("ns")),
        pa.array(["a", "b"]).dictionary_encode(),
        pa.nulls(2),
    ],
    ids=lambda column: str(column.type),
)
def test_columns_of_other_types_are_one_line(store: Store, column: pa.Array) -> None:
    replace_table(store, pa.table({"x": column}))
    with pytest.raises(DamagedStoreError, match="column 'x' holds"):
        store.read_table("few")


def test_a_damaged_page_is_one_line(store: Store) -> None:
    (generation,) = (store.folder / "generations").iterdir()
    path = generation / "few.parquet"
    content = bytearray(path.read_bytes())
    content[10:60] = bytes(50)
    path.write_bytes(bytes(content))
    seal(generation)
    with pytest.raises(DamagedStoreError):
        store.read_table("few")


@pytest.mark.parametrize("rows", [20_000, 200_000_000], ids=["a word in every row", "rows of one number"])
def test_what_packs_to_nothing_takes_no_memory_here(store: Store, rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    word = pa.DictionaryArray.from_arrays(pa.array(np.zeros(20_000, np.int32)), ["x" * 100_000])
    table = pa.table({"x": pa.array(np.zeros(1_000_000))}) if rows > 20_000 else pa.table({"x": word})
    replace_table(store, table, store_schema=False, compression="zstd")
    monkeypatch.setenv("STIFFCAL_MAX_PIECE", "400 MiB" if rows == 20_000 else "7 MB")
    with pytest.raises(InputError) as refused:
        store.read_table("few")
    assert refused.value.code == FaultCode.SIZE_EXCEEDED

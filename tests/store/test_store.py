"""The store: round trips, one generation at a time, faults of the disk, outside readers."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import duckdb
import hypothesis.strategies as st
import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from hypothesis import given, settings

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.columns import table_of, values_of
from stiffcal.store import Store, table_stream
from stiffcal.store import generations as generations_module


def table(value: float, rows: int = 3) -> pa.Table:
    return pa.table({"run": ["pose01"] * rows, "Fx": np.full(rows, value), "row": np.arange(rows)})


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "store")


def fill(store: Store, value: float) -> None:
    store.commit({"states": table(value)}, {"fit": {"value": value}}, keep_rest=False)


names = st.text(st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="/"), min_size=1, max_size=12)
floats = st.floats(allow_nan=False)
json_values = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False, allow_infinity=False) | names,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(names, inner, max_size=3),
    max_leaves=8,
)


@settings(max_examples=40)
@given(
    name=st.lists(names, min_size=1, max_size=3).map("/".join),
    columns=st.dictionaries(names, st.lists(floats, min_size=4, max_size=4), min_size=1, max_size=3),
    words=st.lists(names, min_size=4, max_size=4),
    document=st.dictionaries(names, json_values, max_size=3),
)
def test_round_trip(name: str, columns: dict[str, list[float]], words: list[str], document: dict[str, object]) -> None:
    expected = pa.table({**{f"n{key}": pa.array(values, pa.float64()) for key, values in columns.items()}, "w": words})
    with tempfile.TemporaryDirectory() as folder:
        store = Store(Path(folder) / "store")
        store.commit({name: expected}, {name: document})
        assert store.read_table(name).equals(expected)
        assert store.read_document(name) == document
        assert store.tables == store.documents == (name,)


def test_streamed_rows_come_back_in_order(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table_stream, "ROW_GROUP", 1000)
    values = np.random.default_rng(1).normal(size=(7321, 2))
    with store.begin() as writing:
        stream = writing.stream("recordings/pose01/ft", ["Fx", "Fy"])
        for piece in np.array_split(values, 23):
            stream.append({"Fx": piece[:, 0], "Fy": piece[:, 1]})
        writing.commit()
    with store.snapshot() as snapshot:
        back = np.concatenate(
            [np.column_stack([b.column("Fx"), b.column("Fy")]) for b in snapshot.read_batches("recordings/pose01/ft")]
        )
    assert np.array_equal(back, values)


def test_outside_readers_need_one_line(store: Store) -> None:
    fill(store, 1.0)
    fill(store, 2.5)
    path = f"{store.folder.as_posix()}/current/states.parquet"
    assert pd.read_parquet(path)["Fx"].tolist() == [2.5, 2.5, 2.5]
    found = duckdb.connect().execute(f"select run, sum(Fx) from '{path}' group by run").fetchall()
    assert found == [("pose01", 7.5)]


def test_without_commit_nothing_changes(store: Store) -> None:
    fill(store, 1.0)
    with pytest.raises(KeyError), store.begin() as writing:
        writing.keep("states", "a name that is not there")
    assert store.read_table("states").equals(table(1.0))
    assert len(list((store.folder / "generations").iterdir())) == 1


def test_keep_carries_over_and_the_rest_goes(store: Store) -> None:
    store.commit({"states": table(1.0), "old": table(9.0)}, {"fit": {"a": 1}, "history": {"b": 2}})
    with store.begin() as writing:
        writing.keep("states", "history")
        writing.write_document("fit", {"a": 3})
        writing.commit()
    assert store.tables == ("states",)
    assert store.read_table("states").equals(table(1.0))
    assert store.read_document("fit") == {"a": 3}
    assert store.read_document("history") == {"b": 2}
    with pytest.raises(KeyError), store.begin() as writing:
        writing.keep("old")


def test_keep_copies_where_there_are_no_hard_links(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.EPERM, "no links")

    fill(store, 1.0)
    monkeypatch.setattr(os, "link", refuse)
    store.commit(documents={"more": {}})
    assert store.read_table("states").equals(table(1.0))


def test_a_reader_keeps_its_generation_while_writers_commit(store: Store) -> None:
    fill(store, 1.0)
    with store.snapshot() as snapshot:
        fill(store, 2.0)
        fill(store, 3.0)
        assert snapshot.read_table("states").equals(table(1.0))
        assert snapshot.read_document("fit") == {"value": 1.0}
        assert store.read_table("states").equals(table(3.0))
    fill(store, 4.0)
    assert len(list((store.folder / "generations").iterdir())) == 1


def test_a_generation_removed_between_finding_and_opening_is_looked_up_again(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(store, 1.0)
    stale = generations_module.current_folder(store.folder)
    fill(store, 2.0)
    answers = iter([stale])
    true_current = generations_module.current_folder
    monkeypatch.setattr("stiffcal.store.reading.current_folder", lambda folder: next(answers, true_current(folder)))
    assert store.read_document("fit") == {"value": 2.0}


DEAD, DEAD_LATE = "20200101T000000-aaaaaa", "20200101T000000-bbbbbb"


def test_what_a_killed_writer_left_is_removed(store: Store) -> None:
    fill(store, 1.0)
    for name, file in ((DEAD, "states.parquet"), (DEAD_LATE, "generation.json")):
        (store.folder / "generations" / name).mkdir()
        (store.folder / "generations" / name / file).write_bytes(b"half")
    (store.folder / f".current-{DEAD}").symlink_to(f"generations/{DEAD}")
    fill(store, 2.0)
    assert len(list((store.folder / "generations").iterdir())) == 1
    assert sorted(path.name for path in store.folder.iterdir()) == ["current", "generations", "lock"]


OF_THE_USER = ["current", "current/a.csv", "generations/a.csv", "generations/pose1/a.csv", "lock"]


@pytest.mark.parametrize("name", OF_THE_USER)
def test_a_folder_of_the_user_loses_nothing(store: Store, name: str) -> None:
    """`--store` may name any folder, and these are words for measured data too."""
    mine = store.folder / name
    mine.parent.mkdir(parents=True)
    mine.write_bytes(b"t,I\n0,1\n")
    if name == "lock":
        with pytest.raises(InputError) as caught:
            fill(store, 1.0)
        assert caught.value.faults[0].code == FaultCode.FILE_EXISTS
    else:
        for value in (1.0, 2.0):
            fill(store, value)
            assert store.read_document("fit") == {"value": value}
    assert mine.read_bytes() == b"t,I\n0,1\n"


@pytest.mark.parametrize("separator", ["/", "\\"])
def test_an_archive_that_keeps_links_as_files_is_a_store(store: Store, separator: str) -> None:
    fill(store, 1.0)
    link = store.folder / "current"
    target = separator.join(link.readlink().parts)
    link.unlink()
    link.write_text(target)
    fill(store, 2.0)
    assert link.is_symlink()
    assert store.read_document("fit") == {"value": 2.0}


def test_without_links_a_file_is_the_switch(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.EPERM, "no links")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "symlink_to", refuse)
        fill(store, 1.0)
        fill(store, 2.0)
        assert not (store.folder / "current").exists()
        assert store.read_document("fit") == {"value": 2.0}
    fill(store, 3.0)
    assert store.read_document("fit") == {"value": 3.0}
    assert (store.folder / "current").is_symlink()
    assert not (store.folder / "current.id").exists()


def test_a_copy_with_links_followed_is_still_a_store(store: Store, tmp_path: Path) -> None:
    import shutil

    fill(store, 1.0)
    shutil.copytree(store.folder, tmp_path / "copy", symlinks=False)
    copy = Store(tmp_path / "copy")
    assert copy.read_table("states").equals(table(1.0))
    copy.commit(documents={"more": {"x": 1}})
    assert copy.read_table("states").equals(table(1.0))
    assert copy.read_document("more") == {"x": 1}
    assert (copy.folder / "current" / "more.json").is_file()


def test_empty_and_damaged_stores_are_named(store: Store) -> None:
    assert not store.exists
    assert store.tables == ()
    with pytest.raises(InputError, match=r"nothing is stored here yet; run ingest"):
        store.read_table("states")
    fill(store, 1.0)
    with pytest.raises(InputError, match="no such table"):
        store.read_table("fit")
    with pytest.raises(InputError, match="no such document"):
        store.read_document("states")
    current = store.folder / "current"
    whole = (current / "states.parquet").read_bytes()
    (current / "states.parquet").write_bytes(whole[:-40])
    with pytest.raises(InputError, match=r"states: damaged .*; run stiffcal ingest again; the history is kept"):
        store.read_table("states")
    (current / "fit.json").write_text("{", "utf-8")
    with pytest.raises(InputError, match="fit: damaged"):
        store.read_document("fit")
    index = json.loads((current / "generation.json").read_text("utf-8"))
    (current / "generation.json").write_text(json.dumps({**index, "schema": "stiffcal/store/9"}), "utf-8")
    with pytest.raises(InputError, match=r"written by a newer stiffcal \(stiffcal/store/9\); update stiffcal"):
        store.read_document("fit")
    with pytest.raises(InputError, match="update stiffcal"):
        fill(store, 2.0)
    # What cannot be read can still be written anew.
    (current / "generation.json").write_text("{", "utf-8")
    fill(store, 2.0)
    assert store.read_document("fit") == {"value": 2.0}


def test_a_flipped_bit_is_found(store: Store) -> None:
    store.commit({"states": pa.table({"Fx": np.random.default_rng(0).normal(size=1000)})})
    path = store.folder / "current" / "states.parquet"
    content = bytearray(path.read_bytes())
    content[3000] ^= 4
    path.write_bytes(content)
    with pytest.raises(InputError, match="damaged"):
        store.read_table("states")


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EACCES, errno.EROFS])
@pytest.mark.parametrize("flushes", range(7))
def test_a_full_disk_leaves_the_old_generation(
    store: Store, monkeypatch: pytest.MonkeyPatch, number: int, flushes: int
) -> None:
    fill(store, 1.0)
    true_fsync = os.fsync
    left = flushes

    def fail(descriptor: int) -> None:
        nonlocal left
        left -= 1
        if left < 0:
            raise OSError(number, os.strerror(number))
        true_fsync(descriptor)

    # Table, document, index, two folders; the sixth, of the link, comes after the switch.
    before_switch = flushes < 5
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", fail)
        if before_switch:
            with pytest.raises(InputError, match=r"cannot be written: .*unchanged"):
                fill(store, 2.0)
        else:
            fill(store, 2.0)
    assert store.read_document("fit") == {"value": 1.0 if before_switch else 2.0}
    assert store.read_table("states").equals(table(1.0 if before_switch else 2.0))
    fill(store, 3.0)
    assert len(list((store.folder / "generations").iterdir())) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="file size limits are of POSIX")
def test_a_table_that_does_not_fit_leaves_the_old_generation(store: Store) -> None:
    import resource

    fill(store, 1.0)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, limits[1]))
        with pytest.raises(InputError, match="cannot be written: "):
            store.commit({"states": pa.table({"Fx": np.random.default_rng(1).normal(size=100_000)})})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert store.read_table("states").equals(table(1.0))
    assert len(list((store.folder / "generations").iterdir())) == 1


def test_a_store_that_cannot_be_made_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"cannot be written: Not a directory; put the store elsewhere"):
        fill(Store(tmp_path / "file" / "store"), 1.0)
    with pytest.raises(InputError, match="gs: addresses are not supported; give a folder, or s3://BUCKET/PREFIX"):
        Store("gs://bucket/store")
    assert Store("file:///tmp/a%20b").folder == Path("/tmp/a b")


def test_documents_hold_json_values_only(store: Store) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        store.commit(documents={"fit": {"x": float("nan")}})
    store.commit(documents={"fit": {"x": np.float64(1.5), "y": np.arange(2)}})
    assert store.read_document("fit") == {"x": 1.5, "y": [0, 1]}


def test_columns_become_what_they_are() -> None:
    columns: dict[str, Any] = {
        "x": np.array([np.nan, 1.5]),
        "n": np.array([3, 4], dtype=np.int32),
        "ok": np.array([True, False]),
        "word": ["µ", ""],
        "array": np.array(["a", "bc"]),
    }
    made = table_of(columns)
    assert made.column("x").to_pylist()[1] == 1.5
    assert made.column("n").to_pylist() == [3, 4]
    assert made.column("ok").to_pylist() == [True, False]
    assert made.column("word").to_pylist() == ["µ", ""]
    assert made.column("array").to_pylist() == ["a", "bc"]
    made.validate(full=True)
    for name, column in columns.items():
        assert np.array_equal(values_of(made.column(name)), np.asarray(column), equal_nan=name == "x")
        assert np.array_equal(values_of(made.column(name).slice(1)), np.asarray(column)[1:])  # the NaN comes first
    assert np.array_equal(values_of(pa.array([1.0, None, 3.0])), [1.0, np.nan, 3.0], equal_nan=True)
    assert values_of(made.slice(0, 0).column("x")).dtype == np.float64
    with pytest.raises(ValueError, match="unequal length"):
        table_of({"a": np.zeros(2), "b": np.zeros(3)})


def test_neither_reading_nor_writing_imports_pandas(tmp_path: Path) -> None:
    script = """
import sys, numpy
from stiffcal.measurements.columns import values_of
from stiffcal.store import Store
store = Store(sys.argv[1])
store.commit({"states": {"run": ["a"], "Fx": numpy.ones(1)}}, {"fit": {}})
table = store.read_table("states")
values_of(table.column("Fx")), values_of(table.column("run"))
print("pandas" in sys.modules, "pyarrow.dataset" in sys.modules)
"""
    command = [sys.executable, "-c", script, str(tmp_path / "store")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout.split() == ["False", "False"]

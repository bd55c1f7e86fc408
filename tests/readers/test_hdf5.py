"""HDF5: the three layouts give the same numbers; interrupted and damaged files are named."""

from __future__ import annotations

import struct
import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import WantedColumns, find_reader
from tests.laboratory.log_reading import parse_here, read_columns, refusal

READER = find_reader(Path("x.h5"))
VALUES = np.random.default_rng(3).normal(size=(500, 3))
NAMES = ("t", "ids1", "ids2")
WANTED = WantedColumns(NAMES)


def columns(file: h5py.File, **options: Any) -> None:
    group = file.create_group("ids")
    for index, name in enumerate(NAMES):
        group.create_dataset(name, data=VALUES[:, index], **options)
        group[name].attrs["unit"] = "um"
    group["run"] = ["pose01"] * 500
    group["when"] = [f"2026-11-21T08:00:{second % 60:02}Z" for second in range(500)]


def matrix(file: h5py.File) -> None:
    file["ids/log"] = VALUES
    file["ids/log"].attrs["columns"] = list(NAMES)
    file["ids/log"].attrs["units"] = "um,um,um"


def records(file: h5py.File) -> None:
    table = np.zeros(500, dtype=[(name, "f8") for name in NAMES])
    for index, name in enumerate(NAMES):
        table[name] = VALUES[:, index]
    file["ids/log"] = table
    file["ids/log"].attrs["units"] = ["um", "um", "um"]


def fault(path: Path, wanted: WantedColumns = WANTED, **options: Any) -> str:
    return refusal(lambda: read_columns(READER, path, {"group": "/ids", **options}, wanted, "raw/ids.h5"), "raw/ids.h5")


@pytest.mark.parametrize("write", [columns, matrix, records])
def test_layouts(tmp_path: Path, write: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    parse_here(monkeypatch, 128)
    path = tmp_path / "ids.h5"
    with h5py.File(path, "w") as file:
        write(file)
    header = READER.read_header(path, {"group": "/ids"}, wanted=WANTED)
    assert header.units == dict.fromkeys(NAMES, "um")
    batches = list(READER.read_batches(path, {"group": "/ids"}, WANTED))
    assert [batch.first_row for batch in batches] == [1, 129, 257, 385]
    assert np.array_equal(
        np.concatenate([np.column_stack([batch.numbers[name] for name in NAMES]) for batch in batches]), VALUES
    )
    assert READER.place_of_row(path, {}, 5) == "row 5"


def test_words_and_times(tmp_path: Path) -> None:
    path = tmp_path / "ids.h5"
    with h5py.File(path, "w") as file:
        columns(file)
    (batch,) = READER.read_batches(path, {"group": "ids"}, WantedColumns(("t",), texts=("run",), times=("when",)))
    assert set(batch.texts["run"]) == {"pose01"}
    assert batch.numbers["when"][1] - batch.numbers["when"][0] == 1
    assert "column run: it holds text, not numbers" in fault(path, WantedColumns(("run",)))


def test_names_that_are_not_there(tmp_path: Path) -> None:
    path = tmp_path / "ids.h5"
    with h5py.File(path, "w") as file:
        columns(file)
        file["other"] = VALUES
    assert "no column 'ids3'; did you mean 'ids" in fault(path, WantedColumns(("ids3",)))
    assert "hdf5.group: no group '/idz'; did you mean '/ids'?" in fault(path, group="/idz")
    assert "hdf5.dataset: no dataset 'log' in '/ids'" in fault(path, dataset="log")
    assert "its columns have no names; write an attribute 'columns'" in fault(path, group="/", dataset="other")
    assert "hdf5.grp: no such option" in fault(path, grp="/")
    with pytest.raises(InputError, match="no such file"):
        READER.read_header(tmp_path / "x.h5", {})


def test_interrupted_and_damaged_files(tmp_path: Path) -> None:
    path = tmp_path / "ids.h5"
    with h5py.File(path, "w") as file:
        columns(file)
        del file["ids/ids2"]
        file["ids/ids2"] = VALUES[:400, 2]
    assert "column ids2: 400 rows, column t has 500: writing was interrupted" in fault(path)
    with h5py.File(path, "w") as file:
        columns(file, chunks=(100,), maxshape=(None,))
        for name in NAMES:
            file["ids"][name].resize((900,))
    assert "column t: parts of it were never written" in fault(path)
    with h5py.File(path, "w") as file:
        columns(file)
        file["ids/ids1"][41] = np.nan
    assert "row 42, column ids1: nan is not a finite number" in fault(path)
    with h5py.File(path, "w") as file:
        columns(file)
        file["ids/ids1"].attrs["scale_factor"] = 0.1
    assert "column ids1: its attribute 'scale_factor' marks" in fault(path)
    with h5py.File(path, "w") as file:
        columns(file)
    whole = path.read_bytes()
    for size in (0, 100, 2000, len(whole) - 1):
        path.write_bytes(whole[:size])
        assert "no whole HDF5 file" in fault(path)


@pytest.mark.skipif(sys.platform == "win32", reason="time alone is bounded there")
@pytest.mark.parametrize(
    ("at", "held"),
    [(0, bytes(16)), (8, b"\xff" * 8), (8, b"\x00\x20" + bytes(6)), (0, b"\x00\x00")],
    ids=["no size", "huge", "beyond the heap", "another number"],
)
def test_damaged_words_hold_nobody_up(tmp_path: Path, at: int, held: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    """libhdf5 walks a heap with some such objects for ever."""
    monkeypatch.setenv("STIFFCAL_MAX_SECONDS", "1")
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as file:
        for name in ("t", "Fx"):
            file.create_dataset(name, data=np.arange(5.0)).attrs["unit"] = "some unit that is long"
    data = bytearray(path.read_bytes())
    start = data.index(b"GCOL\x01") + 16 + at
    data[start : start + len(held)] = held
    path.write_bytes(bytes(data))
    with pytest.raises(InputError) as refused:
        READER.read_header(path, {}, "raw/log.h5")
    assert refused.value.code in (FaultCode.FILE_DAMAGED, FaultCode.SIZE_EXCEEDED)
    assert refused.value.file == "raw/log.h5"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux bounds a process's memory")
def test_damaged_lengths_of_words_take_no_memory(tmp_path: Path) -> None:
    """A word's length stands before its heap's address; libhdf5 takes so much memory before it looks."""
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("t", data=np.arange(5.0)).attrs["unit"] = "s"
    data = bytearray(path.read_bytes())
    at = data.index(struct.pack("<IQ", 1, data.index(b"GCOL\x01")))
    data[at : at + 4] = b"\x00\x00\x00\xf0"
    path.write_bytes(bytes(data))
    with pytest.raises(InputError, match="no whole HDF5 file .*allocation failed"):
        READER.read_header(path, {})
    data[at : at + 4] = struct.pack("<I", 1)
    path.write_bytes(bytes(data))
    assert READER.read_header(path, {}).units == {"t": "s"}


def test_columns_in_groups_are_found(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "log.h5", "w") as file:
        columns(file)
        file.create_group("notes")
    with pytest.raises(InputError, match="give the group that contains it: hdf5.group = one of '/ids', '/notes'"):
        READER.read_header(tmp_path / "log.h5", {}, wanted=WANTED)


def test_the_only_group_below_the_top_needs_no_option(tmp_path: Path) -> None:
    path = tmp_path / "ids.h5"
    with h5py.File(path, "w") as file:
        group = file.create_group("cell/irc5")
        group["t"], group["A1"] = [0.0, 0.1], [1.0, 2.0]
    assert READER.read_header(path, {}).columns == ("A1", "t")
    with h5py.File(path, "a") as file:
        file.create_group("other")
    assert READER.read_header(path, {}).columns == ()
    with h5py.File(path, "w") as file:  # a group that holds itself
        file["again"] = file["/"]
    assert READER.read_header(path, {}).columns == ()

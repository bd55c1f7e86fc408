"""Parquet: whatever kind of number was written comes back; damaged files are named."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest

from stiffcal.errors import InputError
from stiffcal.readers import WantedColumns, find_reader
from tests.laboratory.log_reading import parse_here, read_columns, refusal

READER = find_reader(Path("x.parquet"))


def fault(path: Path, wanted: WantedColumns) -> str:
    return refusal(lambda: read_columns(READER, path, {}, wanted, "raw/ft.parquet"), "raw/ft.parquet")


def test_kinds_of_columns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parse_here(monkeypatch, 4)
    path = tmp_path / "ft.parquet"
    numbers = np.arange(10)
    field = pa.field("f", pa.float64(), metadata={"unit": "N"})
    arrays = [
        pa.array(numbers * 0.5),
        pa.array(numbers, pa.int16()),
        pa.array(numbers * 0.25, pa.float32()),
        pa.array([Decimal(int(number)) / 4 for number in numbers]),
        pa.array(numbers * 1500, pa.timestamp("ms", "UTC")),
        pa.array(["a", "b"] * 5).dictionary_encode(),
        pa.StructArray.from_arrays([pa.array(numbers * 2.0)], ["x"]),
    ]
    names = ["f", "i", "f32", "d", "when", "run", "pose"]
    schema = pa.schema([field, *(pa.field(n, a.type) for n, a in zip(names[1:], arrays[1:], strict=True))])
    parquet.write_table(pa.Table.from_arrays(arrays, schema=schema), path)
    wanted = WantedColumns(("f", "i", "f32", "d", "pose.x"), texts=("run",), times=("when",))
    header = READER.read_header(path, {}, wanted=wanted)
    assert header.n_rows == 10
    assert header.units == {"f": "N"}
    batches = list(READER.read_batches(path, {}, wanted))
    assert [batch.first_row for batch in batches] == [1, 5, 9]
    factors = {"f": 0.5, "i": 1, "f32": 0.25, "d": 0.25, "pose.x": 2, "when": 1.5}
    for name, factor in factors.items():
        assert np.array_equal(np.concatenate([batch.numbers[name] for batch in batches]), numbers * factor), name
    assert batches[1].texts["run"] == ["a", "b", "a", "b"]


def test_faults(tmp_path: Path) -> None:
    path = tmp_path / "ft.parquet"
    table = pa.table({"Fx": [1.0, None, 3.0], "Fy": [1.0, float("nan"), 2.0], "run": ["a", "b", "c"]})
    parquet.write_table(table, path)
    assert "no column 'fx'; did you mean 'Fx'?" in fault(path, WantedColumns(("fx",)))
    assert "row 2, column Fx: the cell is empty" in fault(path, WantedColumns(("Fx",)))
    assert "row 2, column Fy: nan is not a finite number" in fault(path, WantedColumns(("Fy",)))
    assert "column run: it contains string, not numbers" in fault(path, WantedColumns(("run",)))
    (batch,) = READER.read_batches(path, {}, WantedColumns(("Fx", "Fy"), gaps=frozenset({"Fx", "Fy"})))
    assert np.isnan(batch.numbers["Fx"]).tolist() == [False, True, False]
    whole = path.read_bytes()
    for size in (0, 3, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:size])
        assert "[file-damaged]" in fault(path, WantedColumns(("Fx",)))
    path.unlink()
    assert "no such file" in fault(path, WantedColumns(("Fx",)))
    parquet.write_table(table.slice(0, 0), path)
    assert "the table has no rows" in fault(path, WantedColumns(("Fx",)))


def test_a_flipped_bit_is_found(tmp_path: Path) -> None:
    path = tmp_path / "ft.parquet"
    table = pa.table({"Fx": np.random.default_rng(1).normal(size=1000)})
    parquet.write_table(table, path, write_page_checksum=True)
    content = bytearray(path.read_bytes())
    content[2000] ^= 1
    path.write_bytes(content)
    assert "[file-damaged]" in fault(path, WantedColumns(("Fx",)))


def test_rows_that_the_footer_counts_and_no_part_holds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "log.parquet"
    parquet.write_table(pa.table({"t": [0.0, 0.1, 0.2]}), path)
    parse_here(monkeypatch, 4)
    monkeypatch.setattr(parquet.ParquetFile, "iter_batches", lambda *_, **__: iter(()))
    with pytest.raises(InputError, match="0 rows where its footer has 3"):
        list(READER.read_batches(path, {}, WantedColumns(numbers=("t",)), "raw/log.parquet"))


def test_a_column_of_words_that_is_not_there(tmp_path: Path) -> None:
    parquet.write_table(pa.table({"Fx": [1.0, 2.0]}), tmp_path / "ft.parquet")
    with pytest.raises(InputError, match="no column 'run'"):
        list(
            find_reader(tmp_path / "ft.parquet").read_batches(
                tmp_path / "ft.parquet", {}, WantedColumns(("Fx",), ("run",))
            )
        )

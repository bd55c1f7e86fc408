"""Arrays of NumPy: columns by their names, matrices, records; what is pickled is never loaded."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import WantedColumns, find_reader
from tests.laboratory.log_reading import parse_here, read_columns

T = np.linspace(0.0, 1.0, 7)
Q = np.arange(14.0).reshape(7, 2)


def saved(path: Path, **arrays: Any) -> Path:
    with path.open("wb") as file:
        np.savez(file, **arrays)
    return path


def read(path: Path, wanted: WantedColumns, **options: object) -> dict[str, Any]:
    return read_columns(find_reader(path), path, options, wanted, "raw/log")


def fault(path: Path, wanted: WantedColumns, **options: object) -> InputError:
    with pytest.raises(InputError) as caught:
        read(path, wanted, **options)
    assert "\n" not in str(caught.value)
    return caught.value


def test_arrays_are_columns_and_matrices_have_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parse_here(monkeypatch, 3)
    when = np.datetime64("2026-11-20T10:00:00") + np.arange(7).astype("timedelta64[ms]")
    path = saved(tmp_path / "log.npz", t=T, q=Q, n=T[:, None], run=["a"] * 7, when=when, rate=100.0)
    header = find_reader(path).read_header(path, {})
    assert header.columns == ("t", "q[0]", "q[1]", "n", "run", "when")
    assert header.n_rows == 7
    found = read(path, WantedColumns(("t", "q[1]", "n"), ("run",), ("when",)))
    assert np.array_equal(found["q[1]"], Q[:, 1])
    assert np.array_equal(found["n"], T)
    assert found["when"][1] == pytest.approx(1_795_168_800.001, abs=1e-6)
    assert read(path, WantedColumns(("A1", "A2")), array="q", columns=["A1", "A2"])["A2"].tolist() == Q[:, 1].tolist()


@pytest.mark.parametrize("packed", [False, True])
def test_one_array_holds_all_columns(tmp_path: Path, packed: bool) -> None:
    path = tmp_path / "log.npy"
    if packed:
        path = saved(tmp_path / "log.npz", data=Q)
    else:
        np.save(path, Q)
    assert read(path, WantedColumns(("column2",)))["column2"].tolist() == Q[:, 1].tolist()
    assert read(path, WantedColumns(("Fx",)), columns=["t", "Fx"])["Fx"].tolist() == Q[:, 1].tolist()
    assert fault(path, WantedColumns(("t",)), columns=["t"]).code == FaultCode.SHAPE_MISMATCH
    records = np.zeros(7, dtype=[("t", "f4"), ("Fx", "i2")])
    np.save(tmp_path / "records.npy", records)
    assert read(tmp_path / "records.npy", WantedColumns(("t", "Fx")))["Fx"].tolist() == [0] * 7


def test_faults_are_one_line(tmp_path: Path) -> None:
    path = saved(tmp_path / "log.npz", t=T, Fx=T[:5], q=Q)
    assert fault(path, WantedColumns(("t", "Fx"))).code == FaultCode.FILE_INCOMPLETE
    assert fault(path, WantedColumns(("q",))).code == FaultCode.COLUMN_MISSING
    assert fault(path, WantedColumns(("t",)), array="r").code == FaultCode.LOG_PART_MISSING
    assert fault(path, WantedColumns(("t",)), columns=["a"]).code == FaultCode.SHAPE_MISMATCH
    bad = saved(tmp_path / "bad.npz", t=np.array([0.0, np.nan]), one=3.0)
    assert fault(bad, WantedColumns(("t",))).code == FaultCode.NUMBER_INVALID
    assert fault(saved(tmp_path / "one.npz", one=3.0), WantedColumns(("one",))).code == FaultCode.FILE_EMPTY
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    assert fault(path, WantedColumns(("t",))).code == FaultCode.FILE_DAMAGED


class Program:
    def __reduce__(self) -> tuple[Any, ...]:
        return (Path.touch, (Path("ran"),))


def test_objects_are_never_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    parse_here(monkeypatch, 100)
    path = tmp_path / "log.npz"
    with path.open("wb") as file:
        np.savez(file, t=T, Fx=np.array([Program()], dtype=object))
    assert fault(path, WantedColumns(("t",))).code == FaultCode.CONTENT_UNSUPPORTED
    with path.open("wb") as file:
        np.save(file, np.array([Program()], dtype=object))
    assert fault(path, WantedColumns(("Fx",))).code == FaultCode.CONTENT_UNSUPPORTED
    assert not (tmp_path / "ran").exists()


def test_a_head_that_promises_more_than_the_file_holds_is_one_line(tmp_path: Path) -> None:
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (10**13,)})
    (tmp_path / "log.npy").write_bytes(stream.getvalue() + bytes(80))
    assert fault(tmp_path / "log.npy", WantedColumns(("column1",))).code in (
        FaultCode.SIZE_EXCEEDED,
        FaultCode.FILE_DAMAGED,
    )
    with zipfile.ZipFile(tmp_path / "log.npz", "w") as archive:
        archive.writestr("t.npy", stream.getvalue() + bytes(80))
    assert fault(tmp_path / "log.npz", WantedColumns(("t",))).code in (
        FaultCode.SIZE_EXCEEDED,
        FaultCode.FILE_DAMAGED,
    )


def test_a_head_that_is_code_is_refused_in_words_of_a_person(tmp_path: Path) -> None:
    path = tmp_path / "log.npy"
    np.save(path, Q)
    path.write_bytes(path.read_bytes().replace(b"(7, 2)", b"exit()"))
    error = fault(path, WantedColumns(("column1",)))
    assert error.faults[0].code == FaultCode.FILE_DAMAGED
    assert "0x" not in str(error)

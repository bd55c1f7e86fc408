"""MAT: vectors, structs, matrices and cells of words, of version 5 by scipy and of 7.3 as MATLAB lays it out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from stiffcal.errors import InputError
from stiffcal.readers import WantedColumns, find_reader
from tests.laboratory.log_reading import parse_here, read_columns, refusal

READER = find_reader(Path("x.mat"))
FORCE = np.sin(np.arange(1000) / 50.0)
TIME = np.arange(1000) * 0.001
MATRIX = np.random.default_rng(1).normal(size=(1000, 3))


def write73(path: Path, variables: dict[str, Any]) -> Path:
    """Write as MATLAB's ``save -v7.3`` does: arrays transposed, structs as groups, cells as references."""
    with h5py.File(path, "w", userblock_size=512) as file:
        references = file.create_group("#refs#")

        def put(group: h5py.Group, name: str, value: Any) -> None:
            if isinstance(value, dict):
                inner = group.create_group(name)
                inner.attrs["MATLAB_class"] = np.bytes_("struct")
                for key, held in value.items():
                    put(inner, key, held)
            elif isinstance(value, list):
                cells = np.empty((1, len(value)), dtype=h5py.ref_dtype)
                for k, word in enumerate(value):
                    text = np.array([[ord(letter)] for letter in word], dtype=np.uint16)
                    dataset = references.create_dataset(f"{name}{k}", data=text)
                    dataset.attrs["MATLAB_class"] = np.bytes_("char")
                    cells[0, k] = dataset.ref
                group.create_dataset(name, data=cells, dtype=h5py.ref_dtype).attrs["MATLAB_class"] = np.bytes_("cell")
            else:
                array = np.atleast_2d(value)
                array = array if value.ndim == 2 else array.T  # a vector is a column in MATLAB
                group.create_dataset(name, data=array.T, chunks=True).attrs["MATLAB_class"] = np.bytes_("double")

        for name, value in variables.items():
            put(file, name, value)
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")
    return path


def write5(path: Path, variables: dict[str, Any]) -> Path:
    def made(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: made(held) for key, held in value.items()}
        if isinstance(value, list):
            return np.array([value], dtype=object).T
        return value

    savemat(path, made(variables), do_compression=True, oned_as="column")
    return path


WRITERS = pytest.mark.parametrize("write", [write5, write73], ids=["v5", "v7.3"])


def read(path: Path, wanted: WantedColumns, **options: object) -> dict[str, Any]:
    return read_columns(READER, path, options, wanted, "raw/log.mat")


def fault(path: Path, wanted: WantedColumns, **options: object) -> str:
    return refusal(lambda: read(path, wanted, **options))


@WRITERS
@pytest.mark.parametrize(
    ("variables", "options"),
    [
        ({"t": TIME, "Fx": FORCE}, {}),
        ({"log": {"t": TIME, "Fx": FORCE}}, {}),
        ({"log": {"t": TIME, "Fx": FORCE}, "note": TIME[:3]}, {"variable": "log"}),
        ({"data": {"ft": {"t": TIME, "Fx": FORCE}, "other": TIME[:3]}}, {"variable": "data.ft"}),
        ({"log": np.stack([TIME, FORCE], axis=1)}, {"variable": "log", "columns": ["t", "Fx"]}),
    ],
)
def test_layouts(tmp_path: Path, write: Any, variables: dict[str, Any], options: dict[str, Any],
                 monkeypatch: pytest.MonkeyPatch) -> None:  # fmt: skip
    parse_here(monkeypatch, 300)
    path = write(tmp_path / "log.mat", variables)
    found = read(path, WantedColumns(("t", "Fx")), **options)
    assert np.array_equal(found["t"], TIME)
    assert np.array_equal(found["Fx"], FORCE)


@WRITERS
def test_words_and_matrices_among_vectors(tmp_path: Path, write: Any) -> None:
    path = write(tmp_path / "log.mat", {"run": ["pose1", "pose2", "pose2"], "F": MATRIX[:3]})
    found = read(path, WantedColumns(("F[1]", "F[3]"), texts=("run",)))
    assert found["run"].tolist() == ["pose1", "pose2", "pose2"]
    assert np.array_equal(found["F[3]"], MATRIX[:3, 2])
    assert READER.read_header(path, {}).columns == ("run", "F[1]", "F[2]", "F[3]") or write is write73
    assert READER.read_header(path, {}).n_rows == 3


@WRITERS
def test_faults_are_one_clear_line(tmp_path: Path, write: Any) -> None:
    path = write(tmp_path / "log.mat", {"t": TIME, "Fx": FORCE[:990], "log": MATRIX})
    assert "column Fx: 990 rows, column t has 1000" in fault(path, WantedColumns(("t", "Fx")))
    assert "no column 'fx'; did you mean 'Fx'?" in fault(path, WantedColumns(("fx",)))
    assert "mat.variable: no variable 'lug'; did you mean 'log'?" in fault(path, WantedColumns(("t",)), variable="lug")
    assert "variable log: its columns have no names: 3 columns" in fault(path, WantedColumns(("t",)), variable="log")
    assert "2 names for 3 columns" in fault(path, WantedColumns(("t",)), variable="log", columns=["a", "b"])
    assert "mat.columns: 'a' is not a list" in fault(path, WantedColumns(("t",)), columns="a")
    bad = write(tmp_path / "bad.mat", {"Fx": np.array([1.0, np.nan])})
    assert "row 2, column Fx: nan is not a finite number" in fault(bad, WantedColumns(("Fx",)))


@WRITERS
@pytest.mark.parametrize("keep", [0.3, 0.9])
def test_a_cut_off_file_is_refused(tmp_path: Path, write: Any, keep: float) -> None:
    path = write(tmp_path / "log.mat", {"t": TIME, "Fx": FORCE})
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * keep)])
    reported = fault(path, WantedColumns(("t", "Fx")))
    assert "raw/log.mat: " in reported


def test_what_only_matlab_reads_is_named(tmp_path: Path) -> None:
    path = write73(tmp_path / "log.mat", {"T": {"x": TIME}})
    with h5py.File(path, "r+") as file:
        del file["T"]
        file.create_dataset("T", data=np.zeros((1, 6), np.uint32)).attrs["MATLAB_class"] = np.bytes_("timetable")
    reported = fault(path, WantedColumns(("x",)))
    assert "'T' is a MATLAB timetable, which only MATLAB can read" in reported
    assert "writetimetable(" in reported


def test_damage_that_would_end_the_library_is_refused(tmp_path: Path) -> None:
    """A size that is wrong leads scipy's reader out of its memory, or into reading for hours."""
    from scipy.io import savemat
    from scipy.sparse import csc_matrix

    path = tmp_path / "log.mat"
    savemat(path, {"t": TIME, "Fx": FORCE, "s": {"a": csc_matrix(np.eye(3)), "b": ["x", "yy"]}}, oned_as="column")
    assert len(list(READER.read_batches(path, {}, WantedColumns(("t", "Fx")), "raw/log.mat"))) == 1
    whole = path.read_bytes()
    dimensions = whole.index((1000).to_bytes(4, "little") + (1).to_bytes(4, "little"))
    for at, what in ((dimensions, b"\xff\xff\xff\x0f"), (132, b"\xff\xff\xff\x7f")):
        path.write_bytes(whole[:at] + what + whole[at + len(what) :])
        with pytest.raises(InputError, match="^raw/log.mat: "):
            list(READER.read_batches(path, {}, WantedColumns(("t", "Fx")), "raw/log.mat"))


@pytest.mark.parametrize(("kind", "line"), [("table", "writetable(T,"), ("timetable", "writetimetable(T,")])
def test_a_table_of_matlab_is_refused_with_the_line_that_exports_it(tmp_path: Path, kind: str, line: str) -> None:
    path = tmp_path / "log.mat"
    for others in ((), ("t",)):
        with h5py.File(path, "w") as file:
            for name in ("T", *others):
                held = np.bytes_(kind if name == "T" else "double")
                file.create_dataset(name, data=np.zeros((1, 6))).attrs["MATLAB_class"] = held
        with pytest.raises(InputError) as caught:
            find_reader(path).read_header(path, {}, "raw/log.mat", WantedColumns(("Fx",)))
        assert line in str(caught.value)

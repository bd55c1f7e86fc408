"""Formats are found by walking the folder; all of them meet one contract."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from stiffcal.campaign.found import file_formats
from stiffcal.campaign.found.file_formats import format_names
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.timestamps import seconds_of_times
from stiffcal.parsers.signatures import not_a_log
from stiffcal.propose.table_sniffing import sniff_table
from stiffcal.readers import WantedColumns, find_reader

TWINS = {"mcap": "rosbags", "rosbag1": "rosbags", "rosbag2": "rosbags"}  # one library, one test


@pytest.mark.parametrize("name", format_names())
def test_every_format_meets_the_contract(name: str, tmp_path: Path) -> None:
    reader = find_reader(Path("no-matter"), name)
    assert reader.name == name
    assert (reader.__doc__ or "").strip()
    assert (Path(__file__).parent / f"test_{TWINS.get(name, name)}.py").exists(), "a reader needs its twin test"
    with pytest.raises(InputError):
        list(reader.read_batches(tmp_path / "missing", {}, WantedColumns(("x",)), "missing"))
    (tmp_path / "junk").write_bytes(b"\x01\x02junk")
    # A database's source is a name in the manifest, not a file.
    with pytest.raises(InputError, match="^campaign.toml: file" if name == "postgres" else "^junk: "):
        list(reader.read_batches(tmp_path / "junk", {}, WantedColumns(("x",)), "junk"))


ENDINGS = {
    "csv": ("a.csv", "a.CSV", "a.tsv", "a.csv.gz"),
    "hdf5": ("a.h5", "a.hdf5"),
    "parquet": ("a.parquet", "a.pq"),
}


@pytest.mark.parametrize(("file", "name"), [(file, name) for name, files in ENDINGS.items() for file in files])
def test_the_ending_shows_the_format(file: str, name: str) -> None:
    assert find_reader(Path(file)).name == name


def test_unknown_formats_are_named() -> None:
    with pytest.raises(InputError, match="no reader for format 'cvs'; did you mean 'csv'"):
        find_reader(Path("a.csv"), "cvs")
    reason = "the format cannot be determined from the file; write format = one of c3d, csv, hdf5"
    with pytest.raises(InputError, match=reason):
        find_reader(Path("a.xyz"))


NO_LOGS = {
    "PDF": b"%PDF-1.7\n%\xe2\xe3\n",
    "picture": b"\xff\xd8\xff\xe0\0\x10JFIF",
    "video": b"\0\0\0\x18ftypmp42",
    "archive": b"PK\x03\x04" + bytes(26) + b"logs/a.csv",
    "office": b"PK\x03\x04" + bytes(26) + b"word/document.xml",
    "web page": b"<!DOCTYPE html>\n<table>",
    "pickled": b"\x80\x04\x95\x10\0",
}


@pytest.mark.parametrize("name", ["log", "log.csv"])
@pytest.mark.parametrize("kind", NO_LOGS)
def test_what_is_no_log_is_named(kind: str, name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(NO_LOGS[kind])
    for read in (lambda path: find_reader(path).read_header(path, {}), sniff_table):
        with pytest.raises(InputError, match=kind) as caught:
            read(tmp_path / name)
        assert caught.value.faults[0].code is FaultCode.FORMAT_UNKNOWN


def test_text_is_not_taken_for_a_document() -> None:
    assert not any(not_a_log(start) for start in (b"MZ,Fx,Fy\n1,2,3", b"BM 1;2\n3;4", b"<Rob TYPE=", b"PKW,x\n", b""))


def test_a_csv_log_costs_no_other_formats_import() -> None:
    script = """
import sys, pathlib, tempfile
from stiffcal.readers import WantedColumns, find_reader
path = pathlib.Path(tempfile.mkdtemp(), "a.csv")
path.write_text("t,run\\n1,a\\n")
assert len(list(find_reader(path).read_batches(path, {}, WantedColumns(("t",), texts=("run",))))) == 1
print(sorted({"h5py", "pandas", "pyarrow.dataset"} & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another package brings two formats: one that is there, and one whose module is not."""
    group = file_formats.READERS
    points = (
        EntryPoint("jsonrows", "tests.laboratory.dropped_in.readers.jsonrows:READER", group),
        EntryPoint("broken", "no_such_package.reader:READER", group),
    )
    monkeypatch.setattr(file_formats, "_outside", lambda: points)


@pytest.mark.usefixtures("installed")
def test_a_format_of_another_package_is_found_by_its_entry_point() -> None:
    assert {"jsonrows", "broken", "csv"} <= set(format_names())
    assert find_reader(Path("x"), "jsonrows").name == "jsonrows"
    assert file_formats.format_of("raw/log.jrows") == "jsonrows"
    assert find_reader(Path("raw/log.jrows")).name == "jsonrows"


@pytest.mark.usefixtures("installed")
def test_a_format_that_cannot_be_imported_is_one_line() -> None:
    with pytest.raises(InputError) as caught:
        find_reader(Path("x"), "broken")
    assert str(caught.value) == (
        "installed packages: no_such_package.reader:READER: the reader 'broken' cannot be imported "
        "(ModuleNotFoundError); install its package again, or remove it [library-missing]"
    )


def test_times_without_a_fraction_or_zone() -> None:
    assert seconds_of_times(["1970-01-01T00:00:01", "19700101T000002Z"], "", "t", 1).tolist() == [1, 2]
    with pytest.raises(InputError, match="row 8, column t: '12.5' is no date or time"):
        seconds_of_times(["1970-01-01T00:00:01.5", "12.5"], "log.csv", "t", 7)

"""C3D: markers and channels, each at its rate; a marker out of sight is an empty cell."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.extras import install_command
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import WantedColumns, find_reader
from tests.laboratory.log_reading import parse_here, read_columns

ezc3d = pytest.importorskip("ezc3d")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    log = ezc3d.c3d()
    points = np.ones((4, 2, 20))
    points[:3, 0] = np.arange(60.0).reshape(3, 20)
    points[:3, 1, 5] = np.nan  # a marker out of sight
    for name, value in (("RATE", [100.0]), ("LABELS", ("probe", "base")), ("UNITS", ("mm",))):
        log["parameters"]["POINT"][name]["value"] = value
    log["data"]["points"] = points
    for name, value in (("RATE", [1000.0]), ("LABELS", ("Fx", "Fy")), ("UNITS", ("N", "N"))):
        log["parameters"]["ANALOG"][name]["value"] = value
    log["data"]["analogs"] = np.arange(400.0).reshape(1, 2, 200)
    log.write(str(tmp_path / "take.c3d"))
    return tmp_path / "take.c3d"


def fault(path: Path, wanted: WantedColumns, **options: object) -> FaultCode:
    with pytest.raises(InputError) as caught:
        read_columns(find_reader(path), path, options, wanted, "raw/log")
    assert "\n" not in str(caught.value)
    return caught.value.code


def test_markers_and_channels(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parse_here(monkeypatch, 7)
    header = find_reader(path).read_header(path, {})
    assert header.columns[:4] == ("time", "probe X", "probe Y", "probe Z")
    assert (header.units["probe Z"], header.n_rows) == ("mm", 20)
    found = read_columns(find_reader(path), path, {}, WantedColumns(("time", "probe Y")))
    assert found["probe Y"].tolist() == list(range(20, 40))
    assert np.allclose(found["time"], np.arange(20) / 100.0, rtol=1e-15)
    analog: dict[str, Any] = {"data": "analog"}
    assert find_reader(path).read_header(path, analog).units == {"time": "s", "Fx": "N", "Fy": "N"}
    found = read_columns(find_reader(path), path, analog, WantedColumns(("time", "Fy")))
    assert found["Fy"].tolist() == list(range(200, 400))
    assert np.allclose(found["time"][:3], [0.0, 0.001, 0.002], rtol=1e-15)


def test_a_marker_out_of_sight_is_a_gap(path: Path) -> None:
    assert fault(path, WantedColumns(("base X",))) == FaultCode.NUMBER_INVALID
    wanted = WantedColumns(("base X",), gaps=frozenset(("base X",)))
    assert np.flatnonzero(np.isnan(read_columns(find_reader(path), path, {}, wanted)["base X"])).tolist() == [5]


def test_damaged_files_are_one_line(path: Path) -> None:
    content = path.read_bytes()
    for spoilt in (b"", content[:100], content[: len(content) // 2], b"\x02\x50" + b"a" * 2000, b"junk" * 500):
        path.write_bytes(spoilt)
        assert fault(path, WantedColumns(("time", "probe X"))) in (FaultCode.FILE_DAMAGED, FaultCode.FILE_INCOMPLETE)


def test_a_missing_library_is_one_line(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    parse_here(monkeypatch, 100)
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    with pytest.raises(InputError) as caught:
        find_reader(path).read_header(path, {})
    assert caught.value.code == FaultCode.LIBRARY_MISSING
    assert install_command("c3d") in str(caught.value)

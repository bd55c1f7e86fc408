"""campaign.toml: what the interface writes is understood, key by key."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from stiffcal.campaign.found.file_formats import format_of
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.manifest_type import manifest_type
from stiffcal.campaign.signals.row_filter import RowCondition, parse_rows
from stiffcal.campaign.signals.signals import Deflection, JointSignals, Pose, Wrench
from stiffcal.campaign.toml.typed import WrongValueError, expand_columns
from tests.laboratory.campaign_folders import DATA, write_campaign


def read(name: str) -> Manifest:
    return manifest_type().model_validate(tomllib.loads((DATA / name).read_text(encoding="utf-8")))


def test_shortest_manifest_and_its_defaults() -> None:
    manifest = read("interface_campaign_short.toml")
    table = manifest.sources["table"]
    assert table.is_states
    assert table.format_for("raw/table.csv") == "csv"
    assert table.joints is not None
    assert table.joints.position == ("A1", "A2", "A3", "A4", "A5", "A6")
    assert table.wrench is not None
    assert (table.wrench.axes_frame, table.wrench.point_frame) == ("base", "tool")
    assert not table.wrench.moments_measured
    assert manifest.frames["tool"].rotations() == ()
    assert manifest.files_of("table") == {"": "raw/table.csv"}
    assert table.columns() == ("A1", "A2", "A3", "A4", "A5", "A6", "Fx", "Fy", "Fz", "dx", "dy", "dz")


def test_full_manifest_of_the_interface() -> None:
    manifest = read("interface_campaign_full.toml")
    assert list(manifest.sources) == ["ft", "tracker", "controller", "ids"]
    assert manifest.frames["tracker"].estimate
    assert manifest.files_of("tracker", manifest.runs[0]) == {"": "raw/pose01_tracker.csv"}
    units = manifest.sources["tracker"].signals()["pose"].columns_with_units()
    assert units["X"].factor == 1e-3
    assert "q0" not in units
    assert manifest.sources["ft"].signals()["wrench"].columns_with_units()["Tz"].name == "N*m"


def test_every_key_parses() -> None:
    manifest = read("everything.toml")
    assert [(source, name) for source, name, _ in manifest.signals()] == [
        ("table", "joints"),
        ("table", "dead_weight"),
        ("table", "displacement"),
        ("table", "temperature"),
        ("table", "hold"),
        ("split", "joints"),
        ("split", "wrench"),
        ("split", "deflection"),
        ("k600", "poses.on_arm"),
        ("k600", "poses.target"),
        ("ids", "lengths"),
        ("motors", "joints"),
    ]
    poses = manifest.sources["k600"].body_poses()
    assert list(poses) == ["on_arm", "target"]
    assert poses["target"].markers["m3"].columns == ("m3x", "m3y", "m3z")
    assert poses["on_arm"].columns_with_units()["a3"].name == "deg"
    assert manifest.sources["split"].columns()[0] == "test_nr"
    compliance = manifest.runs[1].fixture_compliance
    assert compliance is not None
    assert compliance[0] == (1e-8, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert manifest.thresholds.min_stiffness == {"A1": 1e5}


@pytest.mark.parametrize(
    ("text", "columns"),
    [
        ("A1..A6", ("A1", "A2", "A3", "A4", "A5", "A6")),
        ("q08..q10", ("q08", "q09", "q10")),
        ("A1..3", ("A1", "A2", "A3")),
        ("s", ("s",)),
        (["Fx", "T1..T2"], ("Fx", "T1", "T2")),
    ],
)
def test_ranges_are_written_out(text: object, columns: tuple[str, ...]) -> None:
    assert expand_columns(text) == columns


@pytest.mark.parametrize("text", ["A1..B6", "A6..A1", "A..B", [], [1], "", ["x", "x"], 7])
def test_what_is_no_range_is_refused(text: object) -> None:
    with pytest.raises(WrongValueError):
        expand_columns(text)


def test_rows_conditions() -> None:
    assert parse_rows("\"test nr\" >= 100 and phase != 'up'") == (
        RowCondition("test nr", ">=", 100.0),
        RowCondition("phase", "!=", "up"),
    )
    for wrong in ("", "test_nr", "a < b", "a <", "a < 1 or b > 2", "phase < 'up'"):
        with pytest.raises(WrongValueError):
            parse_rows(wrong)


@pytest.mark.parametrize(
    ("file", "expected"),
    [("a/b.CSV", "csv"), ("x.h5", "hdf5"), ("x.parquet", "parquet"), ("x.tdms", "tdms"), ("x", None)],
)
def test_format_from_ending(file: str, expected: str | None) -> None:
    assert format_of(file) == expected


@pytest.mark.parametrize(
    ("signal", "document", "reason"),
    [
        (JointSignals, {"units": {"position": "deg"}}, "no columns are given"),
        (JointSignals, {"position": "A1..A6", "velocity": "v1..v5"}, "unequal numbers"),
        (JointSignals, {"position": "A1..A6", "units": {"position": "N"}}, "unit of force"),
        (Wrench, {"columns": ["Fx", "Fy"]}, "2 columns"),
        (Wrench, {"columns": "F1..F3", "units": {"force": "stone"}}, "not a known unit of force"),
        (Pose, {"frame": "tracker"}, "either position or markers"),
        (Pose, {"position": "p1..p3", "rpy": "r1..r3", "rotvec": "v1..v3"}, "given twice"),
        (Pose, {"markers": {"a": "a1..a3", "b": "b1..b3"}}, "2 markers"),
        (Deflection, {"translation": "d1..d2", "body": "tool"}, "2 columns"),
        (Deflection, {"translation": "d1..d3", "body": "tool", "rows": "x is 3"}, "not a condition"),
    ],
)
def test_signal_faults(signal: type[Any], document: dict[str, Any], reason: str) -> None:
    with pytest.raises(ValidationError, match=reason):
        signal.model_validate(document)


def test_importing_the_manifest_is_light() -> None:
    code = (
        "import sys, stiffcal.campaign.loading;"
        "print([m for m in ('numpy', 'scipy', 'pandas', 'pyarrow', 'tomlkit') if m in sys.modules])"
    )
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"
    )


def test_loading_a_campaign_of_text_logs_imports_no_format(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c")
    code = (
        "import sys, pathlib, stiffcal.campaign.loading as loading;"
        f"loading.load_campaign(pathlib.Path({str(folder)!r}));"
        "print(sorted(name for name in sys.modules if name.startswith('stiffcal.readers.') or name == 'pyarrow'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"

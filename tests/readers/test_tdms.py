"""TDMS: channels of a group, waveforms' times, and writers that were interrupted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter

from stiffcal.readers import WantedColumns, find_reader
from tests.laboratory.log_reading import parse_here, read_columns, refusal

READER = find_reader(Path("x.tdms"))
FORCE = np.sin(np.arange(1000) / 50.0)
TIME = np.arange(1000) * 0.001


def write(path: Path, n_force: int = 1000, segments: int = 2, group: str = "ft") -> Path:
    with TdmsWriter(path) as writer:
        for part in np.array_split(np.arange(1000), segments):
            channels = [
                ChannelObject(group, "t", TIME[part]),
                ChannelObject(group, "Fx", FORCE[part[part < n_force]], {"unit_string": "kN"}),
            ]
            writer.write_segment(channels)
    return path


def fault(path: Path, wanted: WantedColumns, **options: object) -> str:
    return refusal(lambda: read_columns(READER, path, options, wanted, "raw/log.tdms"))


def test_channels_come_in_batches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parse_here(monkeypatch, 300)
    path = write(tmp_path / "log.tdms", segments=3)
    header = READER.read_header(path, {})
    assert header.columns == ("t", "Fx")
    assert header.units == {"Fx": "kN"}
    assert header.n_rows == 1000
    batches = list(READER.read_batches(path, {}, WantedColumns(("t", "Fx"))))
    assert [batch.first_row for batch in batches] == [1, 301, 601, 901]
    assert np.array_equal(np.concatenate([batch.numbers["Fx"] for batch in batches]), FORCE)
    assert np.array_equal(np.concatenate([batch.numbers["t"] for batch in batches]), TIME)


def test_waveforms_have_times(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parse_here(monkeypatch, 600)
    path = tmp_path / "log.tdms"
    with TdmsWriter(path) as writer:
        waveform = {"wf_increment": 0.002, "wf_start_offset": 1.0, "wf_samples": 1000}
        writer.write_segment([ChannelObject("ft", "Fx", FORCE, waveform)])
    times = [batch.numbers["time"] for batch in READER.read_batches(path, {}, WantedColumns(("time", "Fx")))]
    assert np.allclose(np.concatenate(times), 1.0 + 0.002 * np.arange(1000), rtol=0, atol=1e-12)
    assert READER.read_header(path, {}).units == {"time": "s"}


def test_absolute_times_and_words(tmp_path: Path) -> None:
    path = tmp_path / "log.tdms"
    moments = np.datetime64("2026-11-21T08:15:30", "us") + np.arange(3) * np.timedelta64(250_000, "us")
    with TdmsWriter(path) as writer:
        words = ChannelObject("ft", "run", ["pose1", "pose1", "pose2"])
        writer.write_segment([ChannelObject("ft", "t", moments), words, ChannelObject("ft", "Fx", FORCE[:3])])
    (batch,) = READER.read_batches(path, {}, WantedColumns(("Fx",), texts=("run",), times=("t",)))
    assert np.allclose(np.diff(batch.numbers["t"]), 0.25, atol=1e-6)
    assert batch.numbers["t"][0] == pytest.approx(1795248930.0, abs=1e-3)
    assert batch.texts["run"] == ["pose1", "pose1", "pose2"]


def test_unequal_lengths_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "log.tdms", n_force=990, segments=1)
    reported = fault(path, WantedColumns(("t", "Fx")))
    assert "raw/log.tdms: column Fx: 990 rows, column t has 1000: writing was interrupted" in reported


@pytest.mark.parametrize("missing", [8, 4000, 9000])
def test_a_cut_off_file_is_refused(tmp_path: Path, missing: int, capfd: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path / "log.tdms")
    path.write_bytes(path.read_bytes()[:-missing])
    reported = fault(path, WantedColumns(("t", "Fx")))
    assert "\n" not in reported
    assert "the last segment is not complete" in reported or "no whole TDMS file" in reported
    assert capfd.readouterr() == ("", "")  # the library's own log lines stay away


def test_groups_and_options_are_named(tmp_path: Path) -> None:
    path = write(tmp_path / "log.tdms", group="Sensor")
    assert "no group 'sensor'; did you mean 'Sensor'?" in fault(path, WantedColumns(("Fx",)), group="sensor")
    assert "tdms.grup: no such option" in fault(path, WantedColumns(("Fx",)), grup="a")
    assert "no column 'fx'; did you mean 'Fx'?" in fault(path, WantedColumns(("fx",)))
    path.write_bytes(b"TDSm" + bytes(60))
    assert "raw/log.tdms: " in fault(path, WantedColumns(("Fx",)))


def test_not_finite_is_placed(tmp_path: Path) -> None:
    path = tmp_path / "log.tdms"
    with TdmsWriter(path) as writer:
        writer.write_segment([ChannelObject("ft", "Fx", np.array([1.0, np.nan, 2.0]))])
    assert "row 2, column Fx: nan is not a finite number" in fault(path, WantedColumns(("Fx",)))

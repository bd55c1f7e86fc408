"""Logs that hold the readings of another run, as they are or rounded, are noticed; runs of one programme are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.ingest.quality.data_quality import ReadLog
from stiffcal.ingest.reading.read_run import ReadRun
from stiffcal.ingest.reading.run_texts import stored_text, text_of
from stiffcal.reduction.logs.copied_logs import CopiedRuns, copied_log_warnings, copied_runs
from stiffcal.reduction.logs.plausibility import LogQuality
from stiffcal.reduction.logs.sampled_readings import MOST_ROWS, ReadingSampler
from stiffcal.reduction.logs.summary import LogSummary
from tests.laboratory.friction_campaigns import rehearsed, set_keys
from tests.long_campaigns.campaign import write_head, write_runs

ROWS, RATE = 1500, 100.0
COLUMNS = {
    "joints.torque": ("T1", "T2"),
    "joints.current": ("I1",),
    "wrench": ("Fx", "Fy", "Fz"),
    "position.target": ("X", "Y", "Z"),
    "translation": ("dx", "dy", "dz"),
    "displacement.gauge": ("d",),
    "lengths.rod": ("l",),
}
# lbf, mm, and the torque of a motor behind a gear
UNITS = dict.fromkeys(("Fx", "Fy", "Fz"), 4.4482216) | dict.fromkeys(("X", "Y", "Z", "dx", "dy", "dz", "d", "l"), 1e-3)
UNITS |= dict.fromkeys(("T1", "T2"), 0.113 * 121.3)


def programme(channels: int) -> Floats:
    """Return (c, n) what is driven in each run: up and down past zero, in each channel another share."""
    time = np.arange(ROWS) / RATE
    return 10.0 * np.outer(np.linspace(1.0, 0.1, channels), np.sin(2.0 * np.pi * time / 6.0))


def measured(channels: int, noise: float, seed: int, resolution: float = 1e-4) -> Floats:
    """Return (c, n) what an instrument of this resolution reads of the programme."""
    middle = 25.0 * np.arange(channels)[:, None]
    readings = middle + programme(channels) + noise * np.random.default_rng(seed).standard_normal((channels, ROWS))
    return resolution * np.round(readings / resolution)


def seen(file: str, signal: str, readings: Floats, batch: int = ROWS) -> LogSummary:
    """Return the summary of a log that holds readings (c, n) in its own units, read in batches."""
    columns = {signal: COLUMNS[signal][: len(readings)]}
    log = LogQuality(file, "line {}".format, True, columns, sampler=ReadingSampler(columns, UNITS))
    values = np.array([[UNITS.get(column, 1.0)] for column in columns[signal]]) * readings
    for start in range(0, readings.shape[1], batch):
        own = np.arange(start, min(start + batch, readings.shape[1]))
        log.update(own + 1, own / RATE, {signal: values[:, own]})
    return log.summary()


def found_in(signal: str, **runs: Floats) -> list[CopiedRuns]:
    return copied_runs({("log", f"raw/{run}.csv", run): seen(f"raw/{run}.csv", signal, of) for run, of in runs.items()})


@pytest.mark.parametrize("signal", list(COLUMNS))
@pytest.mark.parametrize("decimals", [4, 3, 1])
def test_a_copy_of_a_run_is_named_whatever_it_logs(signal: str, decimals: int) -> None:
    channels = len(COLUMNS[signal])
    first, other = measured(channels, 0.2, 1), measured(channels, 0.2, 2)
    found = found_in(signal, a=first, b=other, c=np.round(first, decimals))
    assert found == [CopiedRuns(("a", "c"), ("raw/a.csv", "raw/c.csv"))]
    (warning,) = copied_log_warnings(found)
    assert "raw/a.csv" in warning
    assert "raw/c.csv" in warning


def test_digits_that_are_counted_from_the_first() -> None:
    """Four digits of each number, as a spreadsheet writes them."""
    first = measured(3, 0.2, 1, resolution=1e-6)
    short = np.array([[float(f"{value:.4g}") for value in row] for row in first])
    assert len(found_in("wrench", a=first, b=short)) == 1


def test_readings_that_are_rounded_to_zero() -> None:
    first = np.round(0.2 * np.random.default_rng(1).standard_normal((1, ROWS)), 4)
    assert len(found_in("joints.current", a=first, b=np.round(first, 1))) == 1


def test_copies_of_one_run_are_one_entry() -> None:
    first, other = measured(3, 0.2, 1), measured(3, 0.2, 2)
    found = found_in("wrench", a=first, b=np.round(first, 1), c=other, d=first, e=np.round(other, 2))
    assert [own.runs for own in found] == [("a", "b", "d"), ("c", "e")]


def test_logs_of_several_instruments_are_one_entry() -> None:
    force, place = measured(3, 0.2, 1), measured(3, 0.01, 2)
    logs = {
        (source, f"raw/{run}-{source}.csv", run): seen(f"raw/{run}-{source}.csv", signal, readings)
        for run in ("a", "b")
        for source, signal, readings in (("ft", "wrench", force), ("tracker", "position.target", place))
    }
    (found,) = copied_runs(logs)
    assert found.runs == ("a", "b")
    assert found.files == ("raw/a-ft.csv", "raw/b-ft.csv", "raw/a-tracker.csv", "raw/b-tracker.csv")


@pytest.mark.parametrize("resolution", [1e-4, 0.1, 0.4, 2.0])
@pytest.mark.parametrize("channels", [1, 3])
def test_runs_of_one_programme_are_no_copies(resolution: float, channels: int) -> None:
    """Coarse sensors among them: noise is a twentieth to two thousand times of what they resolve."""
    runs = {f"run{seed}": measured(channels, 0.2 if resolution < 2.0 else 0.1, seed, resolution) for seed in range(30)}
    assert found_in("wrench", **runs) == []


@pytest.mark.parametrize("signal", ["wrench", "joints.torque"])
def test_runs_that_were_rounded_otherwise_are_no_copies(signal: str) -> None:
    channels = len(COLUMNS[signal])
    runs = {f"run{seed}": np.round(measured(channels, 0.2, seed), seed % 3) for seed in range(30)}
    assert found_in(signal, **runs) == []


@pytest.mark.parametrize("resolution", [0.1, 0.125, 0.5])
def test_readings_without_noise_that_climb_in_steps_are_no_copies(resolution: float) -> None:
    """The last digit is all that two runs could differ by."""
    readings = measured(3, 0.0, 1, resolution)
    assert found_in("wrench", a=readings, b=readings) == []


def test_a_log_that_agrees_in_one_channel_of_three_is_no_copy() -> None:
    """What one column shows is what was commanded."""
    first, other = measured(3, 0.2, 1), measured(3, 0.2, 2)
    other[0] = first[0]
    assert found_in("wrench", a=first, b=other) == []


@pytest.mark.parametrize("batch", [1, 7, 640])
def test_the_same_rows_are_taken_however_a_log_is_read(batch: int) -> None:
    readings = measured(3, 0.2, 1)[:, :700]
    whole, pieces = (seen("raw/a.csv", "wrench", readings, size).readings for size in (700, batch))
    assert whole is not None
    assert pieces is not None
    assert MOST_ROWS // 2 <= len(whole.values) <= MOST_ROWS
    np.testing.assert_array_equal(whole.values, pieces.values)
    np.testing.assert_array_equal(whole.scatter, pieces.scatter)


def test_what_is_stored_of_a_run_compares_as_what_was_read() -> None:
    first = measured(3, 0.2, 1)
    logs = {}
    for run, readings in (("a", first), ("b", np.round(first, 1))):
        summary = seen(f"raw/{run}.csv", "wrench", readings)
        text = text_of(ReadRun(run, (ReadLog("ft", summary, ()),)))
        (log,) = stored_text(text, lambda _: (True, {"wrench": COLUMNS["wrench"]}, {})).read.logs
        logs["ft", log.summary.file, run] = log.summary
    assert [own.runs for own in copied_runs(logs)] == [("a", "b")]


def write_rounded(original: Path, copy: Path, decimals: int | None) -> None:
    """Write a copy of a log, its numbers behind the first column with so many decimals; None: as they are."""
    head, *rows = original.read_text(encoding="utf-8").splitlines()
    if decimals is not None:
        cells = (row.split(",") for row in rows)
        rows = [",".join([first, *(f"{float(cell):.{decimals}f}" for cell in rest)]) for first, *rest in cells]
    copy.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")


@pytest.mark.parametrize("decimals", [None, 2])
def test_check_and_ingest_say_once_that_a_load_run_is_a_copy(tmp_path: Path, decimals: int | None) -> None:
    write_head(tmp_path)
    write_runs(tmp_path, 1, 4)
    for log in ("log", "tracker"):
        write_rounded(tmp_path / f"raw/run1_{log}.csv", tmp_path / f"raw/run3_{log}.csv", decimals)
    for answer in (check_campaign(tmp_path), ingest_campaign(tmp_path), check_campaign(tmp_path)):
        about = [text for text in answer.warnings if text.startswith(("copied logs", "identical rows"))]
        assert len(about) == 1
        assert "runs run1 and run3 (raw/run1_log.csv, raw/run3_log.csv, " in about[0]


def test_check_says_that_a_friction_run_is_a_copy(tmp_path: Path) -> None:
    folder = rehearsed(tmp_path / "cell", {"friction.speeds_rad_s": [0.3, 0.6], "friction.longest_s": 1.5})
    write_rounded(folder / "raw/joint1.csv", folder / "raw/joint2.csv", 3)
    set_keys(folder / "campaign.toml", {"runs.1.moved_joint": 1})
    (warning,) = [text for text in check_campaign(folder).warnings if text.startswith("copied logs")]
    assert "raw/joint1.csv, raw/joint2.csv" in warning

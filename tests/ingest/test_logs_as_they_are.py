"""Logs as instruments leave them: each fault put into the raw logs of a run of campaigns/irb4400, and what is said.

A fault is refused with its place, or reported with what was done and is left to decide; nothing is mended without a
line that says so.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign
from tests.laboratory.hidden_campaigns import edit
from tests.laboratory.simulation_folders import IRB4400

Table = NDArray[np.float64]
FORCE, DIGITIZER = "raw/pose1_force.csv", "raw/pose1_digitizer.csv"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The campaign with its first run, as simulated."""
    source = tmp_path_factory.mktemp("source")
    for name in ("campaign.toml", "robot.toml", "model.toml", "simulate.toml"):
        text = (IRB4400 / name).read_text(encoding="utf-8")
        second = text.find("[[runs]]", text.find("[[runs]]") + 1)
        (source / name).write_text(text[:second] if "[[runs]]" in text else text, encoding="utf-8")
    out = tmp_path_factory.mktemp("logs") / "irb4400"
    simulate_campaign(load_campaign(source, check_files=False), load_settings(source), out)
    return out


@pytest.fixture
def folder(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "irb4400"))


def change(path: Path, act: Callable[[Table], Table]) -> None:
    """Change the numbers of a text log: rows (n, c), the first column being time."""
    text = path.read_text(encoding="latin-1")
    comma = "," in text.splitlines()[-1]
    head, rows = [], []
    for line in text.splitlines():
        try:
            rows.append([float(cell.replace(",", ".")) for cell in line.split(";")])
        except ValueError:
            head.append(line)
    lines = [";".join(f"{value:.6f}" for value in row) for row in act(np.array(rows))]
    body = "\n".join(line.replace(".", ",") if comma else line for line in lines)
    path.write_text("\n".join([*head, body]) + "\n", encoding="latin-1")


def said(folder: Path) -> list[str]:
    """Return the warnings of ingest, which are check's too."""
    reported = list(ingest_campaign(folder).warnings)
    assert sorted(document_of(check_campaign(folder))["warnings"]) == sorted(reported)
    return reported


def refused(folder: Path) -> str:
    """Return the fault that ingest and check name."""
    with pytest.raises(InputError) as raised:
        ingest_campaign(folder)
    with pytest.raises(InputError) as checked:
        check_campaign(folder)
    assert str(checked.value.faults[0]) == str(raised.value.faults[0])
    assert raised.value.faults[0].mend
    return str(raised.value.faults[0])


def middle(table: Table) -> float:
    return float(0.5 * (table[0, 0] + table[-1, 0]))


def test_nothing_is_said_of_a_clean_log(folder: Path) -> None:
    assert said(folder) == []


def test_gaps_are_reported_one_by_one(folder: Path) -> None:
    def cut(table: Table) -> Table:
        time = table[:, 0] / 1e3
        return table[~((time > 30) & (time < 31)) & ~((time > 60) & (time < 60.5))]

    change(folder / FORCE, cut)
    (line,) = said(folder)
    assert line.startswith(f"{FORCE}: a gap of 1.00 s before 31.000 s")
    assert "all: 30.000 … 31.000 s, 60.000 … 60.500 s" in line
    assert "gaps are not filled" in line


@pytest.mark.parametrize(("to", "words"), [(99, "time does not advance"), (50, "time decreases")])
def test_repeated_and_reversed_times_are_refused_with_their_line(to: int, words: str, folder: Path) -> None:
    def misplace(table: Table) -> Table:
        table[100, 0] = table[to, 0]
        return table

    change(folder / FORCE, misplace)
    line = refused(folder)
    assert f"{FORCE}: line 108: {words}" in line
    assert "exclude row 101 with [[exclude]]" in line
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    out = '[[exclude]]\nsource = "force"\nrows = [101]\nwhy = "misplaced"\n'
    (folder / "campaign.toml").write_text(text + out, encoding="utf-8")
    assert said(folder) == []


@pytest.mark.parametrize("jump", [0.3, -0.25])
def test_a_clock_that_jumps(jump: float, folder: Path) -> None:
    def set_clock(table: Table) -> Table:
        table[table[:, 0] > middle(table), 0] += jump
        return table

    change(folder / DIGITIZER, set_clock)
    (line,) = [line for line in said(folder) if "clock" in line]
    assert "the clock of digitizer jumps by" in line
    assert float(line.split("jumps by ")[1].split(" s")[0]) == pytest.approx(jump, abs=0.1)
    assert "one offset is used" in line
    assert "split the run there" in line


@pytest.mark.parametrize("ppm", [2000.0, -800.0])
def test_a_clock_that_drifts(ppm: float, folder: Path) -> None:
    def stretch(table: Table) -> Table:
        table[:, 0] *= 1.0 + 1e-6 * ppm
        return table

    change(folder / DIGITIZER, stretch)
    (line,) = said(folder)
    assert "the clock of digitizer gains" in line
    value, spread = line.split("gains ")[1].split(" ppm")[0].split(" ± ")
    assert abs(float(value) - ppm) < 2.0 * float(spread) + 60.0  # 36 ppm lie between the two as simulated
    assert "one offset, that of its middle, is used" in line


def test_a_drift_that_harms_no_hold_is_measured_all_the_same(folder: Path) -> None:
    def stretch(table: Table) -> Table:
        table[:, 0] *= 1.0 + 150e-6
        return table

    before = ingest_campaign(folder).runs[0].clock_ahead_s["digitizer"]
    change(folder / DIGITIZER, stretch)
    after = ingest_campaign(folder).runs[0].clock_ahead_s["digitizer"]
    # both by the same holds and the same noise: what lies between them is known better than each
    assert before.rate is not None
    assert after.rate is not None
    assert after.rate_std is not None
    assert after.rate - before.rate == pytest.approx(150e-6, abs=2.0 * after.rate_std)
    assert after.rate_std < 60e-6


def test_a_clock_that_is_set_by_a_minute(folder: Path) -> None:
    def set_clock(table: Table) -> Table:
        table[table[:, 0] > middle(table), 0] += 60.0
        return table

    change(folder / DIGITIZER, set_clock)
    fault = refused(folder)
    assert "clock of digitizer: its clock was set" in fault
    assert DIGITIZER in fault


def test_a_sensor_at_its_end(folder: Path) -> None:
    def clip(table: Table) -> Table:
        table[:, 1:] = np.clip(table[:, 1:], -300.0, 300.0)
        return table

    change(folder / FORCE, clip)
    reported = said(folder)
    assert any(line.startswith(FORCE) and "stays at its extreme" in line and "saturated?" in line for line in reported)
    assert not any("was stuck" in line for line in reported)


def test_a_channel_that_sticks(folder: Path) -> None:
    def stick(table: Table) -> Table:
        table[1000:1200, 2] = table[1000, 2]
        return table

    change(folder / FORCE, stick)
    (line,) = [line for line in said(folder) if "does not change" in line]
    assert "column Fy does not change over 200 readings, line 1008 to line 1207 (rows 1001-1200)" in line
    assert "used as they are: exclude these rows with [[exclude]]" in line
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    out = '[[exclude]]\nsource = "force"\nrows = ["1001-1200"]\nwhy = "stuck"\n'
    (folder / "campaign.toml").write_text(text + out, encoding="utf-8")
    assert not [line for line in said(folder) if "does not change" in line]


def test_a_channel_that_is_dead_from_the_beginning(folder: Path) -> None:
    def stick(table: Table) -> Table:
        table[:, 2] = 3.5
        return table

    change(folder / FORCE, stick)
    assert refused(folder).startswith(f"{FORCE}: column Fy is constant at 3.5; check the sensor")  # not: upside down


def test_a_channel_that_is_dead_in_one_run(folder: Path) -> None:
    for name in (FORCE, DIGITIZER, "raw/pose1_joints.h5"):
        shutil.copy(folder / name, folder / name.replace("pose1", "pose2"))
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    run = text[text.index("[[runs]]") :]
    (folder / "campaign.toml").write_text(text + "\n" + run.replace("pose1", "pose2"), encoding="utf-8")

    def stick(table: Table) -> Table:
        table[:, 2] = 0.0
        return table

    change(folder / FORCE, stick)
    reported = said(folder)
    assert any(line.startswith(f"{FORCE}: column Fy reads 0 throughout, unlike in other logs") for line in reported)


def test_a_lost_target_given_as_zeros(folder: Path) -> None:
    def lose(table: Table) -> Table:
        table[100:105, 1:] = 0.0
        return table

    change(folder / DIGITIZER, lose)
    line = refused(folder)
    assert line.startswith(f"{DIGITIZER}: line 105: the position is zero in all columns")
    assert 'rows = "X != 0"' in line
    edit(folder / "campaign.toml", ('position = ["X", "Y", "Z"]', 'position = ["X", "Y", "Z"]\nrows = "X != 0"'))
    assert any("a gap of" in line or not line for line in [*said(folder), ""])  # what was left out is a gap


def test_a_lost_target_given_as_nan(folder: Path) -> None:
    lines = (folder / DIGITIZER).read_text(encoding="latin-1").splitlines()
    lines[104] = lines[104].split(";")[0] + ";NaN;NaN;NaN"
    (folder / DIGITIZER).write_text("\n".join(lines) + "\n", encoding="latin-1")
    assert refused(folder).startswith(f"{DIGITIZER}: line 105, column X")


def test_a_lost_target_given_as_its_last_value(folder: Path) -> None:
    def repeat(table: Table) -> Table:
        table[100:112, 1:] = table[100, 1:]
        return table

    change(folder / DIGITIZER, repeat)
    (line,) = [line for line in said(folder) if "does not change" in line]
    assert line.startswith(
        f"{DIGITIZER}: the position (X, Y, Z) does not change over 12 readings, line 105 to line 116"
    )
    assert "the target was lost" in line


@pytest.mark.parametrize("loaded", [True, False])
def test_a_sensor_that_is_zeroed_in_the_middle(loaded: bool, folder: Path) -> None:
    offset = np.zeros(3)

    def zero(table: Table) -> Table:
        size = np.linalg.norm(table[:, 1:], axis=1)
        half = np.arange(len(table)) > len(table) // 2
        at = int(np.flatnonzero(half & (size > 400.0 if loaded else size < 10.0))[20])
        offset[:] = -table[at, 1:] if loaded else (60.0, -20.0, 30.0)
        table[at:, 1:] += offset
        return table

    change(folder / FORCE, zero)
    # zeroed under load, the sensor reads loads where there are none: no result is better than that one
    reported = [refused(folder)] if loaded else [line for line in said(folder) if "zero was reset" in line]
    assert len(reported) == 1
    assert "run pose1: between states" in reported[0]
    assert "the force sensor's zero was reset" in reported[0]
    assert "split the run there" in reported[0]


@pytest.mark.parametrize("hours", [-1, 1])
def test_daylight_saving(hours: int, folder: Path) -> None:
    path = folder / DIGITIZER
    lines = path.read_text(encoding="latin-1").splitlines()
    began = datetime(2026, 10, 25, 2, 58, tzinfo=UTC)
    for number in range(4, len(lines)):
        time, *cells = lines[number].split(";")
        moment = began + timedelta(seconds=float(time.replace(",", ".")))
        moment += timedelta(hours=hours if number > 150 else 0)
        lines[number] = ";".join([moment.isoformat().removesuffix("+00:00"), *cells])
    path.write_text("\n".join(lines) + "\n", encoding="latin-1")
    edit(folder / "campaign.toml", ('column = "Zeit", unit = "s"', 'column = "Zeit", unit = "iso8601"'))
    line = refused(folder)
    assert line.startswith(f"{DIGITIZER}: line 152: time ")
    assert ("goes back by an hour" if hours < 0 else "jumps by an hour") in line
    assert "daylight saving" in line
    assert "+02:00" in line

"""Runs that were read are not read again; what comes out is the same to the last bit, whatever was read when."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import pyarrow.parquet as parquet
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.ingest import ingest_campaign, is_stale
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.ingest.parts import READ_RUNS, READ_STATES
from stiffcal.ingest.reading import logs_of_runs, run_readings
from stiffcal.measurements.columns import column_of, values_of
from stiffcal.propose.templates import write_template
from stiffcal.reduction.logs import log_rows as logs
from stiffcal.reduction.states import tabled_states
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign
from stiffcal.stages.steps import RunContext, key_of_table, up_to_date_states
from stiffcal.store import Store
from tests.ingest.test_logged_runs import HEAD, SPLIT, campaign_of
from tests.laboratory.delivered_store import forge_table
from tests.laboratory.friction_campaigns import rehearsed
from tests.laboratory.once import folder_once
from tests.laboratory.small_campaign import CAMPAIGN, write_small_campaign
from tests.long_campaigns.campaign import write_head, write_runs

RUNS = 4


def _write(folder: Path) -> None:
    write_head(folder)
    write_runs(folder, 1, RUNS + 1)
    ingest_campaign(folder)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A campaign of four runs, ingested."""
    return Path(shutil.copytree(folder_once(_write), tmp_path / "campaign", symlinks=True))


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The logs that are read, in order."""
    files: list[str] = []

    def noted(folder: Path, name: str, source: Any, of_signals: Any, *rest: Any, **named: Any) -> Any:
        files.extend(of_signals.values())
        return logs.read_rows(folder, name, source, of_signals, *rest, **named)

    monkeypatch.setattr(logs_of_runs, "read_rows", noted)
    return files


def answers(folder: Path) -> tuple[str, ...]:
    """Return all that a campaign's ingest and check answer, and its states to the last bit."""
    ingested = replace(ingest_campaign(folder), changed="", unchanged=False)
    states = Store(folder / "store").read_table("states")
    documents = json.dumps([document_of(ingested), document_of(check_campaign(folder))])
    return documents, key_of_table(states), str(states.schema.metadata)


def from_nothing(folder: Path) -> tuple[str, ...]:
    """Return the same of a store that is made from all logs."""
    shutil.rmtree(folder / "store")
    return answers(folder)


def test_runs_that_come_one_by_one_give_what_all_give_at_once(tmp_path: Path, read: list[str]) -> None:
    folder = tmp_path / "campaign"
    write_head(folder)
    for number in range(1, RUNS + 1):
        write_runs(folder, number, number + 1)
        read.clear()
        check_campaign(folder)
        new = [f"raw/run{number}_log.csv", f"raw/run{number}_tracker.csv"]
        assert read == new
        ingest_campaign(folder)
        assert read == new * 2
        check_campaign(folder)
        assert read == new * 2
    assert answers(folder) == from_nothing(folder)


def edit_log(folder: Path) -> None:
    log = folder / "raw" / "run2_log.csv"
    lines = log.read_text().splitlines()
    cells = lines[40].split(",")
    log.write_text(
        "\n".join([*lines[:40], ",".join([*cells[:-1], f"{float(cells[-1]) + 1.0:.6g}"]), *lines[41:]]) + "\n"
    )


def edit_manifest(old: str, new: str) -> Callable[[Path], None]:
    def edit(folder: Path) -> None:
        manifest = folder / "campaign.toml"
        assert old in manifest.read_text()
        manifest.write_text(manifest.read_text().replace(old, new))

    return edit


def remove_run(folder: Path) -> None:
    for log in (folder / "raw").glob("run1_*"):
        log.unlink()


def weigh_link(folder: Path) -> None:
    robot = folder / "robot.toml"
    robot.write_text(robot.read_text().replace("mass_kg = 90.0", "mass_kg = 91.0"))


def remove_recording(folder: Path) -> None:
    (folder / "store" / "current" / "recordings" / "run3" / "tracker.parquet").unlink()


EXCLUDED = '\n[[exclude]]\nsource = "tracker"\nrun = "run3"\nrows = ["10-12"]\nwhy = "a test"\n'
EDITS: dict[str, tuple[Callable[[Path], None], tuple[str, ...]]] = {
    "nothing": (lambda folder: None, ()),
    "a log": (edit_log, ("run2",)),
    "one run's clock": (
        edit_manifest("[frames", '[[runs]]\nid = "run3"\nclock_ahead_s = { tracker = 0.0 }\n[frames'),
        ("run3",),
    ),
    "one run's use": (edit_manifest("[frames", '[[runs]]\nid = "run3"\nholdout = true\n[frames'), ()),
    "rows of one run": (
        edit_manifest('units = { position = "mm" } }\n', f'units = {{ position = "mm" }} }}\n{EXCLUDED}'),
        ("run3",),
    ),
    "all runs' unit": (edit_manifest('position = "mm"', 'position = "cm"'), ("run1", "run2", "run3", "run4")),
    "a frame": (edit_manifest("-0.04, 0.1", "-0.05, 0.1"), ()),
    "the robot": (weigh_link, ()),
    "a run less": (remove_run, ()),
    "a recording that is gone": (remove_recording, ("run3",)),
}


@pytest.mark.parametrize("what", EDITS)
def test_after_an_edit_what_hangs_on_it_is_read_and_the_answers_are_those_of_all_logs(
    what: str, folder: Path, read: list[str]
) -> None:
    edit, runs = EDITS[what]
    edit(folder)
    try:
        found = answers(folder)
    except InputError as error:
        found = (str(error),)
    assert {Path(file).name.partition("_")[0] for file in read} == set(runs)
    try:
        expected = from_nothing(folder)
    except InputError as error:
        expected = (str(error),)
    assert found == expected


@pytest.mark.parametrize("name", [READ_STATES, READ_RUNS])
def test_readings_in_a_store_that_somebody_else_wrote_are_not_believed(
    name: str, folder: Path, read: list[str]
) -> None:
    true = answers(folder)
    path = (folder / "store" / "current").resolve() / f"{name}.parquet"
    table = parquet.read_table(path)
    column = table.column_names.index("mean wrench 0" if name == READ_STATES else "text")
    old = table.column(column)
    forged = 2.0 * values_of(old) if name == READ_STATES else [text.as_py().replace("[", "[", 1) + " " for text in old]
    forge_table(folder, name, table.set_column(column, table.column_names[column], column_of(forged)))
    read.clear()
    with (folder / "campaign.toml").open("a") as manifest:
        manifest.write('\n[[runs]]\nid = "run4"\nholdout = true\n')
    check_campaign(folder)
    assert len(read) == 2 * RUNS
    found = answers(folder)
    assert len(read) == 4 * RUNS
    assert found == from_nothing(folder)
    assert found != true  # run4 is held out


def test_one_log_of_several_runs_is_read_where_it_changed(tmp_path: Path, read: list[str]) -> None:
    folder = campaign_of(tmp_path, HEAD, SPLIT)
    ingest_campaign(folder)
    read.clear()
    (folder / "campaign.toml").write_text((folder / "campaign.toml").read_text() + "\n[thresholds]\nmax_rms_m = 1.0\n")
    (folder / "robot.toml").write_text((folder / "robot.toml").read_text() + "\n")
    found = answers(folder)
    assert read == []
    assert found == from_nothing(folder)


def test_what_cannot_be_read_in_the_store_is_read_from_the_logs(folder: Path, read: list[str]) -> None:
    """A store of the user's own in which a table is damaged."""
    path = (folder / "store" / "current").resolve() / f"{READ_STATES}.parquet"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)
    up_to_date_states(folder, RunContext())
    assert len(read) == 2 * RUNS
    assert answers(folder) == from_nothing(folder)


def test_an_ingest_that_is_interrupted_goes_on_where_it_was(
    tmp_path: Path, read: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "campaign"
    write_head(folder)
    write_runs(folder, 1, RUNS + 1)
    monkeypatch.setattr(run_readings, "CHECKPOINT_S", 0.0)

    def stop(text: str, fraction: float | None = None) -> None:
        if text == "reading raw/run3_tracker.csv":
            raise KeyboardInterrupt

    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            ingest_campaign(folder, progress=stop)
    assert Store(folder / "store").tables
    assert is_stale(folder)
    with pytest.raises(InputError):
        up_to_date_states(folder, RunContext(update=False))
    found = answers(folder)
    assert {file: read.count(file) for file in read} == {**dict.fromkeys(read, 1), "raw/run3_log.csv": 3}
    assert found == from_nothing(folder)


def test_tables_of_single_runs_are_read_once(tmp_path: Path, read: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    folder = write_small_campaign(tmp_path / "campaign", poses=3)
    table = folder / "raw" / "states.csv"
    head, *rows = table.read_text().splitlines(keepends=True)
    table.unlink()
    manifest = CAMPAIGN.replace('run = { column = "run" }\n', "").replace("states.csv", "{run}.csv")
    (folder / "campaign.toml").write_text(manifest)
    monkeypatch.setattr(tabled_states, "read_rows", vars(logs_of_runs)["read_rows"])
    for number in range(1, 4):
        own = [row for row in rows if row.startswith(f"pose{number},")]
        (folder / "raw" / f"pose{number}.csv").write_text(head + "".join(own))
        read.clear()
        ingest_campaign(folder)
        check_campaign(folder)
        assert read == [f"raw/pose{number}.csv"]
    # a copy of a row with fewer digits: rows of all tables are compared
    cells = next(row for row in reversed(rows) if row.startswith("pose1,")).split(",")
    rounded = [f"{float(cell):.1f}" for cell in cells[10:13]]
    log = folder / "raw" / "pose1.csv"
    log.write_text(log.read_text() + ",".join([*cells[:10], *rounded, *cells[13:]]))
    read.clear()
    found = answers(folder)
    assert read == ["raw/pose1.csv"]
    assert found == from_nothing(folder)


def rods(folder: Path) -> Path:
    """Write the rehearsal of rods that `init --kind ids` offers."""
    plan = folder.parent / "plan"
    write_template(plan, "ids")
    simulate_campaign(load_campaign(plan, check_files=False), load_settings(plan), folder)
    return folder


def change_one_reading(log: Path, dataset: str) -> None:
    """Change a reading in the middle of a log, by less than its noise."""
    if log.suffix == ".h5":
        with h5py.File(log, "r+") as file:
            values = file[dataset]
            values[len(values) // 2] *= 1.0 + 1e-9
        return
    lines = log.read_text().splitlines()
    row = len(lines) // 2
    *before, last = lines[row].split(",")
    number = f"{float(last) * (1.0 + 1e-4):.9g}"
    log.write_text("\n".join([*lines[:row], ",".join([*before, number]), *lines[row + 1 :]]) + "\n")


@pytest.mark.long
@pytest.mark.parametrize(("write", "source"), [(rehearsed, "controller"), (rods, "ids")])
def test_of_other_kinds_the_run_whose_log_was_edited_is_read_again(
    write: Callable[[Path], Path], source: str, tmp_path: Path, read: list[str]
) -> None:
    folder = write(tmp_path / "cell")
    ingest_campaign(folder)
    runs = load_campaign(folder).manifest.runs
    edited = runs[-1]
    read.clear()
    change_one_reading(folder / edited.files[source], "ids/ids1")
    found = answers(folder)
    assert set(read) == set(edited.files.values())
    assert len(runs) > 1
    assert found == from_nothing(folder)

"""Ingest: what it makes, that nothing changed is nothing done, one clear line per fault with the store untouched."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.ingest import ingest_campaign, is_stale, stored_states
from stiffcal.errors import InputError
from stiffcal.ingest.quality.data_quality import DataQuality
from stiffcal.reduction.logs.log_rows import read_rows
from stiffcal.store import Store
from tests.laboratory.hidden_campaigns import copied, edit, edit_table, first_run_alone


@pytest.fixture(scope="module")
def ingested(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return one raw run, ingested."""
    folder = first_run_alone(tmp_path_factory.mktemp("raw"))
    ingest_campaign(folder)
    return folder


def test_the_document_shows_clocks_states_and_what_was_dropped(ingested: Path) -> None:
    document = Store(ingested / "store").read_document("ingest")
    (run,) = document["runs"]
    assert run["id"] == "pose01"
    assert run["n_states"] == 49
    assert run["clock_ahead_s"]["tracker"]["value"] == pytest.approx(1.3523, abs=0.01)
    assert run["clock_ahead_s"]["tracker"]["std"] < 0.005
    assert run["clock_ahead_s"]["controller"]["value"] is None
    assert "noise" in run["clock_ahead_s"]["controller"]["reason"]
    assert any("before the first load" in dropped["why"] for dropped in run["dropped"])
    assert document["schema"] == "stiffcal/ingest/1"
    assert document["warnings"] == []


def test_an_answer_of_another_shape_is_made_anew(tmp_path: Path) -> None:
    folder = copied("03", tmp_path)
    ingest_campaign(folder)
    store = Store(folder / "store")
    document = store.read_document("ingest")
    del document["runs"][0]["n_states"]
    store.commit(documents={"ingest": document})
    result = ingest_campaign(folder)
    assert result.unchanged is False
    assert "n_states" in result.changed
    assert ingest_campaign(folder).unchanged is True


def test_the_store_is_read_with_one_line(ingested: Path) -> None:
    states = pd.read_parquet(ingested / "store/current/states.parquet")
    assert len(states) == 49
    assert {"run", "A1_rad", "Fx_N", "Mz_Nm", "target_x_m", "target_qw", "set_aside"} <= set(states.columns)
    force = pd.read_parquet(ingested / "store/current/recordings/pose01/ft.parquet")
    assert list(force.columns) == ["time_s", "Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm", "Mz_Nm"]
    assert len(force) == 13915
    tracker = pd.read_parquet(ingested / "store/current/recordings/pose01/tracker.parquet")
    assert tracker["target_x_m"][0] == pytest.approx(1.80766341)


def test_nothing_changed_is_nothing_done(ingested: Path) -> None:
    store = Store(ingested / "store")
    before = store.generation
    result = ingest_campaign(ingested)
    assert result.unchanged is True
    assert store.generation == before
    assert is_stale(ingested) == ""
    assert len(stored_states(ingested, update=False)) == 49


def test_changes_are_named(tmp_path: Path) -> None:
    folder = copied("13-table", tmp_path)
    store = Store(folder / "store")
    ingest_campaign(folder)
    store.commit(documents={"history": {"schema": "x", "fits": []}})
    edit_table(folder, lambda header, rows: rows[4].__setitem__(header.index("Fx"), "8.2"))
    assert is_stale(folder) == "changed: raw/states.csv"
    with pytest.raises(InputError, match="out of date"):
        stored_states(folder, update=False)
    result = ingest_campaign(folder)
    assert result.unchanged is False
    assert "raw/states.csv" in result.changed
    assert "history" in store.documents
    edit(folder / "robot.toml", ("d_m = 0.68", "d_m = 0.681"))
    assert "robot" in is_stale(folder)


def test_frames_to_be_estimated_are_found(tmp_path: Path) -> None:
    folder = copied("01", tmp_path)
    text = (folder / "campaign.toml").read_text()
    begin, end = text.index("[frames.tracker]"), text.index("[frames.ft_sensor]")
    frame = '[frames.tracker]\nparent = "base"\nestimate = true\n'
    (folder / "campaign.toml").write_text(text[:begin] + frame + text[end:])
    registration = ingest_campaign(folder).registration
    assert registration is not None
    assert registration.rms_m < 0.005
    found = registration.frames["tracker"].parent_from_frame
    assert np.linalg.norm(found[:3, 3] - [3.4, -1.1, 0.35]) < 0.01
    assert np.linalg.norm(stored_states(folder).setup.trackers[0].base_from_frame - found) < 1e-12
    # from the store it is the same
    again = ingest_campaign(folder)
    assert again.unchanged
    assert again.registration is not None
    assert np.array_equal(again.registration.frames["tracker"].parent_from_frame, found)


def test_holds_may_be_given(tmp_path: Path) -> None:
    folder = first_run_alone(tmp_path)
    edit(folder / "campaign.toml", ('id = "pose01"', 'id = "pose01"\nstates = "raw/holds.csv"'))
    (folder / "raw" / "holds.csv").write_text("start,end\n1.945,3.945\n4.745,6.745\n7.545,9.545\n")
    assert ingest_campaign(folder).runs[0].n_states == 3
    assert stored_states(folder).time == pytest.approx([2.945, 5.745, 8.545])


def test_given_clocks_are_respected(tmp_path: Path) -> None:
    folder = first_run_alone(tmp_path)
    edit(folder / "campaign.toml", ('id = "pose01"', 'id = "pose01"\nclock_ahead_s = { tracker = 1.35 }'))
    (run,) = ingest_campaign(folder).runs
    assert run.clock_ahead_s["tracker"].value == 1.35


# ---- one fault each


def _column(name: str, change: Callable[[str], str], rows: slice = slice(None)) -> Callable[[Path], None]:
    def act(folder: Path) -> None:
        def change_rows(header: list[str], lines: list[list[str]]) -> None:
            for line in lines[rows]:
                line[header.index(name)] = change(line[header.index(name)])

        edit_table(folder, change_rows)

    return act


def _swap(one: str, other: str) -> Callable[[Path], None]:
    def act(folder: Path) -> None:
        def swap(header: list[str], _: list[list[str]]) -> None:
            a, b = header.index(one), header.index(other)
            header[a], header[b] = header[b], header[a]

        edit_table(folder, swap)

    return act


def _cut_off(folder: Path) -> None:
    path = folder / "raw" / "states.csv"
    path.write_bytes(path.read_bytes()[:-60])


def _missing_column(folder: Path) -> None:
    edit_table(folder, lambda header, rows: header.__setitem__(header.index("Fy"), "Fyy"))


def _upside_down(folder: Path) -> None:
    for name in ("Fy", "Fz", "Ty", "Tz"):
        _column(name, lambda text: str(-float(text)))(folder)


def _manifest(old: str, new: str) -> Callable[[Path], None]:
    return lambda folder: edit(folder / "campaign.toml", (old, new))


def _two_runs_of_one_name(folder: Path) -> None:
    with (folder / "campaign.toml").open("a") as file:
        file.write('\n[[runs]]\nid = "pose01"\n\n[[runs]]\nid = "pose01"\n')


def _five_joints(folder: Path) -> None:
    text = (folder / "robot.toml").read_text()
    cut = text.rindex("[[joints]]")
    rest = text.find("[flange]", cut)
    (folder / "robot.toml").write_text(text[:cut] + (text[rest:] if rest > 0 else ""))


FAULTS: dict[str, tuple[Callable[[Path], None], tuple[str, ...]]] = {
    "cut-off file": (_cut_off, ("raw/states.csv", "line 148")),
    "missing column": (_missing_column, ("raw/states.csv", "'Fy'", "Fyy")),
    "millimetres as metres": (_manifest('position = "mm"', 'position = "m"'), ("metre", "mm")),
    "not a number": (_column("Fz", lambda _: "NaN", slice(6, 7)), ("raw/states.csv", "line 8", "Fz")),
    "time backwards": (
        _column("start", lambda _: "0.5", slice(6, 7)),
        ("raw/states.csv", "line 8", "time decreases"),
    ),
    "two runs with one name": (_two_runs_of_one_name, ("campaign.toml", "pose01")),
    "degrees declared as radians": (
        _manifest('units = { position = "deg" }', 'units = { position = "rad" }'),
        ("raw/states.csv", "line 2", "rad in column A1", "deg"),
    ),
    "millimetres of a position in the column of an angle": (
        _column("A6", lambda _: "-2638.3", slice(6, 7)),
        ("raw/states.csv", "line 8", "column A6", "another quantity"),
    ),
    "sensor upside down": (_upside_down, ("negative work", "upside down", "about x")),
    "acts_on the wrong way round": (
        _manifest('acts_on = "robot"', 'acts_on = "environment"'),
        ('write acts_on = "robot"',),
    ),
    "two joint columns swapped": (_swap("A2", "A3"), ("joint columns A2 and A3 interchanged",)),
    "two force columns swapped": (_swap("Fx", "Fz"), ("wrench.columns", 'write columns = ["Fz", "Fy", "Fx"')),
    "five joints against six columns": (_five_joints, ("5", "6")),
    "a rotation that is none": (
        _manifest("quaternion_wxyz = [0.955336489126, 0, 0, 0.295520206661]", "matrix = [[1,0,0],[0,1,0],[0,1,1]]"),
        ("campaign.toml", "ft_sensor"),
    ),
    "a force of 3e5 N": (_column("Fx", lambda _: "4e5", slice(9, 10)), ("raw/states.csv", "line 11", "Fx")),
    "quaternion with x first": (
        _manifest('["q0", "qx", "qy", "qz"]', '["qx", "qy", "qz", "q0"]'),
        ("quaternion", "w first"),
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_one_clear_line(fault: str, tmp_path: Path) -> None:
    folder = copied("13-table", tmp_path)
    ingest_campaign(folder)
    store = Store(folder / "store")
    before, states = store.generation, (folder / "store/current/states.parquet").read_bytes()
    time.sleep(0.01)
    spoil, words = FAULTS[fault]
    spoil(folder)
    with pytest.raises(InputError) as raised:
        ingest_campaign(folder)
    reported = str(raised.value.faults[0])
    assert "\n" not in reported
    for word in words:
        assert word in reported, reported
    assert all((entry.reason and entry.mend) for entry in raised.value.faults)
    assert store.generation == before
    assert (folder / "store/current/states.parquet").read_bytes() == states


def _tracker(old: str, new: str) -> Callable[[Path], None]:
    return lambda folder: edit(folder / "raw/pose01_tracker.csv", (old, new))


def _cut_off_log(folder: Path) -> None:
    path = folder / "raw/pose01_ft.csv"
    path.write_bytes(path.read_bytes()[:-12])


LOG_FAULTS: dict[str, tuple[Callable[[Path], None], tuple[str, ...]]] = {
    "cut-off log": (_cut_off_log, ("raw/pose01_ft.csv", "line 13916")),
    "time backwards": (_tracker("\n400,0;", "\n300,0;"), ("raw/pose01_tracker.csv", "line 15", "time decreases")),
    "time repeated": (_tracker("\n400,0;", "\n360,0;"), ("raw/pose01_tracker.csv", "line 15", "time does not advance")),
    "millimetres as metres": (_manifest('position = "mm"', 'position = "m"'), ("raw/pose01_tracker.csv", "metres")),
    "degrees as radians": (_manifest('position = "deg"', 'position = "rad"'), ("raw/pose01_joints.csv", "degrees")),
    "acts_on": (_manifest('acts_on = "robot"', 'acts_on = "environment"'), ('write acts_on = "robot"',)),
}


@pytest.mark.parametrize("fault", LOG_FAULTS)
def test_each_fault_of_a_log_is_one_clear_line(fault: str, tmp_path: Path) -> None:
    folder = first_run_alone(tmp_path)
    spoil, words = LOG_FAULTS[fault]
    spoil(folder)
    with pytest.raises(InputError) as raised:
        ingest_campaign(folder)
    reported = str(raised.value.faults[0])
    for word in words:
        assert word in reported, reported
    assert not Store(folder / "store").exists


def test_a_log_is_watched_from_batch_to_batch(tmp_path: Path) -> None:
    campaign = load_campaign(first_run_alone(tmp_path))
    watches = DataQuality(campaign)
    rows = next(read_rows(campaign.folder, "ft", campaign.manifest.sources["ft"], {"": "raw/pose01_ft.csv"}))
    watches.update("ft", "raw/pose01_ft.csv", rows)
    with pytest.raises(InputError, match="line 2: time decreases"):
        watches.update("ft", "raw/pose01_ft.csv", rows)

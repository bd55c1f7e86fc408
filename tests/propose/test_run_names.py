"""What in the names of files is the run's, as laboratories name them."""

from __future__ import annotations

import pytest

from stiffcal.propose.run_names import patterns_of_devices

RANGE = range(1, 12)
SECONDS = {"force": 12, "tracker": 30}


@pytest.mark.parametrize(
    ("name", "patterns"),
    [
        ("raw/pose{k:02d}_{d}.csv", "raw/{run}_{d}.csv"),
        ("raw/pose{k}_{d}.csv", "raw/{run}_{d}.csv"),
        ("raw/2026-11-20_10{m}{s}_{d}_P{k}.txt", "raw/*_{d}_{run}.txt"),
        ("raw/P{k}_{d}_20261120T10{m}{s}.txt", "raw/{run}_{d}_*.txt"),
        ("raw/2026-11-20_10{m}00_{d}.txt", "raw/{run}_{d}.txt"),
        ("raw/{d}/run_{k}.csv", "raw/{d}/{run}.csv"),
        ("raw/{d}_{k:02d}.dat", "raw/{d}_{run}.dat"),
        ("raw/{d}{k}.dat", "raw/{d}{run}.dat"),
        ("raw/P{k}/{d}.csv", "raw/{run}/{d}.csv"),
        ("raw/P{k}/P{k}_{d}.csv", "raw/{run}/{run}_{d}.csv"),
        ("raw/P{k}/2026-11-20 10.{m}.{s} {d}.csv", "raw/{run}/* {d}.csv"),
        ("raw/Messung {k} - Prüfstand {d}.csv", "raw/{run} {d}.csv"),
        ("{d} (a{k}).csv", "{d} ({run}).csv"),
    ],
)
def test_names_of_laboratories(name: str, patterns: str) -> None:
    files = {d: [name.format(d=d, k=k, m=15 + 3 * k, s=s + k) for k in RANGE] for d, s in SECONDS.items()}
    assert patterns_of_devices(files) == {d: patterns.replace("{d}", d) for d in files}


def test_words_name_runs_too() -> None:
    files = {d: [f"raw/{word}_{d}.csv" for word in ("cold", "warm", "hot")] for d in SECONDS}
    assert patterns_of_devices(files)["force"] == "raw/{run}_force.csv"


def test_one_run_is_what_its_files_share() -> None:
    files = {d: [f"raw/pose01_{d}.csv"] for d in SECONDS}
    assert patterns_of_devices(files)["tracker"] == "raw/{run}_tracker.csv"
    assert patterns_of_devices({d: [f"raw/P1/{d}.csv"] for d in SECONDS}, "raw")["tracker"] == "raw/{run}/tracker.csv"
    assert patterns_of_devices({d: [f"raw/{d}.csv"] for d in SECONDS}, "raw") == {}


def test_leading_zeros_that_one_device_leaves_out() -> None:
    files = {"force": [f"F_{k}.csv" for k in RANGE], "laser": [f"L_{k:03d}.csv" for k in RANGE]}
    assert patterns_of_devices(files) == {"force": "F_{run}.csv", "laser": "L_{run}.csv"}


def test_a_name_that_is_made_otherwise_does_not_count() -> None:
    files = {d: [f"raw/pose{k}_{d}.csv" for k in RANGE] for d in SECONDS}
    files["force"] += ["raw/test.csv", "raw/pose3_force_again.csv"]
    assert patterns_of_devices(files) == {d: f"raw/{{run}}_{d}.csv" for d in SECONDS}


def test_a_device_whose_names_share_nothing_has_no_pattern() -> None:
    files = {"force": [f"F_{k}.csv" for k in RANGE], "laser": [f"L_{word}.csv" for word in ("a", "b", "c")]}
    assert "laser" not in patterns_of_devices(files)

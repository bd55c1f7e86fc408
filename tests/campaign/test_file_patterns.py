"""`file = "raw/{run}_force.csv"`: which files are runs, and what is said of those that are none."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.manifest.file_patterns import FilePattern, found_files
from stiffcal.campaign.manifest.found_runs import nothing_found, unpartnered_remarks
from stiffcal.campaign.manifest.tracker_frames import trackers_of_runs
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.natural_order import natural_key
from tests.laboratory.campaign_folders import ROBOT

MANIFEST = """
schema = "stiffcal/campaign/1"
robot = "robot.toml"

[frames.tool]
parent = "flange"

[sources.force]
file = "raw/{run}_force.csv"
time = { column = "t", unit = "s" }
joints = { position = "A1..A6", units = { position = "deg" } }
wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "N" }, axes = "base", point = "tool" }

[sources.tracker]
file = "raw/{run}_tracker.csv"
time = { column = "t", unit = "s" }
pose = { frame = "base", body = "tool", position = ["X", "Y", "Z"], units = { position = "m" } }
"""


def campaign_with(folder: Path, *files: str, manifest: str = MANIFEST) -> Path:
    """Write a campaign whose logs are empty; they are named, not read."""
    (folder / "campaign.toml").write_text(manifest, encoding="utf-8")
    (folder / "robot.toml").write_text(ROBOT, encoding="utf-8")
    (folder / "raw").mkdir()
    for file in files:
        (folder / file).parent.mkdir(exist_ok=True, parents=True)
        (folder / file).write_text("")
    return folder


def pairs(*names: str) -> list[str]:
    return [f"raw/{name}_{device}.csv" for name in names for device in ("force", "tracker")]


def runs_of(campaign: Campaign) -> dict[str, dict[str, str]]:
    return {run.id: run.files for run in campaign.manifest.runs}


def codes_of(folder: Path) -> list[FaultCode]:
    with pytest.raises(InputError) as caught:
        load_campaign(folder)
    return [fault.code for fault in caught.value.faults]


def test_the_runs_are_the_names_that_all_sources_have_in_natural_order(tmp_path: Path) -> None:
    campaign = load_campaign(campaign_with(tmp_path, *pairs("pose10", "pose9", "pose1"), "raw/notes.txt"))
    assert list(runs_of(campaign)) == ["pose1", "pose9", "pose10"]
    assert runs_of(campaign)["pose9"] == {"force": "raw/pose9_force.csv", "tracker": "raw/pose9_tracker.csv"}
    assert unpartnered_remarks(campaign.manifest, campaign.found) == []


@pytest.mark.parametrize(
    ("patterns", "files", "runs"),
    [
        (("raw/force/{run}.csv", "raw/tracker/{run}.csv"), ["raw/force/run_1.csv", "raw/tracker/run_1.csv"], ["run_1"]),
        (("raw/F_{run}.dat", "raw/L_{run}.dat"), ["raw/F_01.dat", "raw/L_01.dat", "raw/L_01.dat.bak"], ["01"]),
        (("raw/{run}/force.csv", "raw/{run}/pose.csv"), ["raw/P 1/force.csv", "raw/P 1/pose.csv"], ["P 1"]),
        (
            ("raw/*_force_{run}.txt", "raw/*_tracker_{run}.txt"),
            ["raw/2026-11-20_101530_tracker_P3.txt", "raw/2026-11-20_101502_force_P3.txt"],
            ["P3"],
        ),
        (("raw/{run}/{run}_F.csv", "raw/{run}/{run}_T.csv"), ["raw/a/a_F.csv", "raw/a/a_T.csv"], ["a"]),
        (("raw/pose{run}.csv", "raw/pose{run}.dat"), ["raw/pose7.csv", "raw/pose7.dat"], ["7"]),
        (("raw/[{run}].csv", "raw/{run}+.csv"), ["raw/[a].csv", "raw/a+.csv"], ["a"]),
        (("raw/F_{run}.csv", "raw/L_{run}.csv"), ["raw/F_1.csv", "raw/L_001.csv"], ["1"]),
    ],
)
def test_names_of_laboratories(tmp_path: Path, patterns: tuple[str, str], files: list[str], runs: list[str]) -> None:
    first, second = patterns
    manifest = MANIFEST.replace("raw/{run}_force.csv", first).replace("raw/{run}_tracker.csv", second)
    manifest = manifest.replace("time =", 'format = "csv"\ntime =')
    campaign = load_campaign(campaign_with(tmp_path, *files, manifest=manifest))
    assert list(runs_of(campaign)) == runs


def test_a_run_has_the_log_of_one_place_of_the_tracker(tmp_path: Path) -> None:
    """Sources of the same target in two frames stand in for each other; nothing stands in for the force."""
    begin = MANIFEST.index("[sources.tracker]")
    moved = MANIFEST[begin:].replace("sources.tracker", "sources.moved").replace("_tracker.csv", "_moved.csv")
    moved = moved.replace('frame = "base"', 'frame = "there"')
    frame = '[frames.there]\nparent = "base"\nestimate = true\n'
    files = [*pairs("a"), "raw/b_force.csv", "raw/b_moved.csv", "raw/c_force.csv", "raw/d_moved.csv"]
    campaign = load_campaign(campaign_with(tmp_path, *files, manifest=MANIFEST + moved + frame))
    assert runs_of(campaign) == {
        "a": {"force": "raw/a_force.csv", "tracker": "raw/a_tracker.csv"},
        "b": {"force": "raw/b_force.csv", "moved": "raw/b_moved.csv"},
    }
    assert campaign.found is not None
    lacking = {entry.run: entry.lacking for entry in campaign.found.unpartnered}
    assert lacking == {"c": ("tracker",), "d": ("force",)}
    assert trackers_of_runs(campaign.manifest) == {"a": 0, "b": 1}


def test_a_name_without_its_partner_is_no_run_and_is_named(tmp_path: Path) -> None:
    campaign = load_campaign(campaign_with(tmp_path, *pairs("a", "b"), "raw/c_force.csv", "raw/d_tracker.csv"))
    assert list(runs_of(campaign)) == ["a", "b"]
    assert campaign.found is not None
    assert [(entry.run, entry.lacking) for entry in campaign.found.unpartnered] == [
        ("c", ("tracker",)),
        ("d", ("force",)),
    ]
    assert len(unpartnered_remarks(campaign.manifest, campaign.found)) == 2


def test_two_files_of_one_run_and_source_are_refused(tmp_path: Path) -> None:
    folder = campaign_with(tmp_path, *pairs("pose1", "pose2"), "raw/pose01_force.csv")
    with pytest.raises(InputError) as caught:
        load_campaign(folder)
    (fault,) = caught.value.faults
    assert fault.code is FaultCode.KEY_CONFLICT
    entry = fault.mend.partition("[[runs]], ")[2].replace(", files", "\nfiles")  # as it is printed
    (folder / "campaign.toml").write_text(f"{MANIFEST}\n[[runs]]\n{entry}\n")
    runs = runs_of(load_campaign(folder))
    assert {name: len(files) for name, files in runs.items()} == {"pose01": 2, "pose2": 2}


def test_a_file_belongs_to_the_pattern_with_more_of_its_name(tmp_path: Path) -> None:
    manifest = MANIFEST.replace("raw/{run}_tracker.csv", "raw/{run}.csv")
    files = ["raw/a_force.csv", "raw/a.csv", "raw/b.csv", "raw/b_force.csv"]
    assert list(runs_of(load_campaign(campaign_with(tmp_path, *files, manifest=manifest)))) == ["a", "b"]


def test_runs_that_are_listed_say_more_of_files_that_are_found(tmp_path: Path) -> None:
    listed = '\n[[runs]]\nid = "b"\nholdout = true\n\n[[runs]]\nid = "again"\nfiles = { force = "raw/c_force.csv" }\n'
    campaign = load_campaign(campaign_with(tmp_path, *pairs("a", "b", "c"), manifest=MANIFEST + listed))
    runs = {run.id: run for run in campaign.manifest.runs}
    assert list(runs) == ["a", "again", "b"]
    assert runs["b"].holdout
    assert runs["b"].files == {"force": "raw/b_force.csv", "tracker": "raw/b_tracker.csv"}
    assert runs["again"].files == {"force": "raw/c_force.csv"}
    assert campaign.found is not None
    assert [entry.files for entry in campaign.found.unpartnered] == [{"tracker": "raw/c_tracker.csv"}]


def test_a_listed_run_that_is_not_measured_yet_is_expected(tmp_path: Path) -> None:
    folder = campaign_with(tmp_path, *pairs("a"), "raw/b_force.csv", manifest=MANIFEST + '\n[[runs]]\nid = "b"\n')
    assert codes_of(folder) == [FaultCode.FILE_MISSING]
    assert list(runs_of(load_campaign(folder, check_files=False))) == ["a", "b"]


def test_no_run_at_all(tmp_path: Path) -> None:
    folder = campaign_with(tmp_path, "raw/P1_force.csv", "raw/T1_tracker.csv")
    assert codes_of(folder) == [FaultCode.FILE_MISSING, FaultCode.FILE_MISSING]
    campaign = load_campaign(folder, check_files=False)
    assert len(nothing_found(campaign.manifest, campaign.found)) == 2


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (('"raw/{run}_force.csv"', '"raw/{run}*.csv"'), FaultCode.VALUE_INVALID),
        (('"raw/{run}_force.csv"', '"../{run}_force.csv"'), FaultCode.FILE_OUTSIDE),
        (("time =", 'run = { column = "run" }\ntime ='), FaultCode.KEY_CONFLICT),
        (('file = "raw/{run}_force.csv"', 'files = { wrench = "raw/{run}.csv" }'), FaultCode.VALUE_INVALID),
    ],
)
def test_patterns_that_mean_nothing(tmp_path: Path, change: tuple[str, str], code: FaultCode) -> None:
    folder = campaign_with(tmp_path, *pairs("a"), manifest=MANIFEST.replace(*change, 1))
    assert code in codes_of(folder)


def test_hidden_files_and_folders_behind_a_link_are_not_listed(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "secret.csv").write_text("")
    folder = tmp_path / "campaign"
    folder.mkdir()
    (folder / ".a.csv").write_text("")
    (folder / "link").symlink_to(elsewhere)
    assert list(FilePattern("link/{run}.csv").files(folder)) == []
    assert list(FilePattern("{run}.csv").files(folder)) == []
    assert list(FilePattern("../elsewhere/{run}.csv").files(folder)) == []


def test_names_that_hide_what_they_are_make_no_run(tmp_path: Path) -> None:
    assert FaultCode.NAME_INVALID in codes_of(campaign_with(tmp_path, *pairs("a", "b\u202e")))


def test_numbers_count_by_their_value() -> None:
    assert natural_key("pose007") == natural_key("pose7") != natural_key("pose70")
    assert sorted(["b2", "a10", "a9", "a"], key=natural_key) == ["a", "a9", "a10", "b2"]


def test_files_that_a_run_names_are_not_matched_again(tmp_path: Path) -> None:
    folder = campaign_with(tmp_path, *pairs("a", "b"))
    patterns = {"force": FilePattern("raw/{run}_force.csv")}
    assert list(found_files(folder, patterns, frozenset({"raw/a_force.csv"})).runs) == ["b"]

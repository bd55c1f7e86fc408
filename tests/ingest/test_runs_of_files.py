"""Runs that files of one pattern make: added later, taken away, and read from a store where no log is left."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.ingest.freshness import freshness_of, with_stored_runs
from stiffcal.ingest.proposals import propose_sources
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.store import Store
from tests.laboratory.small_campaign import CAMPAIGN, write_small_campaign

PATTERN = CAMPAIGN.replace('"raw/states.csv"', '"raw/{run}_states.csv"').replace('run = { column = "run" }\n', "")


def campaign_of_files(folder: Path) -> Path:
    """Write the small campaign with a table for each pose; that of pose 2 lies aside."""
    write_small_campaign(folder, poses=2)
    head, *rows = (folder / "raw/states.csv").read_text().splitlines()
    for run in ("pose1", "pose2"):
        lines = [head, *(row for row in rows if row.startswith(f"{run},"))]
        (folder / f"raw/{run}_states.csv").write_text("\n".join(lines) + "\n")
    (folder / "raw/states.csv").unlink()
    (folder / "raw/pose2_states.csv").rename(folder / "pose2_states.csv")
    (folder / "campaign.toml").write_text(PATTERN)
    return folder


def test_a_file_that_is_added_is_a_run_of_the_next_ingest(tmp_path: Path) -> None:
    folder = campaign_of_files(tmp_path / "campaign")
    assert [run.id for run in ingest_campaign(folder).runs] == ["pose1"]
    (folder / "pose2_states.csv").rename(folder / "raw/pose2_states.csv")
    checked = check_campaign(folder, quick=True)
    assert [run.id for run in checked.runs] == ["pose1", "pose2"]
    assert len([warning for warning in checked.warnings if "pose2" in warning]) == 1
    result = ingest_campaign(folder)
    assert [run.id for run in result.runs] == ["pose1", "pose2"]
    assert "raw/pose2_states.csv" in result.changed
    assert ingest_campaign(folder).unchanged

    shutil.rmtree(folder / "raw")
    data = up_to_date_states(folder, RunContext())
    assert data.missing == ("raw/pose1_states.csv", "raw/pose2_states.csv")
    assert [run.id for run in data.campaign.manifest.runs] == ["pose1", "pose2"]


def test_a_store_names_no_file_outside_the_patterns(tmp_path: Path) -> None:
    folder = campaign_of_files(tmp_path / "campaign")
    ingest_campaign(folder)
    shutil.rmtree(folder / "raw")
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(text.replace("raw/{run}_states.csv", "logs/{run}_states.csv"))
    store = Store(folder / "store")
    campaign = with_stored_runs(load_campaign(folder, check_files=False), store)
    assert campaign.manifest.runs == ()
    assert freshness_of(campaign, store).reason


def test_a_file_of_a_run_that_lacks_another_log_needs_no_source(tmp_path: Path) -> None:
    folder = campaign_of_files(tmp_path / "campaign")
    holds = '[sources.holds]\nfile = "raw/{run}_holds.csv"\ntime = { column = "t", unit = "s" }\n'
    holds += 'joints = { position = "A1..A6", units = { position = "deg" } }\n'
    (folder / "campaign.toml").write_text(PATTERN + holds)
    (folder / "raw/pose1_holds.csv").write_text("t,A1,A2,A3,A4,A5,A6\n0.0,1,2,3,4,5,6\n0.1,1,2,3,4,5,6\n")
    (folder / "pose2_states.csv").rename(folder / "raw/pose2_states.csv")
    campaign = load_campaign(folder, check_files=False)
    assert campaign.found is not None
    assert [entry.run for entry in campaign.found.unpartnered] == ["pose2"]
    assert propose_sources(campaign) == []


def test_files_of_listed_runs_are_proposed_as_runs(tmp_path: Path) -> None:
    folder = campaign_of_files(tmp_path / "campaign")
    (folder / "pose2_states.csv").rename(folder / "raw/pose2_states.csv")
    shutil.copy(folder / "raw/pose2_states.csv", folder / "raw/pose3_states.csv")
    for run in ("pose1", "pose2"):
        (folder / f"raw/{run}_holds.csv").write_text("t,A1,A2,A3,A4,A5,A6\n0.0,1,2,3,4,5,6\n0.1,1,2,3,4,5,6\n")
    (folder / "raw/notes_states.csv").write_text("what,who\n1,2\n")
    for names in (("pose1", "pose2"), ("first", "second")):  # the runs are named like their logs, or otherwise
        listed = (
            '[sources.holds]\ntime = { column = "t", unit = "s" }\n'
            'joints = { position = "A1..A6", units = { position = "deg" } }\n'
            f'[[runs]]\nid = "{names[0]}"\n'
            'files = { table = "raw/pose1_states.csv", holds = "raw/pose1_holds.csv" }\n'
            f'[[runs]]\nid = "{names[1]}"\nfiles = {{ table = "raw/pose2_states.csv" }}\n'
        )
        (folder / "campaign.toml").write_text(PATTERN.replace('file = "raw/{run}_states.csv"\n', "") + listed)
        second, third, notes = propose_sources(load_campaign(folder, check_files=False))
        assert (second.files, third.files) == (["raw/pose2_holds.csv"], ["raw/pose3_states.csv"])
        (mend,) = second.lines
        assert f'"{names[1]}"' in mend
        files = {"table": "raw/pose2_states.csv", "holds": "raw/pose2_holds.csv"}
        assert tomllib.loads(mend[mend.index("files") :])["files"] == files
        (run,) = tomllib.loads("\n".join(third.lines))["runs"]
        assert (run["id"], run["files"]) == ("pose3", {"table": "raw/pose3_states.csv"})
        assert third.lines[-1].startswith("#")
        assert "holds" in third.lines[-1]
        assert notes.files == ["raw/notes_states.csv"]

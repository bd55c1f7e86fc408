"""One log for all runs is split by its run column; nothing that is read is dropped without a word."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.ingest import ingest_campaign
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.store import Store
from tests.laboratory.small_campaign import robot_text

FLANGE_M = (0.95619221, -0.52516348, 2.31314544)  # of the robot at these angles
JOINTS_DEG = (-30.0, -70.0, 20.0, 15.0, 40.0, 10.0)
LEVELS = (0.0, 200.0, 400.0, 200.0, 0.0)
LEVELS_OF = {"a": LEVELS, "b": (*LEVELS, 300.0, 0.0)}

HEAD = """
schema = "stiffcal/campaign/1"
robot = "robot.toml"

[frames.target]
parent = "flange"

[sources.log]
file = "raw/log.csv"
sampling = "time"
time = { column = "t", unit = "s" }
joints = { position = ["A1", "A2", "A3", "A4", "A5", "A6"], units = { position = "deg" } }
wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "N" }, axes = "base", point = "target" }
pose = { frame = "base", body = "target", position = ["X", "Y", "Z"], units = { position = "m" } }
"""
SPLIT = '\nrun = { column = "pose" }\n'
GAUGE = """
displacement = { column = "s", units = { length = "mm" }, body = "target", direction = [0, 0, 1], axes = "base" }
"""


def campaign_of(folder: Path, *parts: str) -> Path:
    """Write a campaign of one log: two runs, every one with its clock from zero."""
    (folder / "raw").mkdir(parents=True)
    (folder / "campaign.toml").write_text("".join(parts), encoding="utf-8")
    (folder / "robot.toml").write_text(robot_text(), encoding="utf-8")
    generator = np.random.default_rng(8)
    lines = ["pose,t,A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,X,Y,Z,s"]
    for run, levels in LEVELS_OF.items():
        if run == "b" and SPLIT not in parts:
            continue
        for k, level in enumerate(np.repeat(levels, 150)):
            force = level * np.array([0.6, 0.0, 0.8]) + generator.normal(size=3)
            place = FLANGE_M + 1e-6 * level * np.array([0.6, 0.0, 0.8]) + 1e-5 * generator.normal(size=3)
            cells = [*JOINTS_DEG, *force, *place, 0.001 * level]
            lines.append(f"{run},{k / 50.0:.3f}," + ",".join(f"{cell:.9g}" for cell in cells))
    (folder / "raw" / "log.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


def states_of(folder: Path) -> dict[str, int]:
    return {run.id: run.n_states for run in ingest_campaign(folder).runs}


@pytest.mark.parametrize("listed", [(), ("a", "b")])
def test_one_log_for_all_runs_is_split(tmp_path: Path, listed: tuple[str, ...]) -> None:
    folder = campaign_of(tmp_path / "c", HEAD, SPLIT, *(f'[[runs]]\nid = "{run}"\n' for run in listed))
    assert states_of(folder) == {"a": 5, "b": 7}
    store = Store(folder / "store")
    assert store.read_table("recordings/a/log").num_rows == 150 * 5
    assert store.read_table("recordings/b/log").num_rows == 150 * 7
    forces = np.array(store.read_table("states").column("Fz_N").to_pylist())
    np.testing.assert_allclose(forces, 0.8 * np.array([*LEVELS_OF["a"], *LEVELS_OF["b"]]), atol=1.0)
    document = document_of(check_campaign(folder))
    assert [run["n_states"] for run in document["runs"]] == [5, 7]
    assert [entry["rows"] for entry in document["sources"]] == [750, 1050]
    assert document_of(check_campaign(folder, quick=True))["n_states"] == 2


def test_a_run_that_is_not_listed_is_refused(tmp_path: Path) -> None:
    folder = campaign_of(tmp_path / "c", HEAD, SPLIT, '[[runs]]\nid = "a"\n')
    with pytest.raises(InputError, match=r"the log of log contains run 'b', which is not listed"):
        ingest_campaign(folder)
    with pytest.raises(InputError, match=r"contains run 'b'"):
        check_campaign(folder)


def test_the_log_of_the_only_run_may_stand_with_its_source(tmp_path: Path) -> None:
    assert states_of(campaign_of(tmp_path / "c", HEAD, '[[runs]]\nid = "only"\n')) == {"only": 5}


def test_a_gauge_is_kept_and_used(tmp_path: Path) -> None:
    folder = campaign_of(tmp_path / "c", HEAD, GAUGE, '[[runs]]\nid = "only"\n')
    for result in (ingest_campaign(folder), check_campaign(folder)):
        assert not [line for line in result.warnings if "not used" in line]
    assert "log_displacement_m" in Store(folder / "store").read_table("recordings/only/log").column_names

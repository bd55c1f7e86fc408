"""Absolute places through the commands: from the table to what is found, for a robot whose error is known."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pypdf import PdfReader

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.cli.app import main
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.balance.equilibrium import solve_balance
from tests.laboratory.absolute_places import on_all_joints, place_setup
from tests.laboratory.robots import SIX_STIFFNESS, six_axis_joints
from tests.laboratory.small_campaign import robot_text

N_POSES, SIGMA_MM = 60, 0.02
CAMPAIGN = """schema = "stiffcal/campaign/1"
[frames.tracker]
parent = "base"
estimate = true
[frames.target1]
parent = "flange"
estimate = true
xyz_m = [0.08, 0.0, 0.12]
[sources.table]
file = "raw/poses.csv"
sampling = "states"
time = { column = "t", unit = "s" }
joints = { position = "A1..A6", units = { position = "deg" } }
[sources.table.poses.target1]
frame = "tracker"
position = ["X1", "Y1", "Z1"]
units = { position = "mm" }
sigma = { position = 0.02 }
[[runs]]
id = "poses"
experiment = "absolute"
"""


def campaign_folder(folder: Path, blunder: Floats | None = None) -> Path:
    """Write a campaign of a robot whose links are 0.3 mm and 0.5 mrad off, and whose joints give."""
    from stiffcal.effects.joint_compliance import JointCompliance
    from stiffcal.effects.link_geometry import LinkGeometry
    from stiffcal.model.assembled.composite import CompliantRobot

    (folder / "raw").mkdir(parents=True)
    (folder / "robot.toml").write_text(robot_text(), encoding="utf-8")
    (folder / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    rng = np.random.default_rng(11)
    joints = six_axis_joints(rng, N_POSES)
    (folder / "raw" / "poses.csv").write_text("t,A1,A2,A3,A4,A5,A6,X1,Y1,Z1\n", encoding="utf-8")
    chain = load_campaign(folder).chain
    errors = [
        dict(zip(("x", "y", "rx", "ry"), rng.normal(0.0, (3e-4, 3e-4, 5e-4, 5e-4)), strict=True)) for _ in range(6)
    ]
    springs = [{"c": 1.0 / float(stiffness)} for stiffness in SIX_STIFFNESS]
    placed = (*on_all_joints(LinkGeometry(), 6, errors), *on_all_joints(JointCompliance(), 6, springs))
    robot = CompliantRobot(chain, placed)
    rest = solve_balance(robot, chain.model_angles(joints), np.zeros((N_POSES, 6)), place_setup(chain))
    turn = rotation_from_vector(np.array([0.01, -0.02, 2.1]))
    places = 1e3 * (rest.target_position[:, 0] - [3.1, -1.4, 0.4]) @ turn + rng.normal(0.0, SIGMA_MM, (N_POSES, 3))
    if blunder is not None:
        places += blunder
    rows = np.column_stack([20.0 * np.arange(N_POSES), np.degrees(joints), places])
    with (folder / "raw" / "poses.csv").open("a", encoding="utf-8") as file:
        file.writelines(",".join(f"{value:.9g}" for value in row) + "\n" for row in rows)
    return folder


def answer(capsys: pytest.CaptureFixture[str], *words: str | Path) -> dict[str, Any]:
    """Return what a command answers; it has to end well."""
    with pytest.raises(SystemExit) as ended:
        main([*map(str, words), "--json"])
    out = capsys.readouterr()
    assert ended.value.code == 0, out.err
    document: dict[str, Any] = json.loads(out.out)
    return document


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return campaign_folder(tmp_path_factory.mktemp("absolute") / "arm")


def test_check_states_rows_of_a_run_and_what_weight_turns(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = answer(capsys, "check", folder)
    assert document["ready"]
    assert [(run["id"], run["experiment"], run["n_states"]) for run in document["runs"]] == [
        ("poses", "absolute", N_POSES)
    ]
    known = {joint["joint"]: joint["expected_relative_std"] for joint in document["joints"]}
    assert known["A1"] is None
    assert 0.0 < known["A2"] < 0.05
    indices = document["observability"]
    assert indices["n_poses"] == N_POSES
    assert 0.0 < indices["O4"] < indices["O3"]
    assert 0.0 < indices["O2"] < 1.0


def test_one_fit_finds_frames_geometry_and_springs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = answer(capsys, "identify", folder)
    assert document["reduced_chi2"] == pytest.approx(1.0, abs=0.4)
    parameters = {parameter["name"]: parameter for parameter in document["parameters"]}
    stiffness = parameters["joint-compliance.j2.c"]
    low, high = stiffness["stiffness_interval"]
    assert low < SIX_STIFFNESS[1] < high
    for name in ("frame.tracker.x", "frame.tracker.rx", "frame.target1.z", "link-geometry.j4.rx"):
        assert parameters[name]["std"] > 0.0
    open_sets = [entry["parameters"] for entry in document["not_identifiable"]]
    assert ["frame.tracker.z"] in open_sets
    assert ["frame.tracker.rz"] in open_sets
    assert {effect["type"] for effect in document["model"]["effects"]} == {"joint-compliance", "link-geometry"}


def test_validate_leaves_regions_out_and_draws_the_ladder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = answer(capsys, "validate", folder)
    assert document["scheme"] == "poses-region"
    assert [entry["label"] for entry in document["by_run"]] == ["poses"]
    distance = document["distance"]
    assert distance["fit"]["rms"] < distance["heldout_random"]["rms"] < 2.0 * np.sqrt(3.0) * 1e-3 * SIGMA_MM
    assert document["rms"]["translation"] == pytest.approx(distance["heldout_region"]["rms"])
    ladder = {step["step"]: step for step in document["ladder"]}
    assert list(ladder) == ["nominal", "frames", "offsets", "geometry", "springs"]
    # 4 n + 3 numbers of geometry and frames; the tracker's two that are fixed are none
    assert [ladder[step]["n_parameters"] for step in ("nominal", "frames", "geometry")] == [0, 9, 27]
    assert ladder["springs"]["heldout_region"] < 0.5 * ladder["geometry"]["heldout_region"]
    assert ladder["geometry"]["heldout_region"] < ladder["frames"]["heldout_region"]
    verdicts = {joint["joint"]: joint["verdict"] for joint in document["elasticity"]["joints"]}
    assert verdicts[2] == verdicts[3] == "identified"


def test_nothing_is_missing_where_nothing_is(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = answer(capsys, "diagnose", folder)
    assert document["missing"] == []
    assert not document["unexplained"]
    assert document["adequate"]
    untested = {entry["effect"] for entry in document["not_tried"]}
    assert {"tracker-frame", "target-offset", "wrench-bias", "clock-offset"} <= untested


def test_drift_counts_from_the_first_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drift = 1.5e-4 * 20.0 * np.arange(N_POSES)[:, None] * np.array([1.0, -0.5, 0.3])
    document = answer(capsys, "diagnose", campaign_folder(tmp_path / "arm", drift))
    assert [entry["effect"] for entry in document["missing"]] == ["thermal-drift"]


def test_the_report_is_made(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = tmp_path / "report.pdf"
    with pytest.raises(SystemExit) as ended:
        main(["report", str(folder), "-o", str(report)])
    assert ended.value.code == 0, capsys.readouterr().err
    assert report.stat().st_size > 10_000
    capsys.readouterr()
    elasticity = answer(capsys, "validate", folder)["elasticity"]
    assert elasticity["verdict"] == "partly-identified"
    first_page = "".join(PdfReader(report).pages[0].extract_text().split())
    assert "".join(elasticity["why"][1:].split()) in first_page

"""campaigns/irb4400: paper 002's robot and procedure (Wang, Zhang and Fuhlbrigge 2009)."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.kinematics import attached_poses, body_poses
from stiffcal.model.assembled.assembly import compliant_robot
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.simulation.played.true_motion import solve_true_runs
from stiffcal.simulation.scene import draw_acts, robot_with_values, tool_weight, true_frames
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign
from stiffcal.validation.validate import validate_fit
from tests.laboratory.simulation_folders import IRB4400

SECTION_III_C = [731.82e3, 488.31e3, 428.61e3, 59.52e3, 56.87e3, 16.55e3]
SECTION_II_C = [386.83e3, 614.62e3, 372.29e3, 112.56e3, 97.79e3, 24.77e3]
FIGURE_6 = [-45.8058, 4.61262, 38.8404, -0.105546, 51.8232, -72.9578]
FIGURE_7 = [-40.1679, 0.9757, 31.8607, 3.2696, 56.7923, -30.5593]


@pytest.fixture(scope="module")
def search_pose() -> ModuleType:
    specification = importlib.util.spec_from_file_location("search_pose", IRB4400 / "search_pose.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules["search_pose"] = module
    specification.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("folder", "stiffness"), [(".", SECTION_III_C), ("figure-2", SECTION_II_C)])
def test_the_stiffness_is_the_paper_s(folder: str, stiffness: list[float]) -> None:
    values = robot_with_values(load_campaign(IRB4400 / folder, check_files=False)).values()
    assert [1.0 / values[f"joint-compliance.j{k}.c"] for k in range(1, 7)] == pytest.approx(stiffness, rel=1e-8)


def test_six_poses_the_two_printed_among_them() -> None:
    settings = load_settings(IRB4400)
    poses = [run.joints_deg for run in settings.runs]
    assert len(poses) == 6
    assert poses[:2] == [FIGURE_6, FIGURE_7]
    assert [run.id for run in load_campaign(IRB4400, check_files=False).manifest.runs] == [
        run.id for run in settings.runs
    ]


def test_zeros_and_axes_are_those_that_the_readme_states() -> None:
    chain = load_campaign(IRB4400, check_files=False).chain
    logged = np.deg2rad(np.array([[0] * 6, [0, 30, 0, 0, 0, 0], [0, 0, 30, 0, 0, 0], FIGURE_6], dtype=np.float64))
    place, turn = (part[:, -1] for part in body_poses(chain, chain.model_angles(logged)))
    np.testing.assert_allclose(place[0], [0.20 + 0.88 + 0.14, 0.0, 0.68 + 0.89 + 0.15], atol=1e-12)
    np.testing.assert_allclose(turn[0] @ [0, 0, 1], [1, 0, 0], atol=1e-12)  # tool forward
    np.testing.assert_allclose(turn[0] @ [1, 0, 0], [0, 0, -1], atol=1e-12)  # its x down
    np.testing.assert_allclose(turn[1], turn[0], atol=1e-12)  # parallel rod: A2 does not tip the upper arm
    assert place[1, 0] > place[0, 0] + 0.4  # A2 leans forward
    assert place[2, 2] < place[0, 2] - 0.4  # A3 lowers the arm
    assert turn[3, 2, 2] < -0.999  # in the caption's pose the tool points straight down


def test_drive_2_turns_the_lower_arm_alone() -> None:
    """Parallel rod: a torque that drive 2 carries moves the upper arm sideways, without tipping it."""
    campaign = load_campaign(IRB4400, check_files=False)
    robot = robot_with_values(campaign).with_values({f"joint-compliance.j{k}.c": 0.0 for k in (1, 3, 4, 5, 6)})
    setup = MeasurementSetup(
        Attachment(0, np.eye(4)), Attachment(7, np.eye(4)), (Attachment(7, np.eye(4)),), ("flange",), True
    )
    joints = campaign.chain.model_angles(np.zeros((1, 6)))
    balance = solve_balance(robot, joints, np.array([[500.0, 0, 0, 0, 0, 0]]), setup)
    # 500 N at the height of the upper arm, which stays level: the lever about axis 2 is the lower arm alone
    turn = 0.89 * 500.0 / 488.31e3
    assert balance.displacement[0, 0, 0] == pytest.approx(0.89 * turn, rel=5e-3)
    assert np.abs(balance.displacement[0, 0, 3:]).max() < 1e-9


def test_loads_deflect_the_robot_by_some_one_and_a_half_millimetres() -> None:
    campaign, settings = load_campaign(IRB4400, check_files=False), load_settings(IRB4400)
    frames = true_frames(campaign, settings)
    acts = draw_acts(campaign, settings, frames, settings.seed)
    for played in solve_true_runs(robot_with_values(campaign), acts, frames, tool_weight(campaign.manifest)):
        moved = played.position["probe_point"] - played.position["probe_point"][0]
        assert 1.2e-3 < np.abs(moved).max() < 2.2e-3
        assert moved.max() > 0.8e-3
        assert moved.min() < -0.8e-3


def test_force_and_probe_frames_are_parallel_and_apart() -> None:
    campaign = load_campaign(IRB4400, check_files=False)
    frames = true_frames(campaign, load_settings(IRB4400))
    force, probe = frames["load_point"], frames["probe_point"]
    np.testing.assert_array_equal(force.transform[:3, :3], probe.transform[:3, :3])
    assert np.abs(force.transform[:3, 3] - probe.transform[:3, 3]).min() > 0.05
    assert campaign.manifest.sources["force"].columns() == ("Time [ms]", "Fx", "Fy", "Fz")


def test_its_logs_are_made_on_the_spot_and_small(tmp_path: Path) -> None:
    campaign, settings = load_campaign(IRB4400, check_files=False), load_settings(IRB4400)
    written = simulate_campaign(campaign, settings, tmp_path / "demo")
    sizes = [(tmp_path / "demo" / name).stat().st_size for name in written["files"]]
    assert len(written["files"]) == 18 + 4
    assert max(sizes) < 1_000_000
    assert written["states"] == 6 * 49
    load_campaign(tmp_path / "demo")
    offsets = [run["clock_ahead_s"]["digitizer"] for run in written["truth"]["runs"]]
    assert np.ptp(offsets) > 0.5


def test_the_six_stiffnesses_come_back_from_the_raw_logs(tmp_path: Path) -> None:
    """χ² of (estimate − truth) under the stated covariance; six degrees of freedom exceed 22.46 once in 1000.

    And in held-out poses 95 % of the deflection goes.
    """
    campaign, settings = load_campaign(IRB4400, check_files=False), load_settings(IRB4400)
    truth = simulate_campaign(campaign, settings, tmp_path / "demo")["truth"]
    demo = load_campaign(tmp_path / "demo")
    reduced = reduce_campaign(demo, no_progress)
    fit = identify_parameters(reduced.states, compliant_robot(demo.chain, demo.model, find_effects()))
    assert fit.free_names == tuple(truth["parameters"])
    found = np.array([fit.parameter(name).value for name in fit.free_names], dtype=np.float64)
    error = found - np.array(list(truth["parameters"].values()))
    assert error @ np.linalg.solve(fit.covariance, error) < 22.46
    assert np.abs(error / found).max() < 0.03
    relative = validate_fit(reduced.states, fit).relative.translation
    assert relative is not None
    assert relative < 0.05
    for run, true in zip(reduced.result.runs, truth["runs"], strict=True):
        ahead = run.clock_ahead_s
        assert ahead["digitizer"].value == pytest.approx(true["clock_ahead_s"]["digitizer"], abs=0.015)
        assert ahead["controller"].value is None  # its joints never move


def test_figure_2_is_the_same_robot() -> None:
    assert (IRB4400 / "figure-2" / "robot.toml").read_bytes() == (IRB4400 / "robot.toml").read_bytes()


def test_the_search_finds_the_pose_of_figure_2(search_pose: ModuleType) -> None:
    found = search_pose.search()
    settings = load_settings(IRB4400 / "figure-2")
    assert list(found.joints_deg) == settings.runs[0].joints_deg
    assert found.first_leg > 0.0
    assert found.second_leg < 0.0
    readme = (IRB4400 / "README.md").read_text(encoding="utf-8")
    assert "--at " + ",".join(f"{angle:g}" for angle in found.joints_deg) in readme


def test_the_tip_of_figure_2_lies_on_axis_6() -> None:
    campaign = load_campaign(IRB4400 / "figure-2", check_files=False)
    frames = true_frames(campaign, load_settings(IRB4400 / "figure-2"))
    logged = np.deg2rad(np.array([[-90.0, 30, -45, 0, 15, 0], [-90.0, 30, -45, 0, 15, 90]]))
    place = attached_poses(campaign.chain, campaign.chain.model_angles(logged), frames["tip"])[0]
    np.testing.assert_allclose(place[0], place[1], atol=1e-12)
